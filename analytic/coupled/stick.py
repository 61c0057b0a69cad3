"""Basis on the zone of stick: panels with a singular power at both ends, polynomials in between."""

from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import legvander

from ..quadrature import gauss_rule
from .panels import GAUSS, GAUSS_WEIGHT, NODES, TO_LEGENDRE, Panels

END = 0.6  # length of the panel at an end over the distance to the nearest other singular point
GROWTH = 2.0  # of the panels from there on
FEATURE = 1e-6  # distance of an end from another singular point, over the width of the zone, taken for zero
RATIO, PARTS = 0.3, 11  # of the parts of the panel at an end over which the kernels are integrated,
OUTSIDE, COARSE = 2, 1  # their number for points outside of it, and for kernels that are smooth there
CLUSTER = 1.5  # collocation points at an end are gathered by the power 1 + CLUSTER k; not for k < 0, where noise counts


def power_weights(exponent):
    """Weights of ∫_0^1 v^exponent g(v) dv at the Gauss nodes (1 + GAUSS)/2, over those of the Gauss rule."""
    moments = np.empty(NODES)
    value = 1 / (exponent + 1)
    for degree in range(NODES):
        moments[degree] = value
        value *= (exponent - degree) / (exponent + degree + 2)
    return moments @ TO_LEGENDRE / (GAUSS_WEIGHT / 2)


@lru_cache(maxsize=256)
def end_rule(exponent, size, parts):
    """Points of the parts of 0 < v < 1, and v^exponent P_j(2v - 1), j < size, at their Gauss nodes.

    Those of the first part are scaled: with them the Gauss rule integrates the singular power exactly.
    """
    points = np.concatenate([[0.0], RATIO ** np.arange(parts - 1.0, -1.0, -1.0)])
    v = Panels.between(points).nodes
    values = legvander(2 * v - 1, size - 1) * v[:, None] ** exponent
    values[:NODES] *= ((points[1] / v[:NODES]) ** exponent * power_weights(exponent))[:, None]
    return points, values


def end_points(size, k):
    """Collocation points on the panel at an end."""
    return gauss_rule(size)[0] ** (1 + CLUSTER * max(k, 0.0))


@lru_cache(maxsize=64)
def own_matrices(exponent, size, k):
    """∫_0^1 R, ∫_0^1 O and ∫_0^1 over v^exponent P_j(2v - 1), j < size, the first two at ``end_points``."""
    points, values = end_rule(exponent, size, PARTS)
    panels = Panels.between(points)
    even, odd = panels.matrices(end_points(size, k), k)
    return even @ values, odd @ values, panels.weights @ values


def _graded_towards(c_l, c_r, singular_points):
    """Distances from both ends of the points between panels, over the width of the zone; the last are 1/2."""
    width = c_r - c_l
    result = []
    for end in (c_l, c_r):
        distance = np.abs(np.asarray(singular_points) - end)
        first = min(END * distance[distance > FEATURE * width].min() / width, 0.5)
        points = [0.0, first]
        while points[-1] < 0.5:
            points.append(points[-1] * GROWTH)
        if len(points) > 2:
            points[-1] = 0.5
            if 0.5 - points[-2] < 0.3 * (points[-2] - points[-3]):
                points.pop(-2)
        result.append(np.array(points))
    return result


