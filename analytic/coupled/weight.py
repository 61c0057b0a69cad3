"""Weights with which tractions end at both edges of a contact, and points that are gathered there."""

from functools import lru_cache, partial
from math import pi, sin

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebder, chebdiv, chebvander
from scipy.special import eval_jacobi, roots_jacobi

from ..edge_exponents import edge_exponents
from .panels import Panels

NEAR_RATIO, FAR_RATIO = 0.35, 0.1  # of panels towards an edge, as far as points of stick are, and from there on
PANEL_AT_EDGE = 1e-10  # panel at an edge


class ContactInterval:
    """Interval x_l < x < x_r of contact in slip with q = friction p, where p ends with ``exponents`` at both ends.

    The integral operator A p = u_y of slip has the kernel bk R - friction d O. With the weight w = (1 + t)^left
    (1 - t)^right, t from -1 to 1, it takes w/(1 - t²) times a polynomial to a polynomial of the same degree.
    """

    def __init__(self, problem, friction, x_l, x_r):
        self.problem, self.x_l, self.x_r = problem, x_l, x_r
        self.middle, self.half = (x_l + x_r) / 2, (x_r - x_l) / 2
        self.left, *_, self.right = edge_exponents(problem, friction)
        self.friction = friction

    def local(self, x):
        """t and the distances 1 + t, 1 - t."""
        return (x - self.middle) / self.half, (x - self.x_l) / self.half, (self.x_r - x) / self.half

    def weight(self, x):
        """w at x."""
        _, from_left, from_right = self.local(x)
        return np.maximum(from_left, 0) ** self.left * np.maximum(from_right, 0) ** self.right

    def of_profile(self):
        """A p = constant - height for p = w/(1 - t²) ((1 - t²) D(t) + a + b t): D as a Chebyshev series, and b."""
        D, b = self._pressures(lambda t: self.problem.slope(self.middle + self.half * t)[:, None], self.problem.degree)
        return Chebyshev(D[:, 0]), b[0]

    def of_heights(self, terms):
        """The same for heights T_j(t), 0 <= j < terms: D as Chebyshev coefficients (terms, terms), and b (terms,)."""
        if not terms:
            return np.empty((1, 0)), np.empty(0)
        return self._pressures(lambda t: _slopes(t, terms) / self.half, terms - 1)

    def _pressures(self, slope, degree):
        a, b = self.right - 1, self.left - 1
        t, projection, quotient, rest = _expansion(a, b, degree)
        orders = np.arange(1, degree + 1)
        factors = _factors(self.problem, self.friction, self.left, degree) * (orders + a + b + 1) / 2
        g = -(self.half**self.problem.k) / factors[:, None] * (projection @ slope(t))
        return quotient @ g, rest @ g

    def panels(self, stick):
        """Panels that shrink towards both edges, faster from the middle of the zones beside ``stick`` on."""
        c_l, c_r = (c - self.middle for c in stick)
        offsets = []
        for gap in ((c_l + self.half) / self.half, (self.half - c_r) / self.half):
            points = [1.0]
            while points[-1] > PANEL_AT_EDGE:
                points.append(points[-1] * (NEAR_RATIO if points[-1] > 0.5 * gap else FAR_RATIO))
            offsets.append(np.array([*points, 0.0])[::-1])
        points = np.concatenate([self.x_l + self.half * offsets[0], (self.x_r - self.half * offsets[1])[-2::-1]])
        return Panels.between(points)


def _factors(problem, friction, left, degree):
    """lambda_n of A [(1-t)^a (1+t)^b P_n^(a,b)] = lambda_n P_n^(b,a) half^(1-k), b = left - 1, 0 < n <= degree."""
    n, k = np.arange(2, degree + 1), problem.k
    rising = np.cumprod(np.append(1.0, (k + n - 1) / n))  # Γ(k+n)/(Γ(k+1) n!)
    return -(problem.bk - friction * problem.d * k) * rising * pi / sin(pi * (left - 1))


def _slopes(t, terms):
    """Derivatives of T_j at t, 0 <= j < terms, shape (len(t), terms)."""
    return chebvander(t, terms - 2) @ chebder(np.eye(terms))


@lru_cache(maxsize=32)
def _expansion(a, b, degree):
    """Of a slope at Gauss-Jacobi nodes t: factors g_n of P_{n-1}^(b+1,a+1), 0 < n <= degree, as a matrix that acts on
    it. Of Σ g_n P_n^(a,b): the quotient by 1 - t² as a Chebyshev series and the factor of t in the rest.
    """
    t, weight = roots_jacobi(degree + 8, b + 1, a + 1)
    orders = range(1, degree + 1)
    basis = np.array([eval_jacobi(n - 1, b + 1, a + 1, t) for n in orders])
    series = [Chebyshev.interpolate(partial(eval_jacobi, n, a, b), degree).coef for n in orders]
    quotients, rests = zip(*(chebdiv(s, [0.5, 0.0, -0.5]) for s in series), strict=True)
    quotient = np.array([np.append(q, np.zeros(degree + 1 - len(q))) for q in quotients]).T
    rest = np.array([np.append(r, 0.0)[1] for r in rests])
    return t, basis * weight / (basis**2 @ weight)[:, None], quotient, rest
