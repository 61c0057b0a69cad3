"""Quadrature over a contact of functions with the powers of its edges in them, or with weak singularities."""

from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.special import roots_sh_jacobi

from ..quadrature import gauss_rule
from .panels import Panels, divided

RATIO = 0.35  # of panels towards an edge, as far as points of stick are
END, END_NODES = 0.5, 12  # piece at an edge that has Gauss-Jacobi rules, over the width of slip, and nodes of each;
END_OF_TERMS = 50.0  # its greatest length over half the contact, times the square of the number of polynomials
SMOOTH_NODES = 24  # of ``smooth_rule`` between two breaks
_jacobi_rule = lru_cache(maxsize=64)(roots_sh_jacobi)


class ContactRule:
    """Nodes x in a contact, for integrals of w f, w f/(1 - t²), v f and root f over it.

    v = (1 - t²)^(k/2), root = (1 - t²)^(1/2); f has no singularity at the edges, but may have some in stick. At the
    edges each of the three powers of distance has nodes of its own, at which the others are zero.
    contact: see ``weight.ContactInterval``; stick: its two ends.
    t: nodes over half the contact; w, w_over, v, root: at the nodes, shape (n,); weights: of the sum over nodes.
    """

    def __init__(self, contact, stick):
        half, k = contact.half, contact.problem.k
        gaps = (stick[0] - contact.x_l) / half, (contact.x_r - stick[1]) / half
        longest = contact.problem.longest / half
        end = END_OF_TERMS / max(contact.problem.terms, 1) ** 2
        left, right = (_offsets(min(END * gap, end), longest) for gap in gaps)
        near_left, near_right = Panels.between(left).nodes, Panels.between(right).nodes[::-1]
        self._panels = Panels.between(np.append(contact.x_l + half * left, contact.x_r - half * right[-2::-1]))
        powers = [(e - 1, k / 2, 0.5) for e in (contact.left, contact.right)]
        ends = [[_end_rule(p, o[0]) for p in pair] for pair, o in zip(powers, (left, right), strict=True)]
        self._contact, self._ends = contact, list(zip(powers, (left[0], right[0]), strict=True))
        at_left, at_right = (np.concatenate([distance for distance, _ in end]) for end in ends)
        from_left = np.concatenate([at_left, near_left, 2 - near_right, 2 - at_right])
        from_right = np.concatenate([2 - at_left, 2 - near_left, near_right, at_right])
        self.t, over = from_left - 1, from_left * from_right
        self._n = n = len(at_left)
        middle = slice(n, len(over) - n)
        self.x = np.concatenate([contact.x_l + half * at_left, self._panels.nodes, contact.x_r - half * at_right])
        self.weights = np.ones(len(over))
        self.weights[middle] = self._panels.weights
        self.w_over, self.v, self.root = functions = np.zeros((3, len(over)))
        for function, left, right in zip(functions, *powers, strict=True):
            function[middle] = from_left[middle] ** left * from_right[middle] ** right
        for i, function in enumerate(functions):
            here = slice(i * END_NODES, (i + 1) * END_NODES)
            function[here] = half * ends[0][i][1] * from_right[here] ** powers[1][i]
            here = slice(len(over) - n + here.start, len(over) - n + here.stop)
            function[here] = half * ends[1][i][1] * from_left[here] ** powers[0][i]
        self.w = self.w_over * over

    def odd(self, x):
        """O(x - nodes), shape (len(x), n), to be summed with w, w_over or v times a function at the nodes."""
        n, k, z = self._n, self._contact.problem.k, x[:, None]
        left, right = (z - self.x[:n]) ** -k, -((self.x[-n:] - z) ** -k)
        return np.hstack([left, self._panels.matrices(x, k)[1], right])

    def sign(self, x):
        """``odd`` for k = 0 and any x in the contact: what the nodes at an edge stand for is cut at x."""
        n, distances = self._n, self._contact.local(x)[1:]
        result = np.ones((len(x), len(self.x)))
        result[:, n:-n], result[:, -n:] = self._panels.matrices(x, 0.0)[1], -1.0
        for way, nodes, distance in zip((1, -1), (slice(n), slice(-n, None)), distances, strict=True):
            powers, length = self._ends[way < 0]
            cut = distance < length
            result[cut, nodes] = way * (2 * np.hstack([_shares(p, distance[cut] / length) for p in powers]) - 1)
        return result


def smooth_rule(low, high, breaks):
    """Nodes and weights between low and high for functions with weak singularities at the ``breaks``."""
    t, w = gauss_rule(SMOOTH_NODES)
    points = np.unique([low, *[x for x in breaks if low < x < high], high])
    a, length = points[:-1, None], np.diff(points)[:, None]
    return (a + length * t**3 * (10 - 15 * t + 6 * t**2)).ravel(), (length * w * 30 * t**2 * (1 - t) ** 2).ravel()


def _offsets(end, longest):
    """Points from ``end`` to 1, panels between which grow by 1/RATIO up to ``longest``."""
    points = [1.0]
    while points[-1] * RATIO > end:
        points.append(points[-1] * RATIO)
    return divided(np.array([*points, end][::-1]), longest)


def _shares(power, v):
    """Weights of ∫_0^v t^power f dt over those of ``_end_rule`` for v = 1, shape (len(v), END_NODES)."""
    nodes, weight = _jacobi_rule(END_NODES, power + 1, power + 1)
    polynomials = np.linalg.inv(legvander(2 * nodes - 1, END_NODES - 1))
    values = legvander(2 * v[:, None] * nodes - 1, END_NODES - 1)
    return v[:, None] ** (power + 1) * (np.tensordot(weight, values, (0, 1)) @ polynomials) / weight


def _end_rule(power, length):
    """Distances from an edge and weights of ∫ distance^power f over 0 < distance < length."""
    v, weight = _jacobi_rule(END_NODES, power + 1, power + 1)
    return length * v, length ** (power + 1) * weight
