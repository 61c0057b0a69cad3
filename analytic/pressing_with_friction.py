"""Exact contact of a power profile A|x|^m pressed on with friction from first contact, coupling [X6] included.

The kernel is homogeneous, so that the contact stays similar to itself while it grows (Spence): no load steps. It is a
sum of the flat punches of `punch_with_friction`, of half-width s and load dP = C s^(m+k-1) ds, each with the same c/s:

    p(x) = ∫_x^a p_1(x/s) dP/s ,  q the same ,  h_x(x) = -K ∫ u_1(x/s) s^-k dP  for  x < s < min(a, x/c) ,

where K = y0^k/E0, and p_1 and u_1 belong to the punch of half-width 1 and load 1 for E0 = y0 = 1. Then u_x is
proportional to x|x|^(m-1) where it sticks.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from .checks import require
from .material import GradedHalfPlane
from .profile import PowerProfile
from .punch_fields import PunchFields
from .punch_with_friction import TERMS, Medium, punch_with_friction


@dataclass(frozen=True)
class PressingWithFriction:
    """Power profile pressed by a line load from first contact, |q| <= mu p; fields take x of any shape.

    P: load per unit length [stress x length], positive; mu: friction coefficient, positive, else ValueError.
    terms: resolution.
    """

    solid: GradedHalfPlane
    profile: PowerProfile
    mu: float
    P: float
    terms: int = TERMS

    def __post_init__(self):
        require("mu", self.mu)
        require("P", self.P)

    # -- edges and scalars -------------------------------------------------------------------------

    @cached_property
    def stick_ratio(self):
        """c/a, for any P and A: 1 at the Holl ratio; 0 for k < 0 and weak friction, where every point slips."""
        return float(self._fields.punch.c) if self._fields.punch.sticks else 0.0

    @property
    def power(self):
        """m + k, the power of a in P."""
        return self.profile.m + self.solid.k

    @cached_property
    def contact_half_width(self):
        """a [length]."""
        return (self.power * self.P / self._density) ** (1 / self.power)

    @property
    def stick_half_width(self):
        """c [length]."""
        return self.stick_ratio * self.contact_half_width

    def load(self, a):
        """P(a) = C a^(m+k)/(m+k) [stress x length], of any shape."""
        return self._density / self.power * np.asarray(a) ** self.power

    @cached_property
    def dissipated_energy(self):
        """Friction work since first contact, per thickness [stress x length²]: 2 ∫∫ mu p |dh_x| dx, like P a^m."""
        m, scale = self.profile.m, self._compliance * self._density**2
        work = abs(self._drag) * self._fields.slip_work(self.power) / (2 * m + self.solid.k)
        return 2 * self.mu * scale * work * self.contact_half_width ** (2 * m + self.solid.k)

    # -- fields ------------------------------------------------------------------------------------

    def pressure(self, x):
        """p(x) [stress]; zero for |x| >= a, infinite at x = 0 if m + k <= 1 or if every point slips."""
        return self._traction(np.abs(x), self._fields.punch.pressure)

    def traction(self, x):
        """q(x) [stress] on the half-plane along +x, odd: outward where the pressure drags the surface inward, d < 0."""
        magnitude = np.where(np.equal(x, 0), 0.0, self._traction(np.abs(x), self._fields.punch.traction))
        return (-self._drag * np.sign(x) * magnitude)[()]

    def slip(self, x):
        """h_x = -∫ du_x since the point came into contact [length], odd, of the sign of q; zero for |x| >= a.

        As in `FrettingLoop.slip` it is how far the surface stays behind the indenter.
        """
        x = np.asarray(x, dtype=float)
        m, a = self.profile.m, self.contact_half_width
        scale = self._compliance * self._density * a**m / m
        return (-self._drag * np.sign(x) * scale * self._fields.slip(np.abs(x) / a, m))[()]

    def stick_displacement(self, x):
        """u_x where x sticks [length], x of any shape: proportional to x|x|^(m-1), whatever P; nan for |x| > c."""
        x, m = np.asarray(x, dtype=float), self.profile.m
        if not self.stick_ratio:
            return np.full(x.shape, np.nan)[()]
        scale = -self._drag * self._compliance * self._density / m * self._fields.stick_slope(m)
        return np.where(np.abs(x) <= self.stick_half_width, scale * x * np.abs(x) ** (m - 1), np.nan)[()]

    def _traction(self, x, density):
        a = self.contact_half_width
        return self._density * a ** (self.power - 1) * self._fields.grown(x / a, self.power, density)

    # -- the sum of punches ------------------------------------------------------------------------

    @property
    def _compliance(self):
        """K [length^k / stress]."""
        return self.solid.y0**self.solid.k / self.solid.E0

    @cached_property
    def _density(self):
        """C of dP = C s^(m+k-1) ds, from the height of the profile at the edge of the contact."""
        return self.profile.A * self.profile.m / (self._compliance * self._fields.height_slope(self.profile.m))

    @property
    def _drag(self):
        """Sign of d, by which the pressure moves the surface outward (1), inward (-1), or not at all."""
        return np.sign(self.solid.d)

    @property
    def _fields(self):
        solid = self.solid
        medium = Medium(solid.k, solid.bk, solid.gk, -abs(solid.d), self.mu)
        return _fields(medium, self.terms)


@lru_cache(maxsize=64)
def _fields(medium, terms):
    return PunchFields(punch_with_friction(medium, terms))
