"""What is asked: the scene, checked, resolved to numbers and scaled; which effects are on, and why."""
