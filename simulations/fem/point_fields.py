"""What contact terms read at surface points beside u: slip memory, contact states imposed on a step, held pressure."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from dolfinx import fem

from forms import contact, weak_form

from .surface_points import PointExpression, SurfacePoints


class SlipMemory:
    """Anchors of the surface points, where they last came to rest, and the contact states that they had then.

    anchor, at_rest: fields of the points; the law has the anchor in its forms. Zero at first: at rest at s = 0, OPEN.
    """

    def __init__(self, points: SurfacePoints, law: weak_form.Contact):
        self.points = points
        self.anchor, self.at_rest = law.friction.anchor, points.field("contact state at rest")
        self._state = PointExpression(points, law.state)
        self._rest, self._released = PointExpression(points, law.rest), PointExpression(points, law.released)

    def release(self):
        """Start friction here: no tangential traction, and none of the present displacement is slip."""
        self._released.into(self.anchor)

    def come_to_rest(self):
        """End a load step: anchor every point where it came to rest (return mapping)."""
        self._state.into(self.at_rest)
        self._rest.into(self.anchor)

    def states_at_rest(self) -> np.ndarray:
        """Contact states of this rank's points (m,) when the last load step ended; OPEN before the first."""
        return self.at_rest.x.array[self.points.dofs]

    def rest_positions(self) -> np.ndarray:
        """Where this rank's points would be anchored now (m,)."""
        return self._rest.values()

    def anchors(self) -> np.ndarray:
        """Where this rank's points are anchored (m,)."""
        return self.anchor.x.array[self.points.dofs]

    def move_anchors(self, positions: np.ndarray):
        """Anchor this rank's points at these positions (m,)."""
        self.anchor.x.array[self.points.dofs] = positions
        self.anchor.x.scatter_forward()


class NewtonSafeguards:
    """Contact states imposed on a single step of Newton's method; they are not in the test of what is accepted."""

    def __init__(self, points: SurfacePoints, law: weak_form.Contact):
        self._points, self._imposed = points, law.friction.imposed

    @contextmanager
    def imposed(self, values: np.ndarray) -> Iterator[None]:
        """Meanwhile contact states are imposed on this rank's points: values (m,) of ``contact.slides``, 0 for none."""
        self._imposed.x.array[self._points.dofs] = values
        self._imposed.x.scatter_forward()
        try:
            yield
        finally:
            self._imposed.x.array[:] = 0.0

    def all_stick(self):
        """The predictor: meanwhile every point in contact sticks."""
        return self.imposed(np.full(len(self._points.dofs), contact.PINNED))


class HeldPressure:
    """The frictionless problem as it was when ``hold`` was called: unchanged while the uncoupled tangential one is
    solved.

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
