"""Shapes of indenters, or of prescribed displacements, and their Abel transform (5), (23)."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sin

import numpy as np
from scipy.special import beta as euler_beta

from .checks import require
from .quadrature import two_sided_rule

NODES = 48


@dataclass(frozen=True)
class Profile:
    """Even function f(x) with f(0) = 0, convex for an indenter, given by vectorised callables for x >= 0.

    height, slope, curvature: f [length], f', f'' [1/length]. flat: f = 0 for |x| <= flat [length].
    order: f ~ (x - flat)^order there; order >= 1, and order > 1 if flat > 0, where a kink would need its own punch.
    """

    height: Callable
    slope: Callable
    curvature: Callable
    flat: float = 0.0
    order: float = 2.0

    def __post_init__(self):
        require("flat", self.flat, closed_low=True)
        require("order", self.order, 1, closed_low=self.flat == 0)

    def abel_integral(self, s, k):
        """∫_0^s x f'(x) (s²-x²)^(-(1-k)/2) dx for s > flat."""
        return s ** (1 + k) * self._weighted(s, k, lambda t, x: t * self.slope(x), 1.0 if self.flat == 0 else 0.0)

    def abel_density(self, s, k):
        """s^-k d/ds of abel_integral, differentiated under the integral sign."""

        def integrand(t, x):
            return t * ((1 + k) * self.slope(x) + x * self.curvature(x))

        return self._weighted(s, k, integrand, 1.0 if self.flat == 0 else min(self.order - 2, 0.0))

    def _weighted(self, s, k, integrand, left):
        """∫_{flat/s}^1 integrand(t, s t) (1-t²)^((k-1)/2) dt; the integrand is of order left or higher at the lower end."""
        s = np.asarray(s, dtype=float)[..., None]
        low = self.flat / s
        right = (k - 1) / 2
        r, rest, weight = two_sided_rule(left, right, NODES)
        t = low + (1 - low) * r
        smooth = integrand(t, s * t) * (1 + t) ** right * r**-left
        return (1 - low[..., 0]) ** ((1 + k) / 2) * (smooth @ weight)


@dataclass(frozen=True)
class PowerProfile:
    """f(x) = A |x|^m with m >= 1: wedge, cylinder, and blunter shapes, whose Abel transform is closed."""

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
        return self.A * self.m * euler_beta((self.m + 1) / 2, (1 + k) / 2) / 2 * np.asarray(s) ** (self.m + k)

    def abel_density(self, s, k):
        """s^-k d/ds of abel_integral."""
        return self.A * self.m * (self.m + k) * euler_beta((self.m + 1) / 2, (1 + k) / 2) / 2 * np.asarray(s) ** (self.m - 1)


def abel_factor(k, compliance):
    """2 cos(k pi/2) / (pi compliance), the factor of (5) and (23) [stress / length^k]."""
    return 2 * sin((1 - abs(k)) * pi / 2) / (pi * compliance)


def density_power(profile, k):
    """Power of s - flat with which the density n(s) of (5), (23) begins."""
    return profile.order - 1 + ((k - 1) / 2 if profile.flat > 0 else 0.0)
