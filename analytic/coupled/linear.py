"""Linear system of a state for assumed edges of contact and stick."""

from dataclasses import dataclass

import numpy as np

from .tractions import TIP, SlipState, Source, Zones

SLIP = (0, 2)  # zones


@dataclass(frozen=True)
class Solution:
    """State for assumed edges, and the amplitudes at x_l, c_l, c_r, x_r of tractions without bound.

    At an edge of contact that of p, at an edge of stick that of friction p - q; all vanish at the right edges.
    They are scaled to approximate displacements of the edges over the widths of the zones of slip.
    """

    state: SlipState
    amplitudes: np.ndarray


def solve(problem, base, friction, edges, zone_references, Q) -> Solution:
    """Tractions with u_y + f = delta_y in contact, u_x as at the turn in stick, q = friction p in slip, for given P, Q.

    In stick the unknowns are differences to the state ``base`` at the turn of the load, and so are the displacements.
    """
    zones = Zones(edges, zone_references)
    mu_p = friction
    n = np.cumsum([0, *[z.size for z in zone_references], 1, 1])
    left, stick_p, right, stick_q, load_p, load_q = (slice(a, b) for a, b in zip(n, n[1:], strict=False))
    of_slip = {0: left, 2: right}
    A, b = np.zeros((n[-1], n[-1])), np.zeros(n[-1])
    _, c_l, c_r, _ = edges
    tip = TIP * zones.half.min()
    held = Source(base, c_l, c_r, tip)
    for target, rows in of_slip.items():
        x = zones.points[target]
        for source, columns in of_slip.items():
            even, odd = zones.own_matrices(source) if source == target else zones.matrices(source, x)[0]
            A[rows, columns] = problem.bk * even - mu_p * problem.d * odd
        (even, _), (_, odd) = zones.matrices(1, x)
        A[rows, stick_p], A[rows, stick_q] = problem.bk * even, -problem.d * odd
        A[rows, load_p] = -1
        b[rows] = -problem.height(x) - held.displacements(problem, x)[1]
    x = zones.points[1]
    for source, columns in of_slip.items():
        even, odd = zones.matrices(source, x)[0]
        A[stick_p, columns] = problem.bk * even - mu_p * problem.d * odd
        A[stick_q, columns] = mu_p * problem.gk * even + problem.d * odd
        A[load_p, columns] = zones.moments(source)
        A[load_q, columns] = mu_p * zones.moments(source)
    (even_p, odd_p), (even_q, odd_q) = zones.own_matrices(1), zones.own_matrices(3)
    A[stick_p, stick_p], A[stick_p, stick_q] = problem.bk * even_p, -problem.d * odd_q
    A[stick_q, stick_p], A[stick_q, stick_q] = problem.d * odd_p, problem.gk * even_q
    A[stick_p, load_p] = A[stick_q, load_q] = -1
    A[load_p, stick_p], A[load_q, stick_q] = zones.moments(1), zones.moments(3)
    b[stick_p] = -base.delta_y
    b[load_q] = Q - base.Q
    for low, high in ((base.contact[0], c_l), (c_r, base.contact[1])):  # tractions at the turn that slip replaces
        lost = Source(base, low, high, tip)
        u_x, u_y = lost.displacements(problem, x)
        b[stick_p] += u_y
        b[stick_q] += u_x
        b[load_p] += lost.loads[0]
        b[load_q] += lost.loads[1]
    u = np.linalg.solve(A, b)
    coefficients = u[left], u[stick_p], u[right], u[stick_q]
    delta_x, delta_y = base.delta_x + u[load_q][0], u[load_p][0]
    state = SlipState(base, friction, Q, zones, coefficients, delta_x, delta_y)
    return Solution(state, _amplitudes(zones, coefficients, friction))


def _amplitudes(zones, coefficients, friction):
    left, p, right, q = coefficients
    references, half = zones.references, zones.half
    gap = friction * p - q if references[1].left.exponents == references[3].left.exponents else -q
    ends = [references[0].left, references[3].left, references[3].right, references[2].right]
    parts = [left[: ends[0].size], gap[: ends[1].size], gap[ends[1].size :], right[-ends[3].size :]]
    tips = half[[0, 1, 1, 2]] * [end.tip for end in ends]
    exponents = np.array([end.exponents[-1] for end in ends])
    widths = 2 * half[[0, 0, 2, 2]]
    return np.array([e.amplitude @ c for e, c in zip(ends, parts, strict=True)]) * tips**-exponents / widths
