"""Simulations of frictional contact and fretting: from a scene to files."""

__version__ = "0.1.0"
