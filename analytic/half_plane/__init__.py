"""The mesh-free reference solver: frictional contact on the surface of a half-plane, with coupling, and its kernels."""
