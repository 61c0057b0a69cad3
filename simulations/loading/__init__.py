"""The load schedule, and the steps along it: what is done when Newton fails."""