class StickBasis:
    """Basis on c_l < x < c_r for the distance r = friction p - q to the limit of friction.

    At the ends it is distance^(exponent - 1) times polynomials; the first of these powers has no bound, and its
    amplitude should vanish: it tells where the edge is. Elsewhere the basis is of polynomials.
    singular_points: of tractions, the ends among them; exponents: at both ends; order: polynomials on a panel.
    points: of collocation, as many as functions, ``size``; inner: where panels of polynomials begin and end.
    """

    def __init__(self, c_l, c_r, singular_points, exponents, order, k):
        self._k, width = k, c_r - c_l
        left, right = _graded_towards(c_l, c_r, singular_points)
        self.breaks = np.concatenate([c_l + width * left, (c_r - width * right)[-2::-1]])
        self.exponents, self.order = [e - 1 for e in exponents], order
        self.lengths = width * left[1], width * right[1]
        self.inner = self.breaks[1:-1]
        self.panels = len(self.inner) - 1
        self.end_size = order + 1
        self.size = 2 * self.end_size + self.panels * order
        v = end_points(self.end_size, k)
        low, high = self.inner[:-1, None], self.inner[1:, None]
        middle = low + (high - low) * gauss_rule(order)[0]
        ends = c_l + self.lengths[0] * v, (c_r - self.lengths[1] * v)[::-1]
        self.points = np.concatenate([ends[0], middle.ravel(), ends[1]])

    def matrices(self):
        """∫ R and ∫ O over the basis at ``points``, two matrices (size, size)."""
        k = self._k
        even, odd = (self.contracted(m, OUTSIDE) for m in self.rule(OUTSIDE).matrices(self.points, k))
        n = self.end_size
        for here, length, exponent, way in zip((slice(n), slice(-n, None)), self.lengths, self.exponents, (1, -1)):
            own_even, own_odd, moments = own_matrices(exponent, n, k)
            at_length = np.expm1(-k * np.log(length)) / k if k else -np.log(length)  # R(c z) = c^-k R(z) + R(c)
            power = 1 + k * at_length
            even[here, here] = length * (power * own_even + at_length * moments)[::way]
            odd[here, here] = way * length * power * own_odd[::way]
        return even, odd

    def rule(self, parts):
        """Panels over the zone, the ends in so many ``parts``; see ``contracted``."""
        (left, _), (right, _) = (end_rule(e, self.end_size, parts) for e in self.exponents)
        points = [self.breaks[0] + self.lengths[0] * left, self.inner, self.breaks[-1] - self.lengths[1] * right[::-1]]
        return Panels.between(np.concatenate([points[0][:-1], points[1], points[2][1:]]))

    def contracted(self, matrix, parts):
        """A matrix (rows, nodes) that acts on values at the nodes of ``rule`` acts on coefficients, (rows, size)."""
        (_, left), (_, right) = (end_rule(e, self.end_size, parts) for e in self.exponents)
        at_left, at_right = parts * NODES, matrix.shape[1] - parts * NODES
        middle = matrix[:, at_left:at_right].reshape(len(matrix), self.panels, NODES)
        polynomials = legvander(GAUSS, self.order - 1)
        return np.hstack([
            matrix[:, :at_left] @ left,
            (middle @ polynomials).reshape(len(matrix), -1),
            matrix[:, at_right:] @ right[::-1],
        ])

    def values(self, x, c):
        """Function with the coefficients c at x in the zone, without what else is known between ``inner``."""
        result = np.empty(len(x))
        ends = (x - self.breaks[0], c[: self.end_size]), (self.breaks[-1] - x, c[-self.end_size :])
        middle = np.ones(len(x), dtype=bool)
        for (distance, part), length, exponent, edge in zip(ends, self.lengths, self.exponents, (0, 1), strict=True):
            here = x < self.inner[0] if edge == 0 else x >= self.inner[-1]
            v = np.maximum(distance[here] / length, 1e-300)
            # the power without bound, whose amplitude vanishes, is taken from the polynomial
            result[here] = _without_first(v, exponent, part)
            middle &= ~here
        if middle.any():
            at = x[middle]
            j = np.clip(np.searchsorted(self.inner, at, side="right") - 1, 0, self.panels - 1)
            low, high = self.inner[j], self.inner[j + 1]
            P = legvander((2 * at - low - high) / (high - low), self.order - 1)
            coefficients = c[self.end_size : -self.end_size].reshape(self.panels, self.order)
            result[middle] = np.einsum("nl,nl->n", P, coefficients[j])
        return result

    def amplitudes(self, c):
        """Factors of distance^(exponent - 1) at both ends, and of distance^exponent that follow, shape (2, 2)."""
        degrees = np.arange(self.end_size)
        first, second = (-1.0) ** degrees, -((-1.0) ** degrees) * degrees * (degrees + 1)
        parts = c[: self.end_size], c[-self.end_size :]
        ends = zip(parts, self.lengths, self.exponents, strict=True)
        return np.array([[first @ p * h**-e, second @ p * h ** -(e + 1)] for p, h, e in ends]).T


def _without_first(v, exponent, c):
    """v^exponent times (the polynomial with coefficients c less its value at v = 0)."""
    signs = (-1.0) ** np.arange(len(c))
    return v**exponent * ((legvander(2 * v - 1, len(c) - 1) - signs) @ c)
