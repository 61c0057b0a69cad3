"""Linear system of a state for assumed edges of contact and stick."""

from dataclasses import dataclass

import numpy as np

from .exponents import hilbert_factors
from .stick import COARSE, StickBasis
from .tractions import SlipState
from .weight import Contact


@dataclass(frozen=True)
class Solution:
    """State for assumed edges, and the amplitudes at x_l, c_l, c_r, x_r of tractions without bound.

    At an edge of contact that of p, at an edge of stick that of |friction| p - |q|; all vanish at the right edges.
    They are scaled to approximate displacements of the edges over the widths of the zones of slip.
    """

    state: SlipState
    amplitudes: np.ndarray


def solve(problem, base, friction, edges, layout, Q) -> Solution:
    """Tractions with u_y + f = delta_y in contact, u_x as at the turn in stick, q = friction p in slip, for given P, Q.

    The unknown is r = friction p - q, which vanishes in slip. In contact
    p = alpha r + beta w H[r/w] + (pressure of the profile in full slip), w the weight of ``Contact``: with the Hilbert
    transform H this meets the first condition for every r (docs/coupling_kernel.md). The second is collocated.
    """
    k, d, f = problem.k, problem.d, friction
    x_l, c_l, c_r, x_r = edges
    contact = Contact(problem, f, x_l, x_r)
    stick = StickBasis(c_l, c_r, layout, problem.exponents(f)[2:], problem.order, k)
    x, n = stick.points, stick.size
    alpha, beta = hilbert_factors(k, problem.bk, d, f)
    chi = d * (1 + f**2 * problem.gk / problem.bk)
    of_even = -(problem.gk + chi * beta * problem.tau)
    of_odd = chi * alpha - f * d * problem.gk / problem.bk
    panels, from_left, from_right = contact.nodes((c_l, c_r))
    over = from_left * from_right
    w = at_w = from_left**contact.left * from_right**contact.right
    at_even, at_root = over ** (k / 2), np.sqrt(over)
    local = from_left - 1
    D, _, b = contact.profile()
    odd_s = panels.matrices(x, k)[1]

    def of_limit(nodes, weights, contracted):
        """Of r at nodes: u_x in stick without what is constant, ∫ p, ∫ r, ∫ r/w over half."""
        weight = contact.weight(nodes)
        t, left, right = contact.local(nodes)
        cauchy = weights / np.pi / (panels.nodes[:, None] - nodes)
        smooth = at_w[:, None] * contracted(cauchy, weight)
        smooth -= at_even[:, None] * contracted(cauchy, (left * right) ** (k / 2))
        root = np.sqrt(left * right)
        load = contracted((panels.weights * at_w @ cauchy)[None], weight)
        load -= contracted((panels.weights * at_root @ cauchy)[None], root) + contracted((weights * t)[None], root)
        whole = contracted(weights[None], 1.0)[0]
        over_w = contracted(weights[None], weight)[0]
        return chi * beta * (odd_s @ smooth), alpha * whole + beta * load[0], whole, over_w

    coarse = stick.rule(COARSE)
    smooth, of_p, of_r, over_w = of_limit(
        coarse.nodes, coarse.weights, lambda m, w: stick.contracted(m / w, COARSE)
    )
    even, odd = stick.matrices(k)
    A, right = np.zeros((n + 3, n + 3)), np.zeros(n + 3)
    A[:n, :n] = of_even * even + of_odd * odd + smooth
    A[:n, n] = chi * (odd_s @ (w / over))
    A[:n, n + 1] = chi * (odd_s @ (w / over * local))
    A[:n, n + 2] = -1
    A[n, :n], A[n, n : n + 2] = of_p, contact.unbounded
    A[n + 1, :n] = of_r
    A[n + 2, :n], A[n + 2, n + 1] = -beta / np.pi / contact.half * over_w, 1
    profile = w * D(local)
    right[:n] = base.moved(problem, x) - chi * (odd_s @ profile)
    right[:n] += f * problem.gk / problem.bk * problem.height(x)
    right[n : n + 3] = 1 - panels.weights @ profile, f - Q, b
    known = None
    if stick.panels and np.any((base.breaks > stick.inner[0]) & (base.breaks < stick.inner[-1])):
        known = base.limit_between(f, *stick.inner[[0, -1]])
    if known:
        source, r = known
        smooth, of_p, of_r, over_w = of_limit(source.nodes, source.weights, lambda m, w: m @ (r / w)[:, None])
        even, odd = source.matrices(x, k)
        right[:n] -= of_even * (even @ r) + of_odd * (odd @ r) + smooth[:, 0]
        right[n : n + 3] -= of_p[0], of_r[0], -beta / np.pi / contact.half * over_w[0]
    u = np.linalg.solve(A, right)
    at_left, at_right = u[n] - u[n + 1], u[n] + u[n + 1]
    at_stick = np.sign(f) * stick.amplitudes(u[:n])
    widths = np.array([c_l - x_l, c_l - x_l, x_r - c_r, x_r - c_r])
    scale = contact.half / D(0.0) / 2
    amplitudes = np.array([at_left * scale, *at_stick, at_right * scale]) / widths
    state = SlipState(problem, base, f, Q, contact, stick, u[:n], (alpha, beta), D, known is not None)
    return Solution(state, amplitudes)
