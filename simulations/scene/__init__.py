"""What is asked: the scene as text and as data, checked, resolved to numbers and scaled; which effects are on, and why."""
