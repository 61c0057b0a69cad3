"""The discrete problem: mesh, spaces and stiffness of the body, contact terms, slip memory, surface quantities."""
