"""Open surface ahead of an edge of contact that sticks as it advances, where displacements oscillate."""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np

from .edge_exponents import oscillation
from .material import GradedHalfPlane

LARGEST_ANGLE = 1.4  # of theta: a larger one belongs to points so near to the old edge that they hardly move
CLOSEST = 1e-6  # distance from the old edge, over the advance


@dataclass(frozen=True)
class StuckEdge:
    """Ratio r of sliding to closing of open points while an edge of contact in stick comes closer, coupling included.

    For a small advance of the edge both displacements are those of a singular rate, a complex power of the distance. So
    r is sqrt(alpha) tan(theta) with an angle theta that goes with the logarithm of the distance. One number is left,
    the r of a point that the edge has just reached.

    solid: the half-plane, or what a coating is near the surface. Angles are those on the right of a contact; on
    the left they have the other sign.
    """

    solid: GradedHalfPlane

    @cached_property
    def oscillation(self) -> float:
        """epsilon, see ``edge_exponents.oscillation``."""
        return oscillation(self.solid)

    @property
    def power(self) -> float:
        """Of the distance from an edge of contact, with which the clearance beyond it grows: (3-k)/2."""
        return (3 - self.solid.k) / 2

    def angle(self, distance, advance: float, width: float) -> np.ndarray:
        """Change of theta from a point that the edge has just reached to those at ``distance`` > 0 (n,).

        distance: from where the edge was, [length] as are its advance and the width of the contact before. Points
        closer than the advance are taken until they touch. A contact that grows from a point has no length, and r
        is the same for all that have touched.
        """
        return self._phase(np.asarray(distance), advance, width) - self._phase(np.array([advance]), advance, width)

    def touching(self, distance, width: float) -> np.ndarray:
        """Theta, but for a constant, of the whole way of points that touch once the edge has come so far (n,).

        width: of the contact before. Both are taken from the same place of the edge.
        """
        reached = np.maximum(distance, CLOSEST * width)
        return self._phase(reached, reached, width)

    def turned(self, r, angle):
        """The ratio ``r`` with its theta changed by ``angle``."""
        scale = sqrt(self.solid.alpha)
        return scale * np.tan(np.clip(np.arctan(r / scale) + angle, -LARGEST_ANGLE, LARGEST_ANGLE))

    def _phase(self, distance, advance, width):
        power = self.power + 1j * self.oscillation  # of the rate, integrated
        near = np.maximum(distance / advance, CLOSEST)
        left = np.maximum(near - 1.0, 0.0)  # ahead of the edge as it is now
        moved = near**power - np.where(left > 0, left, 1.0) ** power * (left > 0)
        return np.angle(moved) - self.oscillation * np.log(near + width / advance)
