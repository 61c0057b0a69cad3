"""Product integration of the surface kernels over panels of Gauss nodes.

Two functions of the distance z carry every surface kernel of a power-law half-plane, [X6] in docs/coupling_kernel.md:
the even R(z) = (|z|^-k - 1)/k, which is -ln|z| for k = 0, and the odd O(z) = sgn(z) |z|^-k. Lengths have no unit here.
"""

from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

NODES = 16  # of a panel
NEAR = 0.15  # distance from a panel over its length below which the kernel is integrated over a polynomial
EXPM1 = 0.05  # |k| below which R needs expm1
GAUSS, GAUSS_WEIGHT = leggauss(NODES)
# coefficients of Legendre polynomials from values at the Gauss nodes
TO_LEGENDRE = legvander(GAUSS, NODES - 1).T * GAUSS_WEIGHT * (np.arange(NODES)[:, None] + 0.5)


def even_kernel(z, k):
    """R at distances z > 0."""
    result = np.log(z)
    result *= -k if k else -1.0
    if not k:
        return result
    if abs(k) > EXPM1:  # exp is faster
        np.exp(result, out=result)
        result -= 1
    else:
        np.expm1(result, out=result)
    result /= k
    return result


@lru_cache(maxsize=64)
def singular_weights(k):
    """Weights of ∫_0^1 R(v) g(v) dv at the Gauss nodes (1 + GAUSS)/2, exact for polynomials of degree < NODES."""
    # ∫_0^1 v^-k P_l(2v - 1) dv = (-1)^l k (k+1) ... (k+l-1) / ((1-k) (2-k) ... (l+1-k))
    moments = np.empty(NODES)
    moments[0] = 1 / (1 - k)
    value = -1 / ((1 - k) * (2 - k))
    for degree in range(1, NODES):
        moments[degree] = value
        value *= -(k + degree) / (degree + 2 - k)
    return moments @ TO_LEGENDRE


def graded(low, high, to_low, to_high, ratio):
    """Break points from low to high; panels shrink by ``ratio`` so many times towards the ends, from the middle."""
    half = (high - low) / 2
    points = [[low, low + half, high]] if to_low or to_high else [[low, high]]
    points += [low + half * ratio ** np.arange(1, to_low + 1), high - half * ratio ** np.arange(1, to_high + 1)]
    return np.unique(np.concatenate(points))


def divided(points, longest):
    """Points with others between them, none further than ``longest`` from the next."""
    parts = np.maximum(np.ceil(np.diff(points) / longest), 1).astype(int)
    pieces = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(points, points[1:], parts, strict=False)]
    return np.append(np.concatenate(pieces), points[-1])


class Panels:
    """Gauss nodes of the panels between ``low`` and ``high``, shape (n,) each, for densities smooth on every panel.

    nodes, weights: shape (n NODES,), panel by panel.
    """

    def __init__(self, low, high):
        self.low, self.high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
        self.half = (self.high - self.low) / 2
        self.middle = (self.high + self.low) / 2
        self.nodes = (self.middle[:, None] + self.half[:, None] * GAUSS).ravel()
        self.weights = (self.half[:, None] * GAUSS_WEIGHT).ravel()

    @classmethod
    def between(cls, points):
        """Panels between neighbouring points."""
        return cls(points[:-1], points[1:])

    def matrices(self, x, k):
        """∫ R(x - t) g(t) dt and ∫ O(x - t) g(t) dt as matrices (len(x), nodes) acting on g at the nodes."""
        z = x[:, None] - self.nodes
        i, j = np.nonzero(np.abs(x[:, None] - self.middle) < (1 + 2 * NEAR) * self.half)
        distance, shape = np.abs(z), (len(x), len(self.low), NODES)
        distance.reshape(shape)[i, j] = 1.0
        even = even_kernel(distance, k)
        odd = np.multiply(even, k, out=distance)
        odd += 1
        odd *= self.weights
        np.copysign(odd, z, out=odd)
        even *= self.weights
        if len(i):
            even_near, odd_near = self._near(x[i], j, k)
            even.reshape(shape)[i, j], odd.reshape(shape)[i, j] = even_near, odd_near
        return even, odd

    def cauchy(self, x):
        """(1/pi) ∫ g(t)/(x - t) dt as a matrix (len(x), nodes) acting on g at the nodes; principal value within."""
        z = x[:, None] - self.nodes
        i, j = np.nonzero(np.abs(x[:, None] - self.middle) < (1 + 2 * NEAR) * self.half)
        z.reshape(len(x), len(self.low), NODES)[i, j] = 1.0
        result = self.weights / z
        if len(i):
            local = (x[i] - self.middle[j]) / self.half[j]
            result.reshape(len(x), len(self.low), NODES)[i, j] = _near_cauchy(local)
        result /= np.pi
        return result

    def _near(self, x, j, k):
        """Weights (pairs, NODES) of panel j for a point x in it or close by: the parts on both sides of x."""
        local = (x - self.middle[j]) / self.half[j]
        result = np.zeros((len(x), 2, NODES))
        v, base = (1 + GAUSS) / 2, singular_weights(k)
        for end, place in ((-1.0, self.low[j]), (1.0, self.high[j])):
            reach = (place - x) / self.half[j]  # from x to this end of the panel, without rounding close to it
            length = np.abs(place - x)
            here = length > 0
            length = np.where(here, length, 1.0)
            # R(c v) = c^-k R(v) + R(c)
            at_end = even_kernel(length, k)[:, None]
            part = (1 + k * at_end) * base + at_end * (GAUSS_WEIGHT / 2)
            power = (1 + k * at_end) * (GAUSS_WEIGHT / 2 + k * base)
            parts = np.stack([part * (end * np.sign(reach))[:, None], -end * power], axis=1)
            at = (local[:, None] + reach[:, None] * v).ravel()
            values = legvander(at, NODES - 1).reshape(len(x), NODES, NODES)
            result += (parts * (length * here)[:, None, None]) @ values
        return np.moveaxis(result @ TO_LEGENDRE, 1, 0)


def _near_cauchy(x):
    """Weights (n, NODES) of ∫_-1^1 g(t)/(x - t) dt for points x within -1 < t < 1 or close by."""
    log = np.log(np.abs(1 + x) / np.maximum(np.abs(1 - x), 1e-300)) if len(x) else x
    result = np.empty((len(x), NODES))
    inside = np.abs(x) < 1.01
    at = x[inside]
    Q = np.empty((NODES, len(at)))  # 2 Q_n, Legendre functions of the second kind
    Q[0], Q[1] = log[inside], at * log[inside] - 2
    for n in range(2, NODES):
        Q[n] = ((2 * n - 1) * at * Q[n - 1] - (n - 1) * Q[n - 2]) / n
    result[inside] = Q.T @ TO_LEGENDRE
    at = x[~inside]  # the part of g(x) is integrated in closed form
    g = legvander(at, NODES - 1) @ TO_LEGENDRE
    ratio = GAUSS_WEIGHT / (at[:, None] - GAUSS)
    result[~inside] = ratio + g * (log[~inside] - ratio.sum(axis=1))[:, None]
    return result
