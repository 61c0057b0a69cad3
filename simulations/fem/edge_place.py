"""Place in its facet at which an edge of contact or stick costs least accuracy.

Beside an edge at x = e a traction is like (e - x)^β, β = (1+k)/2, (44), (47). The surface nodes carry it with the
weights of the Gauss-Lobatto rule of every facet. What this rule misses is φ(t) h^(1+β), with h the facet and t the
place of e in it:

    φ(t) = Σ_j w_j ζ(-β, {t - ξ_j}),

with nodes ξ_j and weights w_j on [0, 1], {} the fractional part and ζ Hurwitz's zeta function (Navot's extension of the
Euler-Maclaurin formula, J. Math. Phys. 40, 1961, 271). From afar it is a line force at the edge, and most of the error.
"""

from functools import cache

import numpy as np
from scipy.optimize import brentq

from .lagrange import LOBATTO

OFF_NODE = 0.05  # from a node of the mesh, which is to lie on one side of the edge for sure
STEEP_K = -0.68  # k below which, with degree 2, the place is one measured (docs/accuracy.md):
MEASURED = (-0.9, -0.7), (0.6, 0.65)  # k, place
TERMS = 12  # of the sum before the rest follows from the Euler-Maclaurin formula


def zeta(power: float, t):
    """Hurwitz's ζ(-power, t) for t > 0 of any shape and 0 < power < 2, to 5e-9."""
    t = np.asarray(t, dtype=float)
    end = t + TERMS
    rest = -(end ** (power + 1)) / (power + 1) + end**power / 2 - power * end ** (power - 1) / 12
    rest += power * (power - 1) * (power - 2) * end ** (power - 3) / 720
    return ((t[..., None] + np.arange(TERMS)) ** power).sum(axis=-1) + rest


def missed(degree: int, k: float, t):
    """φ(t) for 0 < t < 1, counted from the inner end of the facet."""
    nodes, weights = LOBATTO[degree]
    return sum(w * zeta((1 + k) / 2, (t - node) % 1.0) for node, w in zip(nodes, weights))


def best_place(degree: int, k: float) -> float:
    """The place in its facet, from 0 at the inner end to 1, where an edge costs least; -1 < k < 1.

    Where traction ends nearly like a box, what is near the edge costs more than what is seen from afar.
    """
    if degree == 2 and k < STEEP_K:
        return float(np.interp(k, *MEASURED))
    return vanishing_place(degree, k)


@cache
def vanishing_place(degree: int, k: float) -> float:
    """The place in its facet where φ vanishes most gently: there the last nodal pressures do not zigzag."""
    t = np.linspace(OFF_NODE, 1 - OFF_NODE, 1000)
    values = missed(degree, k, t)
    change = np.flatnonzero(values[1:] * values[:-1] < 0)
    gentle = change[np.argmin(np.abs(values[change + 1] - values[change]))]
    return float(brentq(lambda place: float(missed(degree, k, place)), t[gentle], t[gentle + 1]))
