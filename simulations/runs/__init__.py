"""A simulation from scene to states; its reference, errors, checks, energy, limits and warnings."""
