"""Exponents with which tractions end at the edges of contact and of stick."""

from math import atan2, atanh, cos, pi, sqrt

import numpy as np


def hilbert_ratio(k):
    """tau = k cot(k pi/2), 2/pi for k = 0: the kernel O is tau times the Hilbert transform of R, see ``panels``."""
    return 2 / pi * cos(k * pi / 2) / float(np.sinc(k / 2))


def coupling_ratio(k, bk, d):
    """d cos(k pi/2) / (b sin(k pi/2)): ratio of the kernels' transforms, finite for k = 0."""
    return hilbert_ratio(k) * d / bk


def oscillation(k, bk, gk, d):
    """epsilon of docs/equations.md: at an edge that sticks rates of traction end like distance^((k-1)/2) times cos and
    sin of epsilon ln(distance).

    0 at the Holl ratio, ln(3-4 nu)/(2 pi) for k = 0.
    """
    return -atanh(coupling_ratio(k, sqrt(bk * gk), d)) / pi


def edge_exponent(k, bk, d, friction):
    """Exponent of the pressure at the right edge of contact, where q = friction p up to the edge.

    It makes the half-line problem of the kernel b|x|^-k - friction d sgn(x)|x|^-k homogeneous:
    cot(pi (exponent - k/2)) = friction coupling_ratio. The left edge has the opposite friction.
    Inside the contact, at the right edge of a stick zone beside slip with q = friction p, the distance friction p - q
    to the limit ends with the exponent of the opposite friction.
    """
    return k / 2 + atan2(1.0, friction * coupling_ratio(k, bk, d)) / pi


def edge_exponents(k, bk, d, friction):
    """Exponents with which p ends at x_l, friction p - q at c_l and c_r, and p at x_r; q = friction p in slip."""
    minus, plus = (edge_exponent(k, bk, d, sign * friction) for sign in (-1, 1))
    return minus, plus, minus, plus


def hilbert_factors(k, bk, d, friction):
    """Factors of r = friction p - q and of its Hilbert transform H r in p where no edge of contact is near.

    Contact means (1 - friction ratio H) p = -ratio H r, ratio = ``coupling_ratio``, and H² = -1.
    """
    ratio = coupling_ratio(k, bk, d)
    whole = 1 + (friction * ratio) ** 2
    return friction * ratio**2 / whole, -ratio / whole
