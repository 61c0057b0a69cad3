"""The discrete problem: mesh, spaces and stiffness of the elastic body, contact terms, slip memory, surface quantities."""
