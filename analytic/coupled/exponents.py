"""Exponents with which tractions end at the edges of contact and of stick."""

from math import atan2, cos, pi, sin, tan

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


def pressure_beside_stick_edge(ratio, friction, exponent):
    """Factors of p in stick and in slip at the right edge of a stick zone, where friction p - q = s^(exponent - 1).

    s: distance from the edge; ratio: ``coupling_ratio``, with the opposite sign at the left edge.
    With the Hilbert transform H of r = friction p - q, contact means (1 + (friction ratio)²) p =
    friction ratio² r - ratio H r; H r is -cot(pi exponent) r in stick and s^(exponent - 1)/sin(pi exponent) in slip.
    """
    whole = 1 + (friction * ratio) ** 2
    stick = friction * ratio**2 + ratio / tan(pi * exponent)
    return stick / whole, -ratio / sin(pi * exponent) / whole
