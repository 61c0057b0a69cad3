"""What layers below a power-law surface add to displacements, of the tractions of ``linear.solve``."""

from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebint, chebvander

OF_KERNELS = 12  # polynomials for a kernel, over the order of the basis


def displaced(contact, rule, x, on_rule, limits, alpha, beta):
    """u_x and u_y at x that the regular kernels of layers add, shape (2, len(x), columns), of q = friction p - r and
    p = on_rule + alpha r + beta root H[r/root].

    on_rule: values at the nodes of the rule, (len(rule.x), columns); limits: see ``linear._limits``.
    """
    problem, friction = contact.problem, contact.friction
    N, T, D = problem.of_layers(x, rule.x) * rule.weights @ on_rule
    u_x, u_y = friction * T + D, N - friction * D
    # ∫ K root H[r/root] = -∫ H[K root] r/root, and H[U_n root] = T_(n+1)
    cosines, second_kind = _second_kind(OF_KERNELS * problem.order)
    series = problem.of_layers(x, contact.middle + contact.half * cosines) @ second_kind
    for columns, panels, contracted in limits:
        t, left, right = contact.local(panels.nodes)
        moved = series @ chebvander(t, len(cosines))[:, 1:].T
        parts = (problem.of_layers(x, panels.nodes), 1.0), (moved, np.sqrt(left * right))
        r, rooted = (contracted(np.vstack(m * panels.weights), w).reshape(3, len(x), -1) for m, w in parts)
        N, T, D = alpha * r - beta * rooted
        u_x[:, columns] += friction * T + D - r[1]
        u_y[:, columns] += N - friction * D + r[2]
    return np.stack([u_x, u_y])


def displaced_by_kinks(contact, rule, x, on_rule, limits, alpha, beta, Q):
    """The same of the kinks for p = on_rule + alpha r + beta H[r], up to constants; k = 0.

    The columns end with those of the heights T_j that carry what layers add to u_y, and with the known ones; x ends
    with as many Chebyshev points. As |z| and z - z ln|z| are antiderivatives of O and R, all follows from O*p, R*r and
    O*r, and from R*p: in contact b R*p = constant - height + d O*q, and P = 1 tells its mean over Chebyshev points.
    """
    problem, friction, half, terms = contact.problem, contact.friction, contact.half, contact.problem.terms
    s, centred = contact.local(x)[0], (x - contact.middle)[:, None]
    signs, points = rule.sign(x), np.append(x, [contact.x_l, contact.x_r])
    # O*p, and the integrals of O*p, O*r and R*r over x
    odd_p, integral_p = signs @ on_rule, signs * (x[:, None] - rule.x) @ on_rule
    odd_r, integral_r, integral_even_r = np.zeros((3, *odd_p.shape))
    for columns, panels, contracted in limits:
        (even, odd), z = panels.matrices(points, 0.0), points[:, None] - panels.nodes
        even_at_edges = contracted(even[-2:], 1.0).mean(axis=0)
        even, z_even, odd, z_odd = (contracted(m[:-2], 1.0) for m in (even, z * even, odd, z * odd))
        whole = centred * contracted(panels.weights[None], 1.0)
        odd_r[:, columns], integral_r[:, columns], integral_even_r[:, columns] = odd, z_odd, z_even + whole
        # O*H[r] over the contact is 2/pi (mean of R*r at both edges - R*r)
        beta_pi = 2 / np.pi * beta
        odd_p[:, columns] += alpha * odd + beta_pi * (even_at_edges - even)
        integral_p[:, columns] += alpha * z_odd + beta_pi * (centred * even_at_edges - z_even - whole)
    odd_q, integral_q = friction * odd_p - odd_r, friction * integral_p - integral_r
    height = Chebyshev.interpolate(lambda s: problem.height(contact.middle + half * s), problem.degree)
    constant = -problem.d * odd_q[-terms:].mean(axis=0)
    constant[-1] += problem.bk * np.log(2 / half) + height(s[-terms:]).mean()
    constant[-1 - terms] += 1.0
    integral_even_p = problem.d * integral_q + centred * constant
    integral_even_p[:, -1] -= half * height.integ()(s)
    integral_even_p[:, -1 - terms : -1] -= half * (chebvander(s, terms) @ chebint(np.eye(terms)))
    integral_even_p /= problem.bk
    n, t, d = problem.kinks
    u_x = t * integral_q - d * integral_even_p
    u_y = n * integral_p + d * (friction * integral_even_p - integral_even_r)
    u_x[:, -1] += d * centred[:, 0]
    u_y[:, -1] -= d * Q * centred[:, 0]
    return np.stack([u_x, u_y])


@lru_cache(maxsize=8)
def _second_kind(n):
    """Points (n,) and the matrix that takes values there to the coefficients of U_0 to U_(n-1)."""
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    return np.cos(angle), 2 / (n + 1) * np.sin(angle)[:, None] * np.sin(np.outer(angle, np.arange(1, n + 1)))
