"""What layers below a power-law surface add to displacements, of the tractions of ``linear.solve``."""

from functools import lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebvander

FINER = 2  # polynomials for a kernel, for one for what layers add to u_y


def displaced(problem, friction, contact, rule, x, on_rule, limits, alpha, beta):
    """u_x and u_y at x that layers add, shape (len(x), columns) each, of q = friction p - r and
    p = on_rule + alpha r + beta root H[r/root].

    on_rule: values at the nodes of the rule, (len(rule.x), columns); limits: of r, slices of the columns that have it,
    and its nodes, weights and ``contracted``.
    """
    N, T, D = problem.of_layers(x, rule.x) * rule.weights @ on_rule
    u_x, u_y = friction * T + D, N - friction * D
    # ∫ K root H[r/root] = -∫ H[K root] r/root, and H[U_n root] = T_(n+1)
    cosines, second_kind = _second_kind(FINER * problem.terms)
    series = problem.of_layers(x, contact.middle + contact.half * cosines) @ second_kind
    for columns, (nodes, weights, contracted) in limits:
        t, left, right = contact.local(nodes)
        moved = series @ chebvander(t, len(cosines))[:, 1:].T
        parts = (problem.of_layers(x, nodes), 1.0), (moved, np.sqrt(left * right))
        r, rooted = (contracted(np.vstack(m * weights), w).reshape(3, len(x), -1) for m, w in parts)
        N, T, D = alpha * r - beta * rooted
        u_x[:, columns] += friction * T + D - r[1]
        u_y[:, columns] += N - friction * D + r[2]
    return u_x, u_y


@lru_cache(maxsize=8)
def _second_kind(n):
    """Points (n,) and the matrix that takes values there to the coefficients of U_0 to U_(n-1)."""
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    return np.cos(angle), 2 / (n + 1) * np.sin(angle)[:, None] * np.sin(np.outer(angle, np.arange(1, n + 1)))
