"""What layers below a power-law surface add to displacements, of the tractions of ``linear.solve``."""

import numpy as np
from numpy.polynomial.chebyshev import chebvander

FINER = 2  # polynomials for a kernel, for one for what layers add to u_y


def displaced(problem, friction, contact, rule, x, on_rule, limits, alpha, beta):
    """u_x and u_y at x that layers add, shape (len(x), columns) each, of p = on_rule + alpha r + beta w H[r/w] and
    q = friction p - r.

    on_rule: values at the nodes of the rule, (len(rule.x), columns); limits: of r, slices of the columns that have it,
    and its nodes, weights and ``contracted``.
    """
    # ∫ K root H[r/root] = -∫ H[K root] r/root, and H[U_n root] = T_(n+1); what is left of w H[r/w] is smooth
    n = FINER * problem.terms
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    second_kind = 2 / (n + 1) * np.sin(angle)[:, None] * np.sin(np.outer(angle, np.arange(1, n + 1)))
    series = problem.of_layers(x, contact.middle + contact.half * np.cos(angle)) @ second_kind
    on_rule, of_r = on_rule.copy(), []
    for columns, (nodes, weights, contracted) in limits:
        t, left, right = contact.local(nodes)
        weight, root = contact.weight(nodes), np.sqrt(left * right)
        cauchy = weights / np.pi / (rule.x[:, None] - nodes)
        smooth = rule.w[:, None] * contracted(cauchy, weight) - rule.root[:, None] * contracted(cauchy, root)
        on_rule[:, columns] += beta * smooth
        parts = (problem.of_layers(x, nodes), 1.0), (series @ chebvander(t, n)[:, 1:].T, root)
        whole, rooted = (contracted(np.vstack(m * weights), w).reshape(3, len(x), -1) for m, w in parts)
        of_r.append((columns, whole, alpha * whole - beta * rooted))
    N, T, D = problem.of_layers(x, rule.x) * rule.weights @ on_rule
    u_x, u_y = friction * T + D, N - friction * D
    for columns, r, (N, T, D) in of_r:
        u_x[:, columns] += friction * T + D - r[1]
        u_y[:, columns] += N - friction * D + r[2]
    return u_x, u_y
