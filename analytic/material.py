"""Elastic half-plane with a power law of Young's modulus in depth: equations (1)-(4), (37), and d of [X6]."""

from dataclasses import dataclass
from functools import cached_property
from math import gamma, pi, sin, sqrt

import numpy as np

from .checks import require

LEAST_K = 1e-200  # products of a smaller k lose their digits below the smallest number


@dataclass(frozen=True)
class GradedHalfPlane:
    """Half-plane y > 0 with E(y) = E0 (y/y0)^k and constant Poisson's ratio nu, in plane strain.

    E0: modulus at the depth y0 [stress], positive; nu: -1 < nu <= 1/2; k: -1 < k < 1, below LEAST_K taken for 0;
    y0: characteristic depth [length], positive. Other values raise ValueError.
    The normal and tangential problems decouple exactly only at nu = holl_ratio(k).
    """

    E0: float
    nu: float
    k: float
    y0: float

    def __post_init__(self):
        require("E0", self.E0)
        require("nu", self.nu, -1, 0.5, closed_high=True)
        require("k", self.k, -1, 1)
        require("y0", self.y0)
        if abs(self.k) < LEAST_K:
            object.__setattr__(self, "k", 0.0)

    @staticmethod
    def holl_ratio(k):
        """Poisson's ratio 1/(2+k) of exact decoupling; above 1/2, hence inadmissible, for k < 0."""
        require("k", k, -1, 1)
        return 1 / (2 + k)

    def modulus(self, y):
        """Young's modulus at depth y >= 0 [stress], (1); 0 or infinite at y = 0 if k ≠ 0."""
        y = np.asarray(y, dtype=float)
        if np.any(y < 0):
            raise ValueError(f"depth y = {y.min()!r} is outside the body, y >= 0")
        with np.errstate(divide="ignore"):
            return self.E0 * (y / self.y0) ** self.k

    @cached_property
    def beta(self):
        """Parameter beta of (4); it is 1 at the Holl ratio."""
        return sqrt((1 + self.k) * (1 - self.k * self.nu / (1 - self.nu)))

    @cached_property
    def C(self):
        """Parameter C of (4)."""
        k, beta = self.k, self.beta
        return 2 ** (1 + k) / pi * gamma((3 + k + beta) / 2) * gamma((3 + k - beta) / 2) / gamma(2 + k)

    @property
    def bk(self):
        """b·k of (3), finite and positive for every k; 2(1-nu²)/pi for k = 0."""
        nu, beta = self.nu, self.beta
        return (1 - nu) * (1 + nu) * beta * self.C * sin(beta * pi / 2) / (1 + self.k)

    @property
    def gk(self):
        """g·k of (3), finite and positive for every k; 2(1-nu²)/pi for k = 0."""
        nu, beta = self.nu, self.beta
        return (1 - nu) * (1 + nu) * (1 + self.k) * self.C * sin(beta * pi / 2) / beta

    @property
    def b(self):
        """Normal elastic parameter b of (3); it has a pole at k = 0."""
        return self.bk / self._nonzero_k("b")

    @property
    def g(self):
        """Tangential elastic parameter g of (3); it has a pole at k = 0."""
        return self.gk / self._nonzero_k("g")

    def _nonzero_k(self, name):
        if self.k == 0:
            raise ValueError(f"k = 0: {name} has a pole there; use {name}k, which is finite")
        return self.k

    @cached_property
    def d(self):
        """Coupling parameter d of [X6]: zero at the Holl ratio, -(1-2 nu)(1+nu)/2 for k = 0."""
        k, nu, beta = self.k, self.nu, self.beta
        # cos(beta pi/2)/k with (beta-1)/k = (1-(2+k)nu)/((1-nu)(1+beta)), whose pole at k = 0 cancels
        offset = (1 - (2 + k) * nu) * (1 + nu) / (1 + beta)
        return float(-self.C * pi / 2 * np.sinc((beta - 1) / 2) * offset)

    @property
    def alpha(self):
        """Ratio g/b of tangential to normal compliance, (37)."""
        return (1 + self.k) / (1 - self.k * self.nu / (1 - self.nu))

    @property
    def normal_compliance(self):
        """(bk) y0^k / E0 [length^k / stress]: factor of the normal kernel in (2), times k."""
        return self.bk * self.y0**self.k / self.E0

    @property
    def tangential_compliance(self):
        """(gk) y0^k / E0 [length^k / stress]: factor of the tangential kernel in (2), times k."""
        return self.gk * self.y0**self.k / self.E0

    @property
    def homogeneous_compliance(self):
        """(1-nu²)/E0 [1/stress], which sets the homogeneous half-width a0 in (57)."""
        return (1 - self.nu) * (1 + self.nu) / self.E0
