"""Piecewise polynomials with singular powers at both ends of a zone, and the surface kernels integrated over them."""

from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss

from .panels import GAUSS_WEIGHT, NODES, TO_LEGENDRE, Panels, legendre

RATIO = 1 / 3  # of neighbouring panels, graded towards an end
# ratio and number of the parts of the panel at an end over which the kernels are integrated, for points in the zone
# and for points elsewhere
WITHIN, ELSEWHERE = (0.3, 11), (0.15, 6)
CLUSTER = 2.0  # power that gathers the collocation points at an end
SMALLEST = 1e-30  # distance from an end that a singular power takes for zero


def power_weights(exponent):
    """Weights of ∫_0^1 v^exponent g(v) dv at the Gauss nodes (1 + GAUSS)/2, over those of the Gauss rule."""
    moments = np.empty(NODES)
    value = 1 / (exponent + 1)
    for degree in range(NODES):
        moments[degree] = value
        value *= (exponent - degree) / (exponent + degree + 2)
    return moments @ TO_LEGENDRE / (GAUSS_WEIGHT / 2)


class Half:
    """Basis on 0 < u < 1, singular at the end u = 0, with collocation points ``points``.

    The panel at the end has families v^exponent P_j(2v - 1), ``families`` being pairs (exponent, number), the others
    polynomials; ``levels`` is the number of times that the panels shrink, and v is u over the length of the first,
    ``tip``. A last family of one function is not counted for the points: ``extra`` is its place, or None.
    ``amplitude`` @ coefficients is the factor of v^exponent for the last of the families.
    """

    def __init__(self, families, levels, order):
        self.exponents = [exponent for exponent, _ in families]
        self.degrees = [number for _, number in families]
        self.breaks = np.concatenate([[0.0], RATIO ** np.arange(levels, -1.0, -1.0)])
        self.tip = self.breaks[1]
        self.order = order + 2
        first = sum(self.degrees)
        self.extra = first - 1 if self.degrees[-1] == 1 else None
        self.size = first + levels * self.order
        self.amplitude = np.zeros(self.size)
        self.amplitude[first - self.degrees[-1] : first] = (-1.0) ** np.arange(self.degrees[-1])
        v = (1 + leggauss(first - (self.extra is not None))[0]) / 2
        inner = (1 + leggauss(self.order)[0]) / 2
        low, high = self.breaks[1:-1, None], self.breaks[2:, None]
        self.points = np.concatenate([self.tip * v**CLUSTER, (low + (high - low) * inner).ravel()])

    def values(self, u):
        """Basis at u, shape (len(u), size)."""
        result = np.zeros((len(u), self.size))
        here = u < self.tip
        v, start = np.maximum(u[here] / self.tip, SMALLEST), 0
        P = legendre(2 * v - 1, max(self.degrees)).T
        for exponent, size in zip(self.exponents, self.degrees, strict=True):
            result[here, start : start + size] = P[:, :size] * (v**exponent)[:, None] if exponent else P[:, :size]
            start += size
        for low, high in zip(self.breaks[1:], self.breaks[2:], strict=False):
            here = (u >= low) & ((u < high) | (high == 1))
            if here.any():
                P = legendre((2 * u[here] - low - high) / (high - low), self.order)
                result[here, start : start + self.order] = P.T
            start += self.order
        return result

    def parts(self, ratio, count):
        """Points between which the basis is smooth, and the basis at the Gauss nodes of these panels.

        Those of the first panel are scaled: with them the Gauss rule integrates the singular powers exactly.
        """
        points = np.concatenate([[0.0], self.tip * ratio ** np.arange(count - 1.0, -1.0, -1.0), self.breaks[2:]])
        nodes = Panels.between(points).nodes
        result = self.values(nodes)
        v, length, start = nodes[:NODES] / self.tip, points[1] / self.tip, 0
        for exponent, size in zip(self.exponents, self.degrees, strict=True):
            result[:NODES, start : start + size] *= ((length / v) ** exponent * power_weights(exponent))[:, None]
            start += size
        return points, result


class Rule:
    """Panels (low, high) over a reference zone, and the basis at their Gauss nodes, shape (nodes, size)."""

    def __init__(self, left, right, ratio, count):
        (points, left_values), (mirrored, right_values) = left.parts(ratio, count), right.parts(ratio, count)
        self.low = np.concatenate([points[:-1], 2 - mirrored[:0:-1]])
        self.high = np.concatenate([points[1:], 2 - mirrored[-2::-1]])
        self.values = np.zeros((len(left_values) + len(right_values), left.size + right.size))
        self.values[: len(left_values), : left.size] = left_values
        self.values[len(left_values) :, left.size :] = right_values[::-1]

    def panels(self, shift=0.0, scale=1.0):
        """Panels of the image of the zone."""
        return Panels(shift + scale * self.low, shift + scale * self.high)


class ReferenceZone:
    """Basis on 0 < s < 2, singular at both ends; left and right are pairs (families, levels).

    points: of collocation; extras: places of the functions not counted for them, or None; within, elsewhere: rules for
    integrals at points of the zone, or elsewhere.
    """

    def __init__(self, left, right, order, k):
        self.left, self.right, self.k = Half(*left, order), Half(*right, order), k
        self.split, self.size = self.left.size, self.left.size + self.right.size
        self.points = np.concatenate([self.left.points, 2 - self.right.points[::-1]])
        right_extra = None if self.right.extra is None else self.split + self.right.extra
        self.extras = self.left.extra, right_extra
        self.within, self.elsewhere = (Rule(self.left, self.right, *parts) for parts in (WITHIN, ELSEWHERE))

    def values(self, from_left, from_right):
        """Basis at points given by their distances from both ends, shape (n, size)."""
        result = np.zeros((len(from_left), self.size))
        left = from_left < 1
        result[left, : self.split] = self.left.values(from_left[left])
        result[~left, self.split :] = self.right.values(from_right[~left])
        return result

    @cached_property
    def moments(self):
        """∫ of the basis, shape (size,)."""
        return self.within.panels().weights @ self.within.values

    @cached_property
    def own(self):
        """∫ R and ∫ O over the basis at the points of the zone itself, two matrices (points, size)."""
        even, odd = self.within.panels().matrices(self.points, self.k)
        return even @ self.within.values, odd @ self.within.values
