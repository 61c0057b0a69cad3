"""Nodes gathered at the edges of contact and stick, where tractions end like a root of the distance."""

import numpy as np

BISECTIONS = 60


def graded_nodes(left, right, edges, density, count, smallest, order):
    """``count`` nodes from ``left`` to ``right``, gathered at ``edges`` down to about ``smallest`` [length],
    a number, or one for each edge.

    The spacing grows like distance^(1-1/order). Linear interpolation of distance^p has its best rate, the
    square of the spacing in the mean, for order > 2/(p + 1/2).

    Each edge e contributes its ``density`` times (|x - e| + smallest)^(1/order - 1), whose sum is integrated in
    closed form and inverted by bisection.
    """
    edges = np.asarray(edges, dtype=float)

    def nodes_below(x):
        distance = x[:, None] - edges
        reach = (np.abs(distance) + smallest) ** (1 / order) - smallest ** (1 / order)
        return (np.sign(distance) * reach) @ density

    first, last = nodes_below(np.array([left, right]))
    target = np.linspace(first, last, count)[1:-1]
    low, high = np.full(count - 2, left), np.full(count - 2, right)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        below = nodes_below(middle) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.concatenate([[left], (low + high) / 2, [right]])
