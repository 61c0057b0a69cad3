"""Slip memory of friction: the anchor of every surface point, where it last came to rest."""

import numpy as np

from forms import weak_form

from .surface_points import PointExpression, SurfacePoints


class SlipMemory:
    """Anchors of the surface points and their contact states when they came to rest.

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
