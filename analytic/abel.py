"""Contact fields as a superposition of flat punches of half-width s: equations (6)-(8), (10), (11) and (18), (20)-(22).

The density n(s) of the punches is n_y in the normal and n_x in the tangential problem; nothing else differs but the compliance.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import gamma, inf, pi, sqrt

import numpy as np
from scipy.special import betainc

from .checks import require_positive_k
from .quadrature import nodes_for, one_sided_rule, two_sided_rule
from .special import (
    punch_displacement,
    punch_gradient,
    punch_relative_displacement,
    punch_rigid_displacement,
)

BLOCK = 64  # points per block, which bounds the memory of points x nodes x nodes


@dataclass(frozen=True)
class PunchSuperposition:
    """Punches of half-widths start < s < a with density n(s); fields take x of any shape and return that shape.

    k: exponent of (1). compliance: (bk) y0^k/E0 or (gk) y0^k/E0. density(s, a - s): n, for arrays [stress / length^k].
    power, edge_power: n ~ (s - start)^power and ~ (a - s)^edge_power at the ends, for the quadrature.
    width: a - start, if known better than by subtraction.
    """

    k: float
    compliance: float
    density: Callable
    a: float
    start: float = 0.0
    power: float = 1.0
    edge_power: float = 0.0
    width: float | None = None

    def __post_init__(self):
        if self.width is None:
            object.__setattr__(self, "width", self.a - self.start)
        # the rules only need to know a power that is not smooth; higher ones are left in the integrand
        object.__setattr__(self, "power", min(self.power, 1.0))

    @cached_property
    def load(self):
        """Resultant line load ∫ n s^k ds [stress x length], (6), (22)."""
        return self._moment(self.k)

    @cached_property
    def rigid_displacement(self):
        """Displacement of the part inside start: delta_y (11), or delta_x (39) [length]. k > 0 only."""
        require_positive_k(self.k, "the rigid-body displacement")
        return self.compliance * punch_rigid_displacement(self.k) * self._moment(0.0)

    def traction(self, x):
        """Pressure p (7) or traction q (18) [stress]; zero for |x| >= a, infinite under a sharp tip."""
        return (
            gamma(1 + self.k / 2)
            / (sqrt(pi) * gamma((1 + self.k) / 2))
            * by_blocks(self._traction, x)
        )

    def traction_within(self, x):
        """∫_{-x}^{x} of the traction [stress x length]; odd in x."""
        return np.sign(x) * by_blocks(self._traction_within, x)

    def relative_displacement(self, x):
        """h_y (8) or h_x (21) [length]: how far the surface point x stays behind x = 0."""
        return self.compliance * by_blocks(self._relative_displacement, x)

    def relative_displacement_gradient(self, x):
        """Derivative of h_y or h_x with respect to x [1]; odd in x."""
        return np.sign(x) * self.compliance * by_blocks(self._gradient, x)

    def displacement(self, x):
        """u_y (10) or u_x (20) [length]. k > 0 only."""
        require_positive_k(self.k, "the displacement of a surface point")
        return self.compliance * by_blocks(self._displacement, x)

    # -- each field at a 1-d array of x >= 0 ---------------------------------------------------------------------------

    def _traction(self, x):
        result = np.zeros_like(x)
        beyond = self._beyond_start(x)
        above = (beyond >= 0) & (x > 0) & (x < self.a)
        result[above] = self._traction_from_x(x[above, None])
        below = beyond < 0
        result[below] = self._traction_from_start(x[below, None])
        if self.start == 0 and np.any(x == 0):
            result[x == 0] = self._moment(self.k - 1) if self.power + self.k > 0 else inf
        return result

    def _traction_within(self, x):
        result = np.where(x < self.a, 0.0, self.load)
        edge = (x > max(self.start, self.a / 2)) & (x < self.a)
        result[edge] = self.load - self._load_of_wider(x[edge, None], beyond_x=True)
        rest = (x > 0) & (x < self.a) & ~edge
        result[rest] = self._load_of_wider(x[rest, None])
        inner = rest & (self._beyond_start(x) > 0)
        result[inner] += self._load_up_to(x[inner, None])
        return result

    def _relative_displacement(self, x):
        result = np.zeros_like(x)
        part = (self._beyond_start(x) > 0) & (x <= self.a)
        result[part] = self._inside(
            x[part, None], punch_relative_displacement, min(self.k, 0.0), (1 - self.k) / 2
        )
        result[x > self.a] = self._outside(
            x[x > self.a, None], punch_relative_displacement, min(self.k, 0.0)
        )
        return result

    def _displacement(self, x):
        result = np.full(x.shape, self.rigid_displacement / self.compliance)
        result[x <= self.a] -= self._relative_displacement(x[x <= self.a])
        result[x > self.a] = self._outside(x[x > self.a, None], punch_displacement, 0.0)
        return result

    def _gradient(self, x):
        result = np.zeros_like(x)
        part = (self._beyond_start(x) > 0) & (x <= self.a)
        result[part] = self._inside(x[part, None], punch_gradient, self.k, -(1 + self.k) / 2)
        result[x > self.a] = self._outside(x[x > self.a, None], punch_gradient, self.k)
        return result

    # -- integrals over s; x is a column, the nodes are a row --------------------------------------------------------

    def _beyond_start(self, x):
        """x - start, by way of the width where start is only known to its own rounding error."""
        return self.width - (self.a - x) if self.width < self.a / 2 else x - self.start

    def _moment(self, exponent):
        """∫ n s^exponent ds."""
        left = self.power + (exponent if self.start == 0 else 0.0)
        t, rest, weight = two_sided_rule(left, self.edge_power, nodes_for(0))
        s, edge = self.start + self.width * t, self.width * rest
        return float(
            self.width
            * (weight @ (self.density(s, edge) * s**exponent * t**-left * rest**-self.edge_power))
        )

    def _traction_from_x(self, x):
        """∫_x^a n (s²-x²)^((k-1)/2) ds with s = x cosh(theta), which puts theta^k at the lower end."""
        span = 2 * np.arcsinh(np.sqrt((self.a - x) / (2 * x)))
        t, rest, weight = two_sided_rule(self.k, self.edge_power, nodes_for(span))
        theta = span * t
        edge = 2 * x * np.sinh(span * (1 + t) / 2) * np.sinh(span * rest / 2)
        smooth = (
            self.density(x * np.cosh(theta), edge)
            * (x * np.sinh(theta) / t) ** self.k
            * rest**-self.edge_power
        )
        return span[:, 0] * (smooth @ weight)

    def _traction_from_start(self, x):
        """∫_start^a n (s²-x²)^((k-1)/2) ds with s² - x² = (a²-x²) e^-phi, smooth for x -> start and for start -> a."""
        whole = (self.a - x) * (self.a + x)
        lost = self.width * (2 * self.a - self.width) / whole
        span = _log_ratio(lost, whole / (-self._beyond_start(x) * (self.start + x)))
        t, rest, weight = two_sided_rule(self.power, self.edge_power, nodes_for(span))
        u = whole * np.exp(-span * rest)
        s = np.sqrt(x**2 + u)
        edge = -whole * np.expm1(-span * rest) / (self.a + s)
        smooth = (
            self.density(s, edge)
            * u ** ((1 + self.k) / 2)
            / (2 * s)
            * t**-self.power
            * rest**-self.edge_power
        )
        return span[:, 0] * (smooth @ weight)

    def _load_up_to(self, x):
        """∫_start^x n s^k ds for x < a/2: punches inside x, which count with their whole load."""
        left = self.power + (self.k if self.start == 0 else 0.0)
        t, weight = one_sided_rule(left, nodes_for(0))
        span = self._beyond_start(x)
        s = self.start + span * t
        return span[:, 0] * ((self.density(s, self.a - s) * s**self.k * t**-left) @ weight)

    def _load_of_wider(self, x, beyond_x=False):
        """∫_max(x,start)^a n s^k I_{x²/s²}(1/2,(1+k)/2) ds over ln s: the part of each traction (12) within x, or beyond."""
        width = np.minimum(self.width, self.a - x)
        span = _log_ratio(width / self.a, self.a / np.maximum(x, self.start))
        left = self.power if self.start > 0 else 0.0
        t, rest, weight = two_sided_rule(left, self.edge_power, nodes_for(span))
        s = self.a * np.exp(-span * rest)
        edge = -self.a * np.expm1(-span * rest)
        beyond = np.where(edge < self.a / 2, (self.a - x) - edge, s - x)
        y = np.maximum(beyond, 0) * (s + x) / s**2
        half = (1 + self.k) / 2
        if beyond_x:
            share = betainc(half, 0.5, y)
        else:
            share = np.where(
                y < 0.5, 1 - betainc(half, 0.5, y), betainc(0.5, half, np.minimum(x / s, 1) ** 2)
            )
        smooth = (
            self.density(s, edge) * s ** (1 + self.k) * share * t**-left * rest**-self.edge_power
        )
        return span[:, 0] * (smooth @ weight)

    def _inside(self, x, kernel, kernel_left, right):
        """∫_start^x n kernel(s/x) ds; the kernel is of order kernel_left at s = 0 and vanishes like (x-s)^right at x."""
        left = self.power + (kernel_left if self.start == 0 else 0.0)
        beside = (self.edge_power != 0) & (x[:, 0] < self.a)
        result = np.empty(x.shape[0])
        for part, is_beside in ((~beside, False), (beside, True)):
            column, edge_power = x[part], 0.0 if is_beside else self.edge_power
            t, rest, s, distance, jacobian, weight = self._nodes_below(
                column, left, right + edge_power, is_beside
            )
            values = self.density(s, self.a - column + distance) * kernel(
                column, s, self.k, distance
            )
            result[part] = (values * jacobian * t**-left * rest ** -(right + edge_power)) @ weight
        return result

    def _nodes_below(self, x, left, right, beside_edge):
        """Nodes s and x - s for start < s < x <= a."""
        span = self._beyond_start(x)
        if beside_edge:  # n is singular just beyond x: a - s = (a-x) e^phi
            span = np.log1p(span / (self.a - x))
            t, rest, weight = two_sided_rule(left, right, nodes_for(span))
            distance = (self.a - x) * np.expm1(span * rest)
            return (
                t,
                rest,
                self.start - self.width * np.expm1(-span * t),
                distance,
                span * (self.a - x + distance),
                weight,
            )
        if self.start == 0:
            t, rest, weight = two_sided_rule(left, right, nodes_for(0))
            return t, rest, x * t, x * rest, x, weight
        span = _log_ratio(span / x, x / self.start)  # s = x e^-theta
        t, rest, weight = two_sided_rule(left, right, nodes_for(span))
        s = x * np.exp(-span * rest)
        return t, rest, s, -x * np.expm1(-span * rest), span * s, weight

    def _outside(self, x, kernel, kernel_left):
        """∫ n kernel(s/x) ds for x > a: over s below a/2; above over y = 1 - s²/x² = y_a e^theta, smooth for x -> a."""
        result = np.zeros(x.shape[0])
        middle = max(self.start, self.a / 2)
        if middle > self.start:
            left = self.power + (kernel_left if self.start == 0 else 0.0)
            t, weight = one_sided_rule(left, nodes_for(0))
            s = self.start + (middle - self.start) * t
            result += (middle - self.start) * (
                (self.density(s, self.a - s) * kernel(x, s, self.k) * t**-left) @ weight
            )
        beside = (x - self.a) * (x + self.a)
        width, right = (self.width, self.power) if middle == self.start else (self.a / 2, 0.0)
        span = np.log1p(width * (2 * self.a - width) / beside)
        t, rest, weight = two_sided_rule(self.edge_power, right, nodes_for(span))
        edge_square = beside * np.expm1(span * t)  # a² - s²
        s = np.sqrt(self.a**2 - np.minimum(edge_square, self.a**2 - middle**2))
        jacobian = span * beside * np.exp(span * t) / (2 * s)
        smooth = self.density(s, edge_square / (self.a + s)) * kernel(x, s, self.k) * jacobian
        return result + (smooth * t**-self.edge_power * rest**-right) @ weight


def by_blocks(function, x):
    """function of a 1-d array of |x|, applied to x of any shape block by block."""
    x = np.abs(np.asarray(x, dtype=float))
    flat = x.ravel()
    parts = [function(flat[i : i + BLOCK]) for i in range(0, flat.size, BLOCK)]
    return np.concatenate([np.empty(0), *parts]).reshape(x.shape)[()]


def _log_ratio(lost, ratio):
    """-ln(1 - lost), from lost where it is small and from ratio = 1/(1 - lost) elsewhere."""
    return np.where(lost < 0.5, -np.log1p(-np.minimum(lost, 0.5)), np.log(ratio))
