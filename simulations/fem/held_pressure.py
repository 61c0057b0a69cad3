"""Pressure of the frictionless problem, held unchanged while the uncoupled tangential problem is solved."""

import numpy as np
from dolfinx import fem

from .surface_points import PointExpression, SurfacePoints


class HeldPressure:
    """State, pressure and nodal forces of the frictionless problem as they were when ``hold`` was called.

    state: all unknowns; pressure: field of the surface points; forces: nodal forces (n,) of the pressure on owned
    nodes, a new array whenever they change.
    """

    def __init__(self, points: SurfacePoints):
        self.body = points.body
        self.state = fem.Function(self.body.space)
        self.pressure = points.field("pressure")
        self.forces = np.zeros(self.body.owned_nodes)

    def hold(self, pressure: PointExpression, forces: np.ndarray):
        """Keep the pressure, its nodal forces, and the body's present state, which is that of the pressure alone."""
        self.forces = forces
        self.state.x.array[:] = self.body.state.x.array
        pressure.into(self.pressure)

    def remove_tangential(self) -> np.ndarray:
        """Take the tangential problem's part out of the body's state; returns it, (dofs,)."""
        tangential = self.body.state.x.array - self.state.x.array
        self.body.state.x.array[:] = self.state.x.array
        return tangential
