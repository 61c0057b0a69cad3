"""Rigid parabolic cylinder pressed on a graded half-plane: equations (41)-(46), [X1]-[X4]."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import gamma, pi, sqrt

import numpy as np

from .checks import require, require_positive_k
from .cumulative import beta_density, beta_fraction, load_fraction_difference
from .fretting import TangentiallyLoaded
from .material import GradedHalfPlane
from .profile import PowerProfile
from .special import (
    log_remainder,
    parabolic_displacement,
    parabolic_gap,
    parabolic_gap_slope,
    parabolic_relative_displacement,
    punch_rigid_factor,
)


@dataclass(frozen=True)
class CylinderContact(TangentiallyLoaded):
    """Cylinder f(x) = x²/(2R) pressed by a line load on a graded half-plane or a pair of them.

    R: radius [length]; P: load per unit length [stress x length]; both positive, else ValueError.
    Fields take x of any shape and return that shape. Methods that end in _difference compare with
    the same contact under the load e^log_ratio P, of half-width s, without cancellation; where they take a shift e,
    with that one moved to x = e [X7].
    """

    solid: GradedHalfPlane
    R: float
    P: float

    def __post_init__(self):
        require("R", self.R)
        require("P", self.P)

    # -- scalars -----------------------------------------------------------------------------------

    @cached_property
    def a(self):
        """Contact half-width [length], from (43)."""
        k = self.solid.k
        gammas = gamma((4 + k) / 2) * gamma((1 - k) / 2) / sqrt(pi)
        return (2 * self.R * self.P * self.solid.normal_compliance * gammas) ** (1 / (2 + k))

    @cached_property
    def a0(self):
        """Contact half-width for k = 0 [length], (57)."""
        return sqrt(4 * self.solid.homogeneous_compliance * self.P * self.R / pi)

    @property
    def peak_pressure(self):
        """Pressure at x = 0 [stress], (44)."""
        return float(self.pressure(0.0))

    @property
    def indentation(self):
        """Indentation depth [length], (46). Raises UndefinedDisplacementError for k <= 0."""
        require_positive_k(self.solid.k, "the indentation delta_y")
        return self.a**2 / (2 * self.R * self.solid.k)

    @cached_property
    def profile(self):
        """Shape of the cylinder, the PowerProfile f(x) = x²/(2R), (41)."""
        return PowerProfile(0.5 / self.R, 2.0)

    def under(self, P):
        """The same cylinder under another load [stress x length]."""
        return replace(self, P=float(P))

    # -- fields ------------------------------------------------------------------------------------

    def density(self, s):
        """n_y(s) [stress / length^k], (42)."""
        k = self.solid.k
        return np.asarray(s) / (self.R * self.solid.normal_compliance * punch_rigid_factor(k))

    def pressure(self, x):
        """Contact pressure p(x) [stress], zero for |x| >= a, (44)."""
        return self.P * beta_density(x, self.a, (3 + self.solid.k) / 2)

    def pressure_within(self, x):
        """∫_{-x}^{x} p dx [stress x length], the load between -x and x; odd in x, ±P beyond ±a."""
        return self.P * beta_fraction(x, self.a, (3 + self.solid.k) / 2)

    def relative_displacement(self, x):
        """h_y(x) [length]: depth of the point x = 0 below x; f(x) in the contact, (45) beside it, as [X2]."""
        x = np.abs(np.asarray(x, dtype=float))
        return self.profile.height(x) * parabolic_relative_displacement(x, self.a, self.solid.k)

    def gap(self, x):
        """Gap f(x) - h_y(x) beside the contact [length], zero within it, [X2]."""
        x = np.abs(np.asarray(x, dtype=float))
        return self.profile.height(x) * parabolic_gap(x, self.a, self.solid.k)

    def displacement(self, x):
        """u_y(x) [length], (10). k > 0 only."""
        indentation, k = self.indentation, self.solid.k
        x = np.abs(np.asarray(x, dtype=float))
        inside = x <= self.a
        beside = np.where(inside, self.a, x)
        return np.where(
            inside,
            indentation - self.profile.height(x),
            self.profile.height(x) * parabolic_displacement(beside, self.a, k),
        )[()]

    # -- difference to the same contact under the load e^log_ratio P -------------------------------

    def half_width(self, log_ratio):
        """Half-width s under the load e^log_ratio P [length], (43)."""
        return self.a * np.exp(log_ratio / (2 + self.solid.k))

    def lost_width(self, log_ratio):
        """a - s [length], without the rounding error of s."""
        return -self.a * np.expm1(log_ratio / (2 + self.solid.k))

    def _inner(self, x, log_ratio, shift):
        """x, e, s, |x - e|, s - |x - e| and a - s; the last two without the rounding error of s."""
        x, e, log_ratio = np.broadcast_arrays(np.asarray(x, dtype=float), shift, log_ratio)
        s, width, side = self.half_width(log_ratio), self.lost_width(log_ratio), np.where(x >= e, 1.0, -1.0)
        near = np.where(width < self.a / 2, (self.a - side * x) - width + side * e, s - np.abs(x - e))
        return x, e, s, np.abs(x - e), near, width

    def pressure_difference(self, x, log_ratio, shift=0.0):
        """p(x, a) - p(x - e, s) [stress], bracket of (33) and (47)."""
        x, e, s, distance, to_s, width = self._inner(x, log_ratio, shift)
        result = np.array(self.pressure(x))
        stick = to_s > 0
        x, e, s, distance, to_s, width = (v[stick] for v in (x, e, s, distance, to_s, width))
        whole = (self.a - x) * (self.a + x)
        lost = (width * (self.a + s) - e * (2 * x - e)) / whole  # 1 - (s² - (x-e)²)/(a² - x²)
        log_left = np.log(to_s / (self.a - np.abs(x))) + np.log((s + distance) / (self.a + np.abs(x)))
        result[stick] *= -np.expm1((1 + self.solid.k) / 2 * log_remainder(lost, log_left))
        return result[()]

    def pressure_difference_within(self, x, log_ratio):
        """∫_{-x}^{x} of pressure_difference [stress x length]; odd in x."""
        return self.P * load_fraction_difference(x, self.a, log_ratio, self.solid.k)

    def relative_displacement_difference(self, x, log_ratio, shift=0.0):
        """f(x-e) - h_y(x-e, s) less f - h_y(x, a), which is 0 in contact [length]: (36), as [X2]."""
        x, e, s, distance, to_s, _ = self._inner(x, log_ratio, shift)
        return self.profile.height(x - e) * parabolic_gap(distance, s, self.solid.k, -to_s) - self.gap(x)

    def gradient_difference(self, x, log_ratio, shift=0.0):
        """Derivative of relative_displacement_difference [1], [X3]; for e = 0 odd in x."""
        k = self.solid.k
        x, e, s, distance, to_s, _ = self._inner(x, log_ratio, shift)
        inner = (x - e) / self.R * parabolic_gap_slope(distance, s, k, -to_s)
        return inner - x / self.R * parabolic_gap_slope(np.abs(x), self.a, k)

    def indentation_difference(self, log_ratio):
        """delta_y(a) - delta_y(s) [length], bracket of (40) and (49). k > 0 only."""
        return -self.indentation * np.expm1(2 * log_ratio / (2 + self.solid.k))

    def slip_work(self, log_ratio):
        """8 ∫_s^a p(x, a) [f(x) - h_y(x, s)] dx [stress x length²]: (52) over mu² alpha, [X4]."""
        k = self.solid.k
        L = -np.asarray(log_ratio, dtype=float) / (2 + k)
        U, V = (4 + k) * L / 2, k * L / 2
        printed = -np.expm1(-2 * U) / (4 + k) - np.exp(-2 * L) * (-np.expm1(-2 * V) / k if k else L)
        # the printed terms agree to third order in L; the series of sinh(U)/U - sinh(V)/V does not
        u, v = np.minimum(U, 1) ** 2, np.minimum(np.abs(V), 1) ** 2
        n = np.arange(1, 10)
        factorial = np.cumprod(2 * n * (2 * n + 1.0))
        series = sum((u**i - v**i) / f for i, f in zip(n, factorial, strict=True))
        S = np.where(U < 1, L * np.exp(-U) * series, printed)[()]
        return 2 * self.P * self.a**2 / self.R * S
