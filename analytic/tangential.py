"""Tangential loading without friction: shift (12)-(14), displacements (23), tractions (24)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .checks import require, require_positive_k
from .cumulative import beta_density, beta_fraction
from .material import GradedHalfPlane
from .profile import Profile, abel_factor, density_power
from .punch_superposition import PunchSuperposition
from .quadrature import nodes_for, two_sided_rule
from .special import punch_displacement, punch_relative_displacement, punch_rigid_factor


@dataclass(frozen=True)
class UniformShift:
    """Region |x| <= a shifted as a whole by the line load Q; fields take x of any shape.

    a: half-width [length], positive, else ValueError; Q: [stress x length].
    """

    solid: GradedHalfPlane
    a: float
    Q: float

    def __post_init__(self):
        require("a", self.a)

    def traction(self, x):
        """q(x) [stress], (12); infinite at |x| = a for Q ≠ 0, zero beyond."""
        if not self.Q:
            return 0 * np.minimum(np.abs(x), self.a)
        return self.Q * beta_density(x, self.a, (1 + self.solid.k) / 2)

    def traction_within(self, x):
        """∫_{-x}^{x} q dx [stress x length]; odd in x."""
        return self.Q * beta_fraction(x, self.a, (1 + self.solid.k) / 2)

    def displacement(self, x):
        """u_x(x) [length], (13). k > 0 only."""
        require_positive_k(self.solid.k, "the displacement of a surface point")
        return self._scale * punch_displacement(np.abs(x), self.a, self.solid.k)

    def relative_displacement(self, x):
        """h_x(x) [length], (14); zero for |x| <= a."""
        return self._scale * punch_relative_displacement(np.abs(x), self.a, self.solid.k)

    @property
    def _scale(self):
        return self.solid.tangential_compliance * self.Q / self.a**self.solid.k


def from_displacement(solid, displacement: Profile, a):
    """Fields (18), (20)-(22) of the relative displacement h_x prescribed for |x| <= a, n_x by (23).

    displacement: h_x as a Profile, zero for |x| <= displacement.flat. Returns a PunchSuperposition.
    """
    require("a", a, displacement.flat)
    k, compliance = solid.k, solid.tangential_compliance
    abel_density = displacement.density_within(k, a)

    def density(s, edge):
        return abel_factor(k, compliance) * abel_density(s)

    power = density_power(displacement, k)
    return PunchSuperposition(k, compliance, density, a, displacement.flat, power)


def from_traction(solid, factor: Callable, factor_slope: Callable, a, edge=0.0):
    """Fields (18), (20)-(22) of q = (1 - x²/a²)^edge factor(x) on |x| <= a, n_x by (24).

    factor, factor_slope: smooth even function [stress] and its derivative, vectorised, for
    0 <= x <= a. edge >= 0, else ValueError; a traction with infinite edges is a UniformShift plus a
    bounded one. Returns a PunchSuperposition.
    """
    require("a", a)
    require("edge", edge, closed_low=True)
    k = solid.k
    half = (1 + k) / 2

    def derivative(x, y):
        """q' (1 - x²/a²)^(1-edge), y = 1 - x²/a²; q' itself for edge = 0."""
        if edge == 0:
            return factor_slope(x)
        return y * factor_slope(x) - 2 * edge * x / a**2 * factor(x)

    def density(s, distance):
        """(24) with the derivative carried out, over theta with x = s cosh(theta)."""
        right = edge - 1 if edge > 0 else 0.0
        shape = np.broadcast(s, distance).shape
        s, distance = (np.broadcast_to(v, shape)[..., None] for v in (s, distance))
        span = 2 * np.arcsinh(np.sqrt(distance / (2 * s)))
        t, rest, weight = two_sided_rule(-k, right, nodes_for(span))
        x = s * np.cosh(span * t)
        y = 2 * s * np.sinh(span * (1 + t) / 2) * np.sinh(span * rest / 2) * (a + x) / a**2
        singular = y**right * rest**-right if edge > 0 else 1.0
        smooth = derivative(x, y) * singular * (s * np.sinh(span * t) / t) ** -k
        at_edge = 0.0
        if edge == 0:
            at_edge = factor(np.full(shape, a)) * (distance * (a + s))[..., 0] ** -half
        return 2 / punch_rigid_factor(k) * s[..., 0] * (at_edge - span[..., 0] * (smooth @ weight))

    return PunchSuperposition(k, solid.tangential_compliance, density, a, edge_power=edge - half)
