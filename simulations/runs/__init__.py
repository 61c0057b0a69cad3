"""A simulation from scene to states; its reference, errors, checks, energy and limits."""
