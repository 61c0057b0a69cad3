"""Linear system of a state for assumed edges of contact and stick."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebpts1, chebvander

from ..edge_exponents import edge_exponents, hilbert_factors, hilbert_ratio
from .layers import displaced, displaced_by_kinks
from .rule import ContactRule
from .stick import COARSE, PARTS, StickBasis
from .tractions import SlipState
from .weight import ContactInterval


@dataclass(frozen=True)
class Solution:
    """State for assumed edges x_l, c_l, c_r, x_r, and what Newton's method needs for the right ones, (4,) each.

    amplitudes: of tractions without bound, at an edge of contact of p, at an edge of stick of |friction| p - |q|; they
    vanish at the right edges, and are scaled to approximate displacements of the edges over the widths of slip.
    rates: their derivatives by the place of the same edge, outwards, times minus the width of slip. Those by the other
    edges vanish at the right edges: at fixed x the tractions are stationary there.
    """

    state: SlipState
    amplitudes: np.ndarray
    rates: np.ndarray


def solve(base, friction, edges, layout, Q) -> Solution:
    """Tractions with u_y + f = delta_y in contact, u_x as at the turn in stick, q = friction p in slip, for given P, Q.

    The unknown is r = friction p - q, which vanishes in slip. In contact
    p = alpha r + beta w H[r/w] + (pressure of the profile in full slip), w the weight of ``ContactInterval``: with the
    Hilbert transform H this meets the first condition for every r (docs/coupling_kernel.md). The second is collocated.
    What layers below the surface add to u_y is a sum of polynomials, which acts on p like a profile of this height.
    """
    problem, f = base.problem, friction
    k, d = problem.k, problem.d
    x_l, c_l, c_r, x_r = edges
    contact = ContactInterval(problem, f, x_l, x_r)
    stick = StickBasis(c_l, c_r, layout, edge_exponents(problem, f)[1:3], problem.order, k)
    x, n = stick.points, stick.size
    alpha, beta = hilbert_factors(problem, f)
    chi = d * (1 + f**2 * problem.gk / problem.bk)
    of_even = -(problem.gk + chi * beta * hilbert_ratio(k))
    of_odd = chi * alpha - f * d * problem.gk / problem.bk
    rule = ContactRule(contact, (c_l, c_r), k)
    D, b = contact.profile()
    D_layers, b_layers = contact.of_heights(problem.terms)
    odd_s = rule.odd(x, k)

    def of_limit(panels, contracted):
        """Of r on panels: w H[r/w] at the nodes of the rule, less v H[r/v], and for layers less root H[r/root]; ∫ p,
        ∫ r, ∫ r/w.
        """
        nodes, weights = panels.nodes, panels.weights
        weight = contact.weight(nodes)
        t, left, right = contact.local(nodes)
        cauchy = weights / np.pi / (rule.x[:, None] - nodes)
        whole = rule.w[:, None] * contracted(cauchy, weight)
        smooth = whole - rule.v[:, None] * contracted(cauchy, (left * right) ** (k / 2))
        root = np.sqrt(left * right)
        rooted = whole - rule.root[:, None] * contracted(cauchy, root) if problem.terms else None
        load = contracted((rule.weights * rule.w @ cauchy)[None], weight)
        load -= contracted((rule.weights * rule.root @ cauchy + weights * t)[None], root)
        of_r = contracted(weights[None], 1.0)[0]
        over_w = contracted(weights[None], weight)[0]
        return smooth, rooted, alpha * of_r + beta * load[0], of_r, over_w

    def at_edges(panels, contracted):
        """H[r/w] at both edges of contact."""
        matrix = panels.weights / np.pi / (np.array([[x_l], [x_r]]) - panels.nodes)
        return contracted(matrix, contact.weight(panels.nodes))

    limit = stick.rule(COARSE), lambda m, w: stick.contracted(m / w, COARSE)
    smooth, rooted, of_p, of_r, over_w = of_limit(*limit)
    even, odd = stick.matrices(k)
    # unknowns: r, two singular parts of p, polynomials of the layers, u_x where it is constant
    of_heights = rule.w[:, None] * chebvander(rule.t, len(D_layers) - 1) @ D_layers
    singular = np.stack([rule.w_over, rule.w_over * rule.t], axis=1)
    on_rule = np.hstack([beta * smooth, singular, of_heights])  # p less alpha r
    A, right = np.zeros((n + 3 + problem.terms,) * 2), np.zeros(n + 3 + problem.terms)
    A[:n, :-1] = chi * (odd_s @ on_rule)
    A[:n, :n] += of_even * even + of_odd * odd
    A[:n, -1] = -1
    A[n, :n], A[n, n : n + 2], A[n, n + 2 : -1] = of_p, contact.unbounded, rule.weights @ of_heights
    A[n + 1, :n] = of_r
    A[n + 2, :n], A[n + 2, n + 1], A[n + 2, n + 2 : -1] = -beta / np.pi / contact.half * over_w, 1, -b_layers
    right[:n] = base.moved(x) + f * problem.gk / problem.bk * problem.height(x)
    right[n : n + 3] = 1, f - Q, b
    limits = [(slice(n), *limit)]  # by columns
    known, of_known, profile = None, 0.0, rule.w * D(rule.t)
    p_known = p_rooted = profile
    if stick.panels and np.any((base.breaks > stick.inner[0]) & (base.breaks < stick.inner[-1])):
        known = base.limit_between(f, *stick.inner[[0, -1]], x)
    if known:
        source, r = known
        limit_known = source, lambda m, w: m @ (r / w)[:, None]
        limits.append((slice(-1, None), *limit_known))
        smooth_known, rooted_known, of_p, of_r, over_w = of_limit(*limit_known)
        of_known = at_edges(*limit_known)[:, 0]
        even, odd = source.matrices(x, k)
        right[:n] -= of_even * (even @ r) + of_odd * (odd @ r)
        right[n : n + 3] -= of_p[0], of_r[0], -beta / np.pi / contact.half * over_w[0]
        p_known = profile + beta * smooth_known[:, 0]
        if problem.terms:
            p_rooted = profile + beta * rooted_known[:, 0]
    right[:n] -= chi * (odd_s @ p_known)
    right[n] -= rule.weights @ profile
    if problem.terms:
        places = np.concatenate([x, contact.middle + contact.half * chebpts1(problem.terms)])
        heights = chebvander(contact.local(places)[0], problem.terms - 1)
        p_less_rooted = np.hstack([beta * rooted, singular, of_heights, p_rooted[:, None]])
        u = displaced(contact, rule, places, p_less_rooted, limits, alpha, beta)
        if problem.kinks is not None:
            fine = slice(n), stick.rule(PARTS), lambda m, w: stick.contracted(m / w, PARTS)
            p_less_H = np.hstack([on_rule, p_known[:, None]])
            u += displaced_by_kinks(contact, rule, places, p_less_H, [fine, *limits[1:]], alpha, beta, Q)
        u_x, u_y = u
        A[:n, :-1] += u_x[:n, :-1]
        A[:n, n + 2 : -1] -= f * problem.gk / problem.bk * heights[:n]
        A[n + 3 :, :-1] = -u_y[n:, :-1]
        A[n + 3 :, n + 2 : -1] += heights[n:]
        right[:n] -= u_x[:n, -1]
        right[n + 3 :] = u_y[n:, -1]
    u = np.linalg.solve(A, right)
    D = D + Chebyshev(D_layers @ u[n + 2 : -1])
    at_ends = at_edges(*limit) @ u[:n] + of_known
    at_stick, after_stick = np.sign(f) * stick.amplitudes(u[:n])
    # towards the edges p = w (ends[0]/(1 + t) + ends[1]/(1 - t) + D + beta H[r/w])
    ends = np.array([u[n] - u[n + 1], u[n] + u[n + 1]]) / 2
    bounded = D(np.array([-1.0, 1.0])) + ends[::-1] / 2 + beta * at_ends
    scale = contact.half / D(0.0)
    widths = np.array([c_l - x_l, c_l - x_l, x_r - c_r, x_r - c_r])
    amplitudes = scale * np.array([ends[0], at_stick[0] / 2, at_stick[1] / 2, ends[1]]) / widths
    exponents = [contact.left, stick.exponents[0] + 1, stick.exponents[1] + 1, contact.right]
    rates = scale * np.array([bounded[0], after_stick[0] / 2, after_stick[1] / 2, bounded[1]]) * exponents
    rates[[0, 3]] /= contact.half
    state = SlipState(base, f, Q, contact, stick, u[:n], (alpha, beta), D, known is not None)
    return Solution(state, amplitudes, rates)
