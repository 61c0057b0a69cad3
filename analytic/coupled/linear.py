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


def solve(base, friction, edges, Q) -> Solution:
    """Tractions with u_y + f = delta_y in contact, u_x as at the turn in stick, q = friction p in slip, for given P, Q.

    The unknown is r = friction p - q, which vanishes in slip. In contact
    p = alpha r + beta w H[r/w] + (pressure of the profile in full slip), w the weight of ``ContactInterval``: with the
    Hilbert transform H this meets the first condition for every r (docs/coupling_kernel.md). The second is collocated.
    What layers below the surface add to u_y is a sum of polynomials, which acts on p like a profile of this height.
    """
    problem, f = base.problem, friction
    k, d, terms = problem.k, problem.d, problem.terms
    x_l, c_l, c_r, x_r = edges
    contact = ContactInterval(problem, f, x_l, x_r)
    singular_points = [*edges, *base.contact, *base.breaks]
    stick = StickBasis(c_l, c_r, singular_points, edge_exponents(problem, f)[1:3], problem.order, k)
    rule = ContactRule(contact, (c_l, c_r))
    alpha, beta = hilbert_factors(problem, f)
    ratio = f * problem.gk / problem.bk
    chi = d * (1 + f * ratio)
    x, n = stick.points, stick.size
    # columns: r in stick, two singular parts of p, polynomials of the layers; and what is known
    size, singular, layers = n + 3 + terms, slice(n, n + 2), slice(n + 2, -1)
    D, b = contact.of_profile()
    D_layers, b_layers = contact.of_heights(terms)
    p = np.zeros((len(rule.x), size))  # without r, at the nodes of the rule
    p[:, singular] = rule.w_over[:, None] * np.stack([np.ones_like(rule.t), rule.t], axis=1)
    p[:, layers] = rule.w[:, None] * chebvander(rule.t, len(D_layers) - 1) @ D_layers
    p[:, -1] = rule.w * D(rule.t)
    smooth, rooted = p, p.copy()  # less alpha r, and beta v H[r/v] or beta root H[r/root]: both are smooth in stick
    u_x, at_edges, (of_p, of_r, over_w) = np.zeros((n, size)), np.zeros((2, size)), np.zeros((3, size))
    limits = _limits(base, f, stick)
    kernels = [stick.matrices(), *([act(m, 1.0) for m in panels.matrices(x, k)] for _, panels, act in limits[1:])]
    for (columns, panels, contracted), (even, odd) in zip(limits, kernels, strict=True):
        nodes, weights, weight = panels.nodes, panels.weights, contact.weight(panels.nodes)
        t, left, right = contact.local(nodes)
        root = np.sqrt(left * right)
        cauchy = weights / np.pi / (rule.x[:, None] - nodes)
        whole = rule.w[:, None] * contracted(cauchy, weight)
        smooth[:, columns] += beta * (whole - rule.v[:, None] * contracted(cauchy, (left * right) ** (k / 2)))
        rooted[:, columns] += beta * (whole - rule.root[:, None] * contracted(cauchy, root))
        at_edges[:, columns] = contracted(weights / np.pi / (np.array([[x_l], [x_r]]) - nodes), weight)
        of_p[columns] = -beta * contracted((weights * t)[None], root)[0]  # ∫ root H[r/root] = -∫ t r/root
        of_r[columns], over_w[columns] = contracted(weights[None], 1.0)[0], contracted(weights[None], weight)[0]
        u_x[:, columns] = (chi * alpha - d * ratio) * odd - (problem.gk + chi * beta * hilbert_ratio(k)) * even
    u_x += chi * (rule.odd(x) @ smooth)
    u_x[:, -1] -= base.moved(x) + ratio * problem.height(x)
    of_p += alpha * of_r + rule.weights @ rooted
    of_p[-1] -= 1
    of_r[-1] -= f - Q
    of_t = -beta / np.pi / contact.half * over_w  # the second singular part follows from r, layers and profile
    of_t[n + 1] += 1
    of_t[layers] -= b_layers
    of_t[-1] -= b
    u_y = np.zeros((0, size))
    if terms:
        places = np.concatenate([x, contact.middle + contact.half * chebpts1(terms)])
        heights = chebvander(contact.local(places)[0], terms - 1)
        u = displaced(contact, rule, places, rooted, limits, alpha, beta)
        if problem.kinks is not None:
            fine = [_of_basis(stick, PARTS), *limits[1:]]
            u += displaced_by_kinks(contact, rule, places, smooth, fine, alpha, beta, Q)
        u_x += u[0, :n]
        u_x[:, layers] -= ratio * heights[:n]
        u_y = -u[1, n:]
        u_y[:, layers] += heights[n:]
    rows = np.vstack([u_x, of_p, of_r, of_t, u_y])
    constant = np.repeat([-1.0, 0.0], [n, size - n])  # u_x where it sticks, the last unknown
    solved = np.linalg.solve(np.column_stack([rows[:, :-1], constant]), -rows[:, -1])
    D += Chebyshev(D_layers @ solved[layers])
    at_ends = at_edges @ np.append(solved[:-1], 1.0)
    tilt = solved[n + 1]
    ends = (solved[n] + np.array([-tilt, tilt])) / 2
    state = SlipState(base, Q, contact, stick, solved[:n], (alpha, beta), D, len(limits) > 1)
    return Solution(state, *_of_edges(state, ends, beta * at_ends))


def _limits(base, friction, stick):
    """Parts of r, that in the basis and that known from the turn, each with its columns of the linear system, panels,
    and a function that takes a matrix, which acts on values of r/w at their nodes, and w to these columns.
    """
    limits, (low, high) = [_of_basis(stick, COARSE)], stick.inner[[0, -1]]
    if stick.panels and np.any((base.breaks > low) & (base.breaks < high)):
        panels, r = base.limit_between(friction, low, high, stick.points)
        limits.append((slice(-1, None), panels, lambda m, w: m @ (r / w)[:, None]))
    return limits


def _of_basis(stick, parts):
    """The first of ``_limits``, the panels at its ends in so many ``parts``."""
    return slice(stick.size), stick.rule(parts), lambda m, w: stick.contracted(m / w, parts)


def _of_edges(state, ends, added):
    """Amplitudes and rates of a ``Solution``. Towards the edges
    p = w (ends[0]/(1 + t) + ends[1]/(1 - t) + state.full_slip(t) + added).
    """
    (x_l, x_r), (c_l, c_r), area = state.contact, state.stick, state.area
    at_stick, after_stick = np.sign(state.friction) * state.zone.amplitudes(state.coefficients)
    bounded = state.full_slip(np.array([-1.0, 1.0])) + ends[::-1] / 2 + added
    scale = area.half / state.full_slip(0.0)
    widths = np.array([c_l - x_l, c_l - x_l, x_r - c_r, x_r - c_r])
    amplitudes = scale * np.array([ends[0], at_stick[0] / 2, at_stick[1] / 2, ends[1]]) / widths
    exponents = [area.left, state.zone.exponents[0] + 1, state.zone.exponents[1] + 1, area.right]
    rates = scale * np.array([bounded[0], after_stick[0] / 2, after_stick[1] / 2, bounded[1]]) * exponents
    rates[[0, 3]] /= area.half
    return amplitudes, rates
