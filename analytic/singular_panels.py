"""Piecewise polynomials with one singular end, and the integrals of kernels |x - ξ|^(-k-1) over them.

Positions are distances y = x - c from a point c > 0 towards which the panels are graded; z = x - ξ then has all its
digits however narrow a panel is. Densities live on x > 0; their mirror images on x < 0 are integrated as well.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.special import roots_jacobi

from .quadrature import gauss_rule, plain_rule

jacobi_rule = lru_cache(roots_jacobi)
NODES = 24  # on either side of the middle of a panel that a target is close to, or whose density is singular


@dataclass(frozen=True)
class SingularPanels:
    """Densities (distance to the end of the last panel)^power times a polynomial with ``terms`` terms, per panel.

    centre: c [length]. lo, hi: ends of the panels as distances from c, shape (J,). k: exponent of the kernels.
    """

    centre: float
    lo: np.ndarray
    hi: np.ndarray
    power: float
    terms: int
    k: float

    @cached_property
    def width(self):
        """Of the panels [length]."""
        return self.hi - self.lo

    def basis(self, j, from_lo, to_hi):
        """The basis functions of panel j at the distances from its ends, shape (..., terms)."""
        gap, width = self.hi[-1] - self.hi[j], self.width[j]
        weight = ((gap + to_hi) / (gap + width / 2)) ** self.power
        return weight[..., None] * legvander(2 * from_lo / width - 1, self.terms - 1)

    def nodes(self, j):
        """Distances from both ends of panel j, and weights, for its density times any function with powers there."""
        t, rest, weight = plain_rule(0.0, self.power if j == len(self.lo) - 1 else 0.0, NODES)
        return self.width[j] * t, self.width[j] * rest, self.width[j] * weight

    def gauss(self, j, number):
        """The same for a smooth density and function."""
        t, weight = gauss_rule(number)
        return self.width[j] * t, self.width[j] * (1 - t), self.width[j] * weight

    def moments(self, y, owner):
        """∫ sgn(x-ξ)|x-ξ|^(-k-1), k ∫ |x-ξ|^(-k-1), ∫ (x+ξ)^(-k-1) over every basis function, each (len(y), J terms).

        y: targets as distances from c; owner: the panel that contains each of them, or -1. The first two are
        finite parts in Hadamard's sense; the second tends to -2 times the density for k -> 0.
        """
        shape = (len(y), len(self.lo), self.terms)
        odd, even, mirror = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        for j, (lo, hi) in enumerate(zip(self.lo, self.hi, strict=True)):
            mirror[:, j] = self._seen(j, (self.centre + y) + (self.centre + lo), from_right=False)
            for mask, distance, sign in ((y >= hi, y - hi, 1), (y <= lo, lo - y, -1)):
                mask &= owner != j
                value = self._seen(j, distance[mask], from_right=sign > 0)
                odd[mask, j], even[mask, j] = sign * value, self.k * value
            own = owner == j
            if own.any():
                odd[own, j], even[own, j] = self._own(j, y[own])
        return [m.reshape(len(y), -1) for m in (odd, even, mirror)]

    @cached_property
    def _weighted_basis(self):
        """Per panel, for near and for far targets: distances of nodes from both ends, and basis times weight."""
        last = len(self.lo) - 1
        far = [*(self.gauss(j, self.terms + 8) for j in range(last)), self.nodes(last)]
        rules = [(self.nodes(j), far[j]) for j in range(last + 1)]
        return [
            [(from_lo, to_hi, weight[:, None] * self.basis(j, from_lo, to_hi)) for from_lo, to_hi, weight in pair]
            for j, pair in enumerate(rules)
        ]

    def _seen(self, j, distance, from_right):
        """∫ |x-ξ|^(-k-1) over panel j from targets beside it."""
        result = np.empty((len(distance), self.terms))
        near = distance < self.width[j]
        for mask, (from_lo, to_hi, basis) in zip((near, ~near), self._weighted_basis[j], strict=True):
            z = distance[mask, None] + (to_hi if from_right else from_lo)
            result[mask] = z ** (-self.k - 1) @ basis
        return result

    def _own(self, j, y):
        """Finite parts for targets in panel j: about the target as far as the density is smooth, and beyond."""
        k, left, right = self.k, (y - self.lo[j])[:, None], (self.hi[j] - y)[:, None]
        reach = np.minimum(np.minimum(left, right), (self.hi[-1] - y)[:, None] / 2)
        t, weight = jacobi_rule(self.terms + 6, 0, -k)
        z, weight = reach * (1 + t) / 2, weight * 2 ** (k - 1) / ((1 + t) / 2)
        below, above = self.basis(j, left - z, right + z), self.basis(j, left + z, right - z)
        middle, scale = self.basis(j, left, right), reach**-k
        odd = scale * np.einsum("s,isn->in", weight, below - above)
        even = scale * (k * np.einsum("s,isn->in", weight, below + above - 2 * middle) - 2 * middle[:, 0])
        for sign, length in ((1, left), (-1, right)):
            if sign < 0 and j == len(self.lo) - 1:
                t, rest, weight = plain_rule(0.0, self.power, NODES)
                span = np.maximum(length - reach, 0.0)
                z, to_end, weight = reach + span * t, span * rest, span * weight
            else:  # over ln z
                t, weight = gauss_rule(NODES)
                span = np.log(length / reach)
                z = reach * np.exp(span * t)
                to_end, weight = np.maximum(length - z, 0.0), span * weight * z
            ends = (to_end, right + z) if sign > 0 else (left + z, to_end)
            value = np.einsum("is,isn->in", z ** (-k - 1) * weight, self.basis(j, *ends))
            odd, even = odd + sign * value, even + k * value
        return odd, even
