"""Frictional work of each point: where it is done in a load step.

Every point has its own limit of friction over its own slip: the traction of a point that slides is q = ±mu p(t), with t
from 0 to 1 in the step. What p(t) and the slip s(t) are like between two states is known to leading order, and weighs
the pressures before and after in -∫ q ds. The sum over all points is known better (``analytic.straight_way``).
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from ..fem.surface import SurfaceState

MOVES = 0.02  # of a point's distance from the edge: motions of the edge below do not count
NEAREST = 0.25  # of the spacing of nodes: what an edge between nodes is known to


Edges = tuple[tuple[float, float], tuple[float, float]]  # left and right one of the contact, before and after a step


def frictional_work(
    before: SurfaceState, after: SurfaceState, edges: Edges, k: float, earlier: SurfaceState | None = None
) -> np.ndarray:
    """Energy that a load step dissipates per area of surface (n,), -∫ q ds. earlier: the state before ``before``; k:
    grading at the surface.

    A point that begins to slide within the step does so late, like (t - t0)^((3-k)/2), (50); one that enters or leaves
    contact slides while its pressure is C (distance from the edge)^((1+k)/2), (44), for a part of the step. Both are
    averaged over the points that the edges pass. Points that stick do no work.
    """
    p0, p1 = before.pressure, after.pressure
    was, now = before.slides, after.slides
    touches = (p0 > 0) & (p1 > 0)
    s0, s1 = before.relative_displacement, after.relative_displacement
    moved = s1 - s0
    goes_on, begins = touches & (now != 0) & (was == now), touches & (now != 0) & (was != now)
    enters, leaves = (p0 <= 0) & (now != 0), (p1 <= 0) & (was != 0)
    mean = np.where(goes_on, mean_pressure(before, after, edges, k), 0.0)
    if earlier is not None:
        mean += np.where(goes_on, growth(s0 - earlier.relative_displacement, moved) * (p1 - p0) / 12.0, 0.0)
    mean = np.where(begins, p1 - (p1 - p0) * 2.0 / (7.0 - k), mean)
    mean = np.where(enters | leaves, (p0 + p1) * 2.0 / (5.0 + k), mean)
    q = after.mu * mean * np.where(leaves, was, now)
    return np.maximum(-q * moved, 0.0)  # a point that has left contact may go on the other way


def loss(before: SurfaceState, after: SurfaceState, coupled: bool) -> float:
    """What tractions, and with coupling pressures, lose in a load step by means of the forces."""
    lost = (before.traction + after.traction) * (before.relative_displacement - after.relative_displacement)
    if coupled:
        lost += (before.pressure + after.pressure) * (before.approach - after.approach)
    return before.line_load(lost) / 2


def work_of_pressing(after: SurfaceState, k: float, m: float) -> np.ndarray:
    """Energy per area of surface (n,) since first contact of a profile |x|^m that is pressed on with friction.

    Such a contact grows similar to itself: p = a^(m+k-1) p_1(x/a) and u_x = a^m u_1(x/a), so that its last state
    tells of all earlier ones,

        ∫ mu p |du_x| = |x|^(2m+k-1) ∫_|x|^a g(ξ) ξ^-(2m+k) dξ,    g = mu p |m u_x - x u_x'|,

    which is zero where points stick, u_x ~ x|x|^(m-1). Load steps are no part of it.
    """
    x, s, power = after.x, after.relative_displacement, 2.0 * m + k
    rate = m * s - x * np.gradient(s, x)
    g = np.where(after.slides != 0, after.limit * np.abs(rate), 0.0)
    work = np.zeros(len(x))
    for side in (-1, 1):
        outwards = np.flatnonzero(side * x > 0)[::side]
        distance = np.abs(x[outwards])
        pieces = g[outwards] / distance**power
        inwards = cumulative_trapezoid(pieces[::-1], -distance[::-1], initial=0.0)[::-1]
        work[outwards] = distance ** (power - 1.0) * inwards
    return work


def growth(slip_before, slip) -> np.ndarray:
    """How much faster points (n,) slide at the end of a step than at its start, over the mean: (ds/dt)(t) is
    slip (1 + growth (t - 1/2)).

    Zero where a point slid the other way in the step before.
    """
    same = slip_before * slip > 0
    return np.where(same, 2.0 * (slip - slip_before) / np.where(same, slip + slip_before, 1.0), 0.0)


def mean_pressure(before: SurfaceState, after: SurfaceState, edges: Edges, k: float) -> np.ndarray:
    """Mean over the step of the pressure (n,) at points that stay in contact, of which an edge comes near or leaves.

    p = f(t) d(t)^((1+k)/2) with the distance d from the edge and f linear in t; far from the edge p is linear. No d is
    taken as less than the edges are known to: f of a node that an edge touches would hang on the edge's last digits.
    """
    x, power = before.x, (1.0 + k) / 2.0
    p0, p1 = before.pressure, after.pressure
    right = x > np.mean(edges[0])
    distances = (np.where(right, high - x, x - low) for low, high in edges)
    d0, d1 = (np.maximum(d, NEAREST * np.gradient(x)) for d in distances)
    near = np.abs(d1 - d0) > MOVES * np.maximum(d0, d1)
    d0, d1 = np.where(near, d0, 1.0), np.where(near, d1, 2.0)
    change = d1 - d0
    f0, f1 = p0 / d0**power, p1 / d1**power
    first, second = ((d1**n - d0**n) / n for n in (power + 1.0, power + 2.0))
    share = (second - d0 * first) / change**2  # ∫ t d^power dt
    return np.where(near, f0 * first / change + (f1 - f0) * share, (p0 + p1) / 2.0)
