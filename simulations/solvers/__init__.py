"""Newton's method (PETSc SNES) and the two ways to solve one step."""
