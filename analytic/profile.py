"""Shapes of indenters, or of prescribed displacements, and their Abel transform (5), (23)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import pi, sin

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.special import beta as euler_beta

from .checks import require
from .quadrature import two_sided_rule

NODES = 48
DEGREE = 32  # of a series for the density of a smooth profile
ALL_DIGITS = 2e-15  # of its coefficients, below which they are round-off
SMALLEST_WIDTH = 1e-20  # of s - flat over s where s rounds to flat


@dataclass(frozen=True)
class Profile:
    """Even function f(x), convex for an indenter, which vanishes for |x| <= flat and grows beyond.

    shape, slope, curvature: f [length], f' [1] and f'' [1/length] as vectorised functions of the
    distance u = |x| - flat >= 0 [length], which is |x| itself for a tip without flat.
    order: f ~ u^order at u = 0; order >= 1, and order > 1 if flat > 0, where a kink would need a
    punch of its own.
    """

    shape: Callable
    slope: Callable
    curvature: Callable
    flat: float = 0.0
    order: float = 2.0

    def __post_init__(self):
        require("flat", self.flat, closed_low=True)
        require("order", self.order, 1, closed_low=self.flat == 0)

    def height(self, x):
        """f(x) [length]."""
        return self.shape(np.maximum(np.abs(x) - self.flat, 0.0))

    def abel_integral(self, s, k):
        """∫_0^s x f'(x) (s²-x²)^(-(1-k)/2) dx for s > flat."""
        left = 1.0 if self.flat == 0 else 0.0
        return s ** (1 + k) * self._weighted(s, k, lambda t, x, u: t * self.slope(u), left)

    def abel_density(self, s, k):
        """s^-k d/ds of abel_integral, differentiated under the integral sign."""

        def integrand(t, x, u):
            return t * ((1 + k) * self.slope(u) + x * self.curvature(u))

        left = 1.0 if self.flat == 0 else min(self.order - 2, 0.0)
        return self._weighted(s, k, integrand, left)

    def density_within(self, k, a):
        """abel_density as a function of flat < s <= a: a power of s - flat times a Chebyshev series, where that has all
        digits. It is some fifty times as fast: fields take the density at many points.
        """
        power = density_power(self, k)

        def beginning(s):
            return np.maximum(s - self.flat, SMALLEST_WIDTH * s) ** power

        with np.errstate(all="ignore"):  # a high power of s may be 0 to a float
            series = Chebyshev.interpolate(lambda s: self.abel_density(s, k) / beginning(s), DEGREE, (self.flat, a))
        size = np.abs(series.coef)
        if not size[-2:].max() <= ALL_DIGITS * size.max():  # nan is not
            return partial(self.abel_density, k=k)
        series = series.trim(ALL_DIGITS * size.max())
        return lambda s: beginning(s) * series(s)

    def _weighted(self, s, k, integrand, left):
        """∫_{flat/s}^1 integrand (1-t²)^((k-1)/2) dt, x = s t; integrand ~ u^left or higher."""
        s = np.asarray(s, dtype=float)[..., None]
        width = np.maximum(s - self.flat, SMALLEST_WIDTH * s)
        right = (k - 1) / 2
        r, _, weight = two_sided_rule(left, right, NODES)
        u = width * r
        x = self.flat + u
        smooth = integrand(x / s, x, u) * (1 + x / s) ** right * r**-left
        return (width / s)[..., 0] ** ((1 + k) / 2) * (smooth @ weight)


@dataclass(frozen=True)
class PowerProfile:
    """f(x) = A |x|^m, A > 0, m >= 1: wedge, cylinder, blunter shapes; their transform is closed."""

    A: float
    m: float
    flat = 0.0

    def __post_init__(self):
        require("A", self.A)
        require("m", self.m, 1, closed_low=True)

    @property
    def order(self):
        """Power of x near the tip."""
        return self.m

    def height(self, x):
        """f(x) [length]."""
        return self.A * np.abs(x) ** self.m

    def abel_integral(self, s, k):
        """∫_0^s x f'(x) (s²-x²)^(-(1-k)/2) dx."""
        m = self.m
        return self.A * m * euler_beta((m + 1) / 2, (1 + k) / 2) / 2 * np.asarray(s) ** (m + k)

    def abel_density(self, s, k):
        """s^-k d/ds of abel_integral."""
        m = self.m
        return self.A * m * (m + k) * euler_beta((m + 1) / 2, (1 + k) / 2) / 2 * np.asarray(s) ** (m - 1)

    def density_within(self, k, a):
        """abel_density as a function of 0 < s <= a."""
        return partial(self.abel_density, k=k)


def abel_factor(k, compliance):
    """2 cos(k pi/2) / (pi compliance), the factor of (5) and (23) [stress / length^k]."""
    return 2 * sin((1 - abs(k)) * pi / 2) / (pi * compliance)


def load_of(solid, profile, s):
    """P(s) of a contact of half-width s, any shape [stress x length], (6), with (5) integrated."""
    return abel_factor(solid.k, solid.normal_compliance) * profile.abel_integral(s, solid.k)


def density_power(profile, k):
    """Power of s - flat with which the density n(s) of (5), (23) begins."""
    return profile.order - 1 + ((k - 1) / 2 if profile.flat > 0 else 0.0)
