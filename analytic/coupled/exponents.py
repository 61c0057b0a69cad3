"""Exponents with which tractions end at the edges of contact and of stick."""

from math import atan2, cos, pi

import numpy as np


def edge_exponent(k, bk, d, friction):
    """Exponent of the pressure at the right edge of contact, where q = friction p up to the edge.

    It makes the half-line problem of the kernel b|x|^-k - friction d sgn(x)|x|^-k homogeneous:
    cot(pi (exponent - k/2)) = friction d cos(k pi/2) k / (b k sin(k pi/2)). The left edge has the opposite friction.
    Inside the contact, at the right edge of a stick zone beside slip with q = friction p, the distance friction p - q
    to the limit ends with the exponent of the opposite friction.
    """
    return k / 2 + atan2(1.0, friction * d * cos(k * pi / 2) / (bk * pi / 2 * float(np.sinc(k / 2)))) / pi
