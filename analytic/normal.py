"""Normal contact of a convex symmetric indenter of any shape: equations (5)-(8), (10), (11)."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, expm1, log

import numpy as np
from scipy.optimize import brentq

from .checks import require, require_positive_k
from .cylinder import CylinderContact
from .fretting import TangentiallyLoaded
from .material import GradedHalfPlane
from .profile import PowerProfile, Profile, abel_factor, density_power, load_of
from .punch_superposition import PunchSuperposition
from .quadrature import plain_rule
from .special import punch_rigid_factor

ENERGY_NODES = 64
# of logarithms of half-widths: all digits; beside a flat a load has few, so that its curve has steps
ROOT = {"xtol": 1e-15, "rtol": 1e-15, "maxiter": 1000}


@dataclass(frozen=True)
class ProfileContact(TangentiallyLoaded):
    """Indenter f(x) in contact over |x| < a; fields take x of any shape and return that shape.

    a: contact half-width [length], a > profile.flat, else ValueError; from_load finds it from the
    load. The methods are those of CylinderContact, with log_ratio, and with it the load Q of
    partial slip and fretting, a single number.
    """

    solid: GradedHalfPlane
    profile: Profile | PowerProfile
    a: float

    def __post_init__(self):
        require("a", self.a, self.profile.flat)

    @classmethod
    def from_load(cls, solid, profile, P, a_max):
        """Contact under the line load P [stress x length], whose half-width is at most a_max."""
        require("P", P)
        flat = profile.flat
        require("P", P, high=load_of(solid, profile, a_max), closed_high=True)

        def half_width(t):
            return flat + (a_max - flat) * exp(t)

        def excess(t):
            return log(load_of(solid, profile, half_width(t)) / P)

        low = -1.0
        while excess(low) > 0:
            low *= 2
        return cls(solid, profile, half_width(brentq(excess, low, 0.0, **ROOT)))

    # -- normal contact ----------------------------------------------------------------------------

    def density(self, s, edge=None):
        """n_y(s) [stress / length^k], (5)."""
        return abel_factor(self.solid.k, self.solid.normal_compliance) * self._abel_density(np.asarray(s, dtype=float))

    @cached_property
    def _abel_density(self):
        """The factor of n_y that depends on s, as a function of s."""
        return self.profile.density_within(self.solid.k, self.a)

    @cached_property
    def P(self):
        """Line load [stress x length], (6)."""
        return float(load_of(self.solid, self.profile, self.a))

    def under(self, P):
        """The same profile under another load [stress x length]."""
        return self.from_load(self.solid, self.profile, P, _wide_enough(self.solid, self.profile, P))

    @cached_property
    def _punches(self):
        return self._between(self.profile.flat, None, density_power(self.profile, self.solid.k))

    def _between(self, start, width, power=0.0):
        """The punches start < s < a; width = a - start."""
        k, compliance = self.solid.k, self.solid.normal_compliance
        return PunchSuperposition(k, compliance, self.density, self.a, start, power=power, width=width)

    def pressure(self, x):
        """Contact pressure p(x) [stress], zero for |x| >= a, (7)."""
        return self._punches.traction(x)

    def pressure_within(self, x):
        """∫_{-x}^{x} p dx [stress x length]; odd in x."""
        return self._punches.traction_within(x)

    def relative_displacement(self, x):
        """h_y(x) [length], (8); in the contact f(x), the boundary condition that (5) solves."""
        x = np.abs(np.asarray(x, dtype=float))
        inside = self.profile.height(np.minimum(x, self.a))
        return np.where(x <= self.a, inside, self._punches.relative_displacement(x))[()]

    def displacement(self, x):
        """u_y(x) [length], (10). k > 0 only."""
        return self._punches.displacement(x)

    @property
    def indentation(self):
        """delta_y [length], (11). k > 0 only."""
        require_positive_k(self.solid.k, "the indentation delta_y")
        return self._punches.rigid_displacement

    # -- difference to the same contact under the load e^log_ratio P -------------------------------

    def half_width(self, log_ratio):
        """Half-width s under the load e^log_ratio P [length], (6)."""
        return self._added(log_ratio).start

    def pressure_difference(self, x, log_ratio):
        """p(x, a) - p(x, s) [stress], bracket of (33)."""
        return self._added(log_ratio).traction(x)

    def pressure_difference_within(self, x, log_ratio):
        """∫_{-x}^{x} of pressure_difference [stress x length]; odd in x."""
        return self._added(log_ratio).traction_within(x)

    def relative_displacement_difference(self, x, log_ratio):
        """h_y(x, a) - h_y(x, s) [length], within the contact f - h_y(x, s) of (36), as in (35)."""
        return self._added(log_ratio).relative_displacement(x)

    def gradient_difference(self, x, log_ratio):
        """Derivative of relative_displacement_difference [1]; odd in x."""
        return self._added(log_ratio).relative_displacement_gradient(x)

    def indentation_difference(self, log_ratio):
        """delta_y(P) - delta_y(e^log_ratio P) [length], bracket of (40). k > 0 only."""
        return self._added(log_ratio).rigid_displacement

    def slip_work(self, log_ratio):
        """8 ∫_s^a p(x, a) [f(x) - h_y(x, s)] dx [stress x length²]: (52) over mu² alpha.

        Punches (27)-(31) of half-widths s' < s" do the work D (s'^-k - s"^-k)/k on each other, by
        reciprocity, where D = (bk) y0^k/E0 Γ((2+k)/2)Γ((1-k)/2)/√π. By parts their sum becomes
        4 D ∫_s^a (P(a) - P(s')) (P(s') - P(s)) s'^(-k-1) ds'.
        """
        k, added = self.solid.k, self._added(log_ratio)
        t, rest, weight = plain_rule(1.0, 1.0, ENERGY_NODES)
        s, below, above = added.start + added.width * t, added.width * t, added.width * rest
        nodes = range(s.size)
        load_below = np.array([replace(added, a=s[i], width=below[i]).load for i in nodes])
        load_above = np.array([replace(added, start=s[i], width=above[i]).load for i in nodes])
        integral = added.width * np.sum(weight * load_above * load_below * s ** (-k - 1))
        return 4 * self.solid.normal_compliance * punch_rigid_factor(k) * integral

    def _added(self, log_ratio):
        """Punches between s and a, with the width a - s as accurate as s itself."""
        whole = self.a - self.profile.flat
        fraction = -expm1(log_ratio)
        if fraction == 0:
            return self._between(self.a, 0.0)
        if fraction >= 0.25 * min(1.0, self.profile.order + self.solid.k):
            smaller = self.P * exp(log_ratio)
            inner = ProfileContact.from_load(self.solid, self.profile, smaller, self.a)
            return self._between(inner.a, self.a - inner.a)

        def outer(t):
            return self._between(self.a - whole * exp(t), whole * exp(t))

        def excess(t):
            return log(outer(t).load / (self.P * fraction))

        steepest = max(5.0, 1 + log(self.profile.order + self.solid.k))  # P ~ width^(order + k) or less steep
        return outer(brentq(excess, log(fraction) - steepest, -1e-3, **ROOT))


def normal_contact(solid: GradedHalfPlane, profile, P) -> CylinderContact | ProfileContact:
    """Contact under the line load P [stress x length], of a parabola or any other profile, as wide as it has to be.

    Raises ValueError where the profile ends before it carries P, or is not convex up to there.
    """
    if getattr(profile, "m", None) == 2:
        return CylinderContact(solid, R=0.5 / profile.A, P=P)
    return ProfileContact.from_load(solid, profile, P, _wide_enough(solid, profile, P))


def _wide_enough(solid, profile, P):
    """A half-width that carries at least ``P``; ValueError where the profile ends before."""
    width, growth, before = 1e-9 * (profile.flat or 1.0), 4.0, 0.0
    while growth > 1 + 1e-6:
        with np.errstate(all="ignore"):
            load = load_of(solid, profile, profile.flat + growth * width)
        if load >= P:
            return profile.flat + growth * width
        if load < before:
            raise ValueError(f"the indenter's profile is not convex up to x = {profile.flat + growth * width:.3g}")
        if load < P:
            width, before = width * growth, load
        else:  # not a number: beyond the end of the profile
            growth **= 0.5
    raise ValueError(f"the indenter's profile ends at x = {profile.flat + width:.3g}, before it carries P")


def half_width_where(excess, guess, step, **options):
    """e^t at the root of a function that grows with the logarithm t of a half-width; sought in steps from a guess of t,
    and by brentq with these options.
    """
    low = high = guess
    while excess(low) > 0:
        low -= step
    while excess(high) < 0:
        high += step
    return exp(brentq(excess, low, high, **options))
