"""Linear system of a state for assumed edges of contact and stick."""

from dataclasses import dataclass

import numpy as np

from .tractions import TIP, ZONE, SlipState, Source, Zones

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
    rows_at = np.cumsum([0, *[len(zones.points[i]) for i in ZONE], 1, 1])
    at_left, at_p, at_right, at_q, at_P, at_Q = (slice(a, b) for a, b in zip(rows_at, rows_at[1:], strict=False))
    A, b = np.zeros((rows_at[-1], n[-1])), np.zeros(rows_at[-1])
    _, c_l, c_r, _ = edges
    tip = TIP * zones.half.min()
    held = Source(base, c_l, c_r, tip)
    for target, rows in ((0, at_left), (2, at_right)):
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
        A[at_p, columns] = problem.bk * even - mu_p * problem.d * odd
        A[at_q, columns] = mu_p * problem.gk * even + problem.d * odd
        A[at_P, columns] = zones.moments(source)
        A[at_Q, columns] = mu_p * zones.moments(source)
    (even_p, odd_p), (even_q, odd_q) = zones.own_matrices(1), zones.own_matrices(3)
    A[at_p, stick_p], A[at_p, stick_q] = problem.bk * even_p, -problem.d * odd_q
    A[at_q, stick_p], A[at_q, stick_q] = problem.d * odd_p, problem.gk * even_q
    A[at_p, load_p] = A[at_q, load_q] = -1
    A[at_P, stick_p], A[at_Q, stick_q] = zones.moments(1), zones.moments(3)
    b[at_p] = -base.delta_y
    b[at_Q] = Q - base.Q
    for low, high in ((base.contact[0], c_l), (c_r, base.contact[1])):  # tractions at the turn that slip replaces
        lost = Source(base, low, high, tip)
        u_x, u_y = lost.displacements(problem, x)
        b[at_p] += u_y
        b[at_q] += u_x
        b[at_P] += lost.loads[0]
        b[at_Q] += lost.loads[1]
    free, extra = _dependent(problem, friction, zones, n)
    u = np.zeros(n[-1])
    u[free] = np.linalg.solve(A[:, free] + A @ extra[:, free], b)
    u += extra @ u
    coefficients = u[left], u[stick_p], u[right], u[stick_q]
    delta_x, delta_y = base.delta_x + u[load_q][0], u[load_p][0]
    state = SlipState(base, friction, Q, zones, coefficients, delta_x, delta_y)
    return Solution(state, _amplitudes(zones, coefficients, friction))


def _dependent(problem, friction, zones, n):
    """Places of the unknowns, and the matrix that gives the extra powers of p at the edges of stick from those of q."""
    references, half = zones.references, zones.half
    free, extra = np.ones(n[-1], dtype=bool), np.zeros((n[-1], n[-1]))
    exponents = problem.exponents(friction)[2:]
    for side, (in_stick, in_slip) in enumerate(problem.beside_stick(friction)):
        slip = 2 * side
        q, end = references[3], (references[3].left, references[3].right)[side]
        columns = n[3] + (np.arange(q.split) if side == 0 else np.arange(q.split, q.size))
        amplitude = end.amplitude / (friction * in_stick - 1)  # of friction p - q, from that of q
        tip = half[1] * end.tip
        beyond = half[slip] * (references[slip].right if side == 0 else references[slip].left).tip
        for expansion, place, factor in (
            (1, references[1].extras[side], in_stick),
            (slip, references[slip].extras[1 - side], in_slip * (beyond / tip) ** (exponents[side] - 1)),
        ):
            row = n[expansion] + place
            free[row] = False
            extra[row, columns] = factor * amplitude
    return free, extra


def _amplitudes(zones, coefficients, friction):
    left, p, right, q = coefficients
    references, half = zones.references, zones.half
    ends = [references[0].left, references[3].left, references[3].right, references[2].right]
    gap = [friction * p[references[1].extras[i]] for i in (0, 1)]
    parts = [left[: ends[0].size], q[: ends[1].size], q[ends[1].size :], right[-ends[3].size :]]
    amplitudes = np.array([e.amplitude @ c for e, c in zip(ends, parts, strict=True)])
    amplitudes[1:3] = gap - amplitudes[1:3]
    tips = half[[0, 1, 1, 2]] * [end.tip for end in ends]
    exponents = np.array([end.exponents[-1] for end in ends])
    widths = 2 * half[[0, 0, 2, 2]]
    return amplitudes * tips**-exponents / widths
