"""Exponents with which tractions end at the edges of contact and of stick."""

from math import atan2, cos, pi

import numpy as np


def coupling_ratio(k, bk, d):
    """d cos(k pi/2) / (b sin(k pi/2)): ratio of the kernels' transforms, finite for k = 0."""
    return d * cos(k * pi / 2) / (bk * pi / 2 * float(np.sinc(k / 2)))


def edge_exponent(k, bk, d, friction):
    """Exponent of the pressure at the right edge of contact, where q = friction p up to the edge.

    It makes the half-line problem of the kernel b|x|^-k - friction d sgn(x)|x|^-k homogeneous:
    cot(pi (exponent - k/2)) = friction coupling_ratio. The left edge has the opposite friction.
    Inside the contact, at the right edge of a stick zone beside slip with q = friction p, the distance friction p - q
    to the limit ends with the exponent of the opposite friction.
    """
    return k / 2 + atan2(1.0, friction * coupling_ratio(k, bk, d)) / pi


def hilbert_factors(k, bk, d, friction):
    """Factors of r = friction p - q and of its Hilbert transform H r in p where no edge of contact is near.

    Contact means (1 - friction ratio H) p = -ratio H r, ratio = ``coupling_ratio``, and H² = -1.
    """
    ratio = coupling_ratio(k, bk, d)
    whole = 1 + (friction * ratio) ** 2
    return friction * ratio**2 / whole, -ratio / whole
