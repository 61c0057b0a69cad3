"""Frictional work of a load step, second order in the step: every point's own limit of friction over its own slip.

The traction of a point that slides is q = ±mu p(t), with t from 0 to 1 in the step. What p(t) and the slip s(t) are
like between two states is known to leading order, and weighs the pressures before and after in -∫ q ds.
"""

from dataclasses import dataclass

import numpy as np

from ..fem.surface import SurfaceState

AT_LIMIT = 1e-6  # a traction this close to mu p, over the largest mu p, slides
MOVES = 0.02  # of a point's distance from the edge: motions of the edge below do not count


@dataclass(frozen=True)
class Moment:
    """A state with the edges (left, right) of its contact."""

    surface: SurfaceState
    contact: tuple[float, float]

    @property
    def s(self) -> np.ndarray:
        """Relative displacement (n,)."""
        return self.surface.relative_displacement

    def sliding(self, mu: float) -> np.ndarray:
        """Sign of the traction where points slide (n,), 0 elsewhere."""
        limit = mu * self.surface.pressure
        slides = (limit > 0) & (np.abs(self.surface.traction) >= limit - AT_LIMIT * limit.max())
        return np.where(slides, np.sign(self.surface.traction), 0.0)


def frictional_work(before: Moment, after: Moment, mu: float, k: float, earlier: Moment | None = None) -> np.ndarray:
    """Energy that a load step dissipates per area of surface (n,), -∫ q ds. earlier: the state before ``before``; k:
    grading at the surface.

    A point that begins to slide within the step does so late, like (t - t0)^((3-k)/2), (50), and one that stops
    because the edge of stick came to it does so early. One that entered contact slides while its pressure grows like
    (t - t0)^((1+k)/2), (44), from when the edge came to it: steadily, as far as the point did that the edge left, for
    the part of the step that was left. One that leaves contact slides for a part of the step: averaged over the points
    that the edge passes. Points that stick do no work.
    """
    p0, p1 = before.surface.pressure, after.surface.pressure
    was, now = before.sliding(mu), after.sliding(mu)
    touches = (p0 > 0) & (p1 > 0)
    moved = after.s - before.s
    outwards = sliding_outwards(after, now)
    goes_on, begins = touches & (now != 0) & (was == now), touches & (now != 0) & (was != now)
    stops = touches & (now == 0) & (was != 0) & (was == outwards)
    enters, leaves = (p0 <= 0) & (p1 > 0) & (outwards != 0), (p1 <= 0) & (was != 0)
    mean = np.where(goes_on, mean_pressure(before, after, k), 0.0)
    if earlier is not None:
        steady = goes_on & (earlier.surface.pressure > 0)
        mean += np.where(steady, growth(before.s - earlier.s, moved) * (p1 - p0) / 12.0, 0.0)
    mean = np.where(begins, p1 - (p1 - p0) * 2.0 / (7.0 - k), mean)
    mean = np.where(stops, p0 + (p1 - p0) * 2.0 / (7.0 - k), mean)
    mean = np.where(enters, p1 * 2.0 / (3.0 + k), mean)
    mean = np.where(leaves, p0 * 2.0 / (5.0 + k), mean)
    moved = np.where(enters, slip_since_touch(before, after, moved), moved)
    q = mu * mean * np.where(leaves, was, np.where(enters | stops, outwards, now))
    return -q * moved


def sliding_outwards(moment: Moment, sliding) -> np.ndarray:
    """Sign (n,) of ``sliding`` between the edges of stick and contact on the side of each point; 0: they are one."""
    contact = np.flatnonzero(moment.surface.pressure > 0)
    sticks = contact[sliding[contact] == 0]
    first, last = (sticks[0], sticks[-1] + 1) if len(sticks) else (contact[len(contact) // 2],) * 2
    left, right = np.sign(sliding[:first].sum()), np.sign(sliding[last:].sum())
    return np.where(np.arange(len(sliding)) < (first + last) / 2, left, right)


def slip_since_touch(before: Moment, after: Moment, moved) -> np.ndarray:
    """Slip (n,) of points that enter contact: linear, from how far the point has moved that the edge left, to zero."""
    x = before.surface.x
    right = x > np.mean(before.contact)
    start, end = (np.where(right, m.contact[1], m.contact[0]) for m in (before, after))
    left_behind = np.where(right, *(np.interp(before.contact[side], x, moved) for side in (1, 0)))
    distance = np.where(start == end, 1.0, end - start)
    return left_behind * np.clip((end - x) / distance, 0.0, 1.0)


def growth(slip_before, slip) -> np.ndarray:
    """How much faster points (n,) slide at the end of a step than at its start, over the mean: (ds/dt)(t) is
    slip (1 + growth (t - 1/2)).

    Zero where a point slid the other way in the step before.
    """
    same = slip_before * slip > 0
    return np.where(same, 2.0 * (slip - slip_before) / np.where(same, slip + slip_before, 1.0), 0.0)


def mean_pressure(before: Moment, after: Moment, k: float) -> np.ndarray:
    """Mean over the step of the pressure (n,) at points that stay in contact, of which an edge comes near or leaves.

    p = f(t) d(t)^((1+k)/2) with the distance d from the edge and f linear in t; far from the edge p is linear.
    """
    x, power = before.surface.x, (1.0 + k) / 2.0
    p0, p1 = before.surface.pressure, after.surface.pressure
    right = x > np.mean(before.contact)
    d0, d1 = (np.where(right, m.contact[1] - x, x - m.contact[0]) for m in (before, after))
    near = (np.minimum(d0, d1) > 0) & (np.abs(d1 - d0) > MOVES * np.maximum(d0, d1))
    d0, d1 = np.where(near, d0, 1.0), np.where(near, d1, 2.0)
    change = d1 - d0
    f0, f1 = p0 / d0**power, p1 / d1**power
    first, second = ((d1**n - d0**n) / n for n in (power + 1.0, power + 2.0))
    share = (second - d0 * first) / change**2  # ∫ t d^power dt
    return np.where(near, f0 * first / change + (f1 - f0) * share, (p0 + p1) / 2.0)
