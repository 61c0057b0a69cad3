"""Contact fields as a superposition of flat punches: (6)-(8), (10), (11) and (18), (20)-(22).

The density n(s) of punches of half-width s is n_y in the normal and n_x in the tangential problem;
nothing else differs but the compliance.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np
from scipy.special import beta as euler_beta
from scipy.special import betainc

from . import punch_nodes
from .checks import require_positive_k
from .quadrature import by_blocks
from .special import punch_displacement, punch_gradient, punch_relative_displacement, punch_rigid_displacement

ROUND_OFF = 1e-12  # of the power with which the traction falls from a sharp tip, finite there if it is positive


@dataclass(frozen=True)
class PunchSuperposition:
    """Punches of half-widths start < s < a; fields take x of any shape and return that shape.

    k: exponent of (1). compliance: (bk) y0^k/E0 or (gk) y0^k/E0 [length^k / stress].
    density(s, a - s): n(s) for arrays [stress / length^k].
    power, edge_power: n ~ (s - start)^power and ~ (a - s)^edge_power at the ends.
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
        # the rules need to know a power that is not smooth; a higher one stays in the integrand
        object.__setattr__(self, "power", min(self.power, 1.0))

    @cached_property
    def load(self):
        """Resultant line load ∫ n s^k ds [stress x length], (6), (22)."""
        return self._moment(self.k)

    @cached_property
    def rigid_displacement(self):
        """Displacement of |x| <= start: delta_y (11), delta_x (39) [length]. k > 0 only."""
        require_positive_k(self.k, "the rigid-body displacement")
        return self.compliance * punch_rigid_displacement(self.k) * self._moment(0.0)

    def traction(self, x):
        """p (7) or q (18) [stress]; zero for |x| >= a, infinite at x = 0 if start = 0 and power + k <= 0."""
        return by_blocks(self._traction, x) / euler_beta(0.5, (1 + self.k) / 2)

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

    # -- each field at a 1-d array of x >= 0 -------------------------------------------------------

    def _moment(self, exponent):
        """∫ n s^exponent ds."""
        nodes = punch_nodes.all_punches(self, exponent)
        return float(nodes.integrate(self, nodes.s**exponent))

    def _traction(self, x):
        beyond, result = punch_nodes.beyond_start(self, x), np.zeros_like(x)
        above = (beyond >= 0) & (x > 0) & (x < self.a)
        result[above] = punch_nodes.abel_from_x(self, x[above, None]).integrate(self)
        below = beyond < 0
        result[below] = punch_nodes.abel_from_start(self, x[below, None]).integrate(self)
        if self.start == 0 and np.any(x == 0):
            result[x == 0] = self._moment(self.k - 1) if self.power + self.k > ROUND_OFF else inf
        return result

    def _traction_within(self, x):
        """Load of the punches narrower than x, and the share of the wider ones' tractions (12)."""
        result = np.where(x < self.a, 0.0, self.load)
        half = (1 + self.k) / 2
        edge = (x > max(self.start, self.a / 2)) & (x < self.a)
        middle = (x > 0) & (x < self.a) & ~edge
        for part in (edge, middle):
            column = x[part, None]
            nodes = punch_nodes.wider_than(self, column)
            s, y = nodes.s, nodes.beyond * (nodes.s + column) / nodes.s**2
            missing = betainc(half, 0.5, y)
            if part is edge:
                result[part] = self.load - nodes.integrate(self, s**self.k * missing)
            else:
                inside = betainc(0.5, half, np.minimum(column / s, 1) ** 2)
                share = np.where(y < 0.5, 1 - missing, inside)
                result[part] = nodes.integrate(self, s**self.k * share)
        for i in np.flatnonzero(middle & (punch_nodes.beyond_start(self, x) > 0)):
            width = punch_nodes.beyond_start(self, x[i])
            result[i] += self._up_to(x[i], width).load
        return result

    def _up_to(self, x, width):
        """The punches narrower than x < a."""
        wider = self.a - x
        return replace(self, density=lambda s, e: self.density(s, wider + e), a=x, width=width, edge_power=0.0)

    def _relative_displacement(self, x):
        powers = min(self.k, 0.0), (1 - self.k) / 2
        return self._kernel_integral(x, punch_relative_displacement, *powers)

    def _gradient(self, x):
        return self._kernel_integral(x, punch_gradient, self.k, -(1 + self.k) / 2)

    def _displacement(self, x):
        outside = x > self.a
        result = np.full(x.shape, self.rigid_displacement / self.compliance)
        result[~outside] -= self._relative_displacement(x[~outside])
        result[outside] = self._outside(x[outside, None], punch_displacement, 0.0)
        return result

    def _kernel_integral(self, x, kernel, kernel_power, end_power):
        """∫_start^min(x,a) n kernel(s/x) ds, kernel ~ s^kernel_power at 0, ~ (x-s)^end_power."""
        result = np.zeros_like(x)
        slipped = punch_nodes.beyond_start(self, x) > 0
        for part in (slipped & (x < self.a), slipped & (x == self.a)):
            column = x[part, None]
            nodes = punch_nodes.narrower_than(self, column, kernel_power, end_power)
            values = kernel(column, nodes.s, self.k, nodes.beyond)
            result[part] = nodes.integrate(self, values)
        outside = x > self.a
        result[outside] = self._outside(x[outside, None], kernel, kernel_power)
        return result

    def _outside(self, x, kernel, kernel_power):
        parts = punch_nodes.seen_from_outside(self, x, kernel_power)
        return sum(nodes.integrate(self, kernel(x, nodes.s, self.k)) for nodes in parts)
