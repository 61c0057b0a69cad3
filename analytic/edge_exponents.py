"""Exponents with which tractions end at the edges of contact and of stick, with coupling [X6].

medium: anything with k, (bk), (gk) and d as a GradedHalfPlane has them, in any units; d is 0 without coupling.
"""

from math import atan2, atanh, cos, pi, sqrt

import numpy as np


def hilbert_ratio(k):
    """tau = k cot(k pi/2), 2/pi for k = 0: kernel O is tau times the Hilbert transform of R, see ``coupled.panels``."""
    return 2 / pi * cos(k * pi / 2) / float(np.sinc(k / 2))


def coupling_ratio(medium):
    """d cos(k pi/2) / (b sin(k pi/2)): ratio of the kernels' transforms, finite for k = 0."""
    return hilbert_ratio(medium.k) * medium.d / medium.bk


def oscillation(medium):
    """epsilon of docs/equations.md: at an edge that sticks rates of traction end like distance^((k-1)/2) times cos and
    sin of epsilon ln(distance).

    0 at the Holl ratio, ln(3-4 nu)/(2 pi) for k = 0.
    """
    return -atanh(coupling_ratio(medium) * sqrt(medium.bk / medium.gk)) / pi


def edge_exponent(medium, friction):
    """Exponent of the pressure at the right edge of contact, where q = friction p up to the edge.

    It makes the half-line problem of the kernel b|x|^-k - friction d sgn(x)|x|^-k homogeneous:
    cot(pi (exponent - k/2)) = friction coupling_ratio. The left edge has the opposite friction.
    Inside the contact, at the right edge of a stick zone beside slip with q = friction p, the distance friction p - q
    to the limit ends with the exponent of the opposite friction.
    """
    return medium.k / 2 + atan2(1.0, friction * coupling_ratio(medium)) / pi


def edge_exponents(medium, friction):
    """Exponents with which p ends at x_l, friction p - q at c_l and c_r, and p at x_r; q = friction p in slip."""
    minus, plus = (edge_exponent(medium, sign * friction) for sign in (-1, 1))
    return minus, plus, minus, plus


def hilbert_factors(medium, friction):
    """Factors of r = friction p - q and of its Hilbert transform H r in p where no edge of contact is near.

    Contact means (1 - friction ratio H) p = -ratio H r, ratio = ``coupling_ratio``, and H² = -1.
    """
    ratio = coupling_ratio(medium)
    whole = 1 + (friction * ratio) ** 2
    return friction * ratio**2 / whole, -ratio / whole
