"""Anchors of points that slide and come to rest within a load step: they lie on the curve that the edge of stick draws.

Where it is after the step the edge tells where points stop, and so do points that stuck before. Points between these
stopped one after the other, and where each did is a smooth function of x.
"""

from typing import NamedTuple

import numpy as np

from forms.contact import CLOSED, OPEN

from ..fem.surface_points import SIDES
from .contact_points import BESIDE, Surface, leading

CUT = 4  # points that reach over the facet which an edge of contact cuts
OUT = 2  # points at the edge in that facet that stick beyond those that slide
DRAWN = 0.3  # least length of an edge's curve up to now, over that in this step, from which it goes on
FOLLOWS = 2.0  # times as far as the edge of contact that of stick goes which follows it; further it goes in a reversal
FASTEST = 10.0  # longest step along the last change of anchors, over that change


class Curve(NamedTuple):
    """Points (n,) that stop on one side, by index, their anchors (n,), and from where on the edge draws; nan: not."""

    points: np.ndarray
    anchors: np.ndarray
    start: float


class StickCurves:
    """Curves that both edges of stick draw in a load step, of points (n,) at x; start: of those drawn before it."""

    def __init__(self, x, before: Surface, start: dict[int, float]):
        self._x, self._before, self._start = x, before, start
        self.drawn: dict[int, Curve] = {}  # by side
        self._tried: dict[int, tuple] = {}  # points, where they were anchored, and where they should have been
        self._kept: np.ndarray | None = None

    @property
    def starts(self) -> dict[int, float]:
        """From where on edges draw, by side; nan where they do not."""
        return {side: self.drawn[side].start if self.drawn else np.nan for side in SIDES}

    def keep(self, states: np.ndarray):
        """From now on these contact states (n,) tell which points stop."""
        self._kept = states

    def draw(self, after: Surface, touch: np.ndarray) -> np.ndarray:
        """``touch`` (n,) with the curves in the state ``after``; what sticks because of a curve does not drop it."""
        seen = after if self._kept is None else Surface(self._kept, after.s, after.clearance)
        new = touch.copy()
        for side in SIDES:
            curve = anchors_of_stopped(self._x, self._before, seen, side, touch, self._start[side])
            if len(curve.points) or side not in self.drawn:
                self.drawn[side] = curve
            new[self.drawn[side].points] = self.drawn[side].anchors
        return new

    def accelerate(self, old: np.ndarray, new: np.ndarray) -> np.ndarray:
        """``new`` anchors (n,) in place of the ``old`` ones, ahead of the curves where the same points stop again."""
        for side, (points, anchors, _) in self.drawn.items():
            last = self._tried.get(side)
            self._tried[side] = points, old[points], anchors
            if last is not None and np.array_equal(last[0], points):
                new[points] = accelerated(old[points], anchors, *last[1:])
        return new


def accelerated(old, new, old_before, new_before) -> np.ndarray:
    """The next anchors (n,), by Anderson's method of depth one: from the last two, and where points should be instead.

    A point that stops pulls those beyond it, and with them the curve on which it is to lie: most of a change comes
    again in the next solve. Without acceleration where changes grow.
    """
    change, change_before = new - old, new_before - old_before
    shrunk = change - change_before
    if not np.any(shrunk) or change @ change >= change_before @ change_before:
        return new
    share = np.clip(change @ shrunk / (shrunk @ shrunk), -FASTEST, 0.5)
    return new - share * (new - new_before)


def anchors_of_stopped(x, before: Surface, after: Surface, side: int, touch, start: float) -> Curve:
    """The curve of points that stick now but slid before, or were open, as those beyond them slide now.

    They lie on one side of the contact, from the edge of stick inwards. Where it is now the edge tells where points
    stop, and so do those that stuck before: the anchors between lie on a smooth curve through both, where the edge has
    drawn one since ``start`` (nan: it has not), or begins to as it leaves the old edge of contact. Else points go on
    from where they were, or ``touch`` (n,), the further the closer they are to the edge.
    """
    contact = np.flatnonzero(after.states != OPEN)
    outwards = contact if side > 0 else contact[::-1]
    at_edge = leading(after.states[outwards][::-1] == CLOSED)
    if at_edge <= OUT < len(outwards):  # they stick in the facet that the edge of contact cuts, beyond those that slide
        outwards = outwards[: len(outwards) - at_edge]
    states, old = after.states[outwards], before.states[outwards]
    sliding = leading(states[::-1] == states[-1]) if states[-1] != CLOSED else 0
    edge = len(outwards) - sliding
    new = (old == OPEN) | (old == states[-1])  # some may slide still, for no other reason than their old anchors
    first = edge - leading(new[:edge][::-1])
    none = Curve(outwards[:0], np.zeros(0), np.nan)
    if not sliding or sliding == len(outwards) or first == edge or states[edge - 1] != CLOSED:
        return none
    stopped, outer = outwards[first:edge], outwards[edge]
    curve = np.where(side * x < side * x[outer], touch, after.s)  # where points stopped, which may have slid on since

    def joined(first) -> tuple[np.ndarray, np.ndarray]:
        # cubic through points on both sides of those from ``first`` to the edge
        inner, outside = outwards[max(first - 1 - BESIDE, 0)], outwards[edge + min(BESIDE, sliding // 2)]
        stopped = outwards[first:edge]
        return stopped, smooth(x, curve, [inner, outwards[first - 1], outer, outside], x[stopped])

    if np.all(before.states == OPEN):  # the contact started from a point, under an indenter that is a power there
        if before.clearance[outer] == 0.0:  # all of a flat touches at once
            return none
        tip = float(x[np.argmin(before.clearance)])
        share = before.clearance / before.clearance[outer]
        stopped = stopped[side * x[stopped] > side * tip]
        return Curve(stopped, after.s[outer] * share[stopped], tip)
    was = x[before.states != OPEN]
    moved = abs(x[outwards[-1]] - (was[-1] if side > 0 else was[0]))
    still = edge - leading(states[:edge][::-1] == CLOSED)
    slides_back = leading(states[first:still][::-1] == 2 * CLOSED - states[-1]) > CUT
    if slides_back and abs(x[outwards[still]] - x[outer]) < moved:  # what slid soon slides the other way
        band, positions = joined(still)
        share = 1.0 - np.abs(x[outwards[first:still]] - x[band[0]]) / moved  # > 0 where the band passed
        back, share = outwards[first:still][share > 0], share[share > 0]
        positions = np.append(touch[back] + share * (positions[0] - touch[band[0]]), positions)
        return Curve(np.append(back, band), positions, start)
    passed = np.count_nonzero(old[first:edge] == OPEN)  # by the edge of contact
    reverses = edge - first > passed and abs(x[stopped[-1]] - x[stopped[0]]) > FOLLOWS * moved
    if reverses and passed == 0:  # what slid stops where it is
        return none
    begins = reverses or np.isnan(start) and passed >= edge - first - CUT
    if begins:
        first = max(edge - passed - CUT, 0)
    if first == 0:
        return none
    inner = outwards[first - 1]
    if begins:
        return Curve(*joined(first), float(x[inner]))
    length, drawn = abs(x[outer] - x[inner]), side * (x[inner] - start)
    if not drawn >= DRAWN * length:
        share = (x[stopped] - x[inner]) / (x[outer] - x[inner])
        began = start if np.isfinite(start) else float(x[inner])
        return Curve(stopped, touch[stopped] + (after.s[outer] - touch[outer]) * share, began)
    behind = outwards[np.argmin(np.abs(x[outwards] - (x[inner] - side * min(length, drawn))))]
    beside = outwards[max(first - 3, 0)]  # at the node before, as two points lie at some: the curve has no kink
    return Curve(stopped, smooth(x, curve, [behind, beside, inner, outer], x[stopped]), start)


def smooth(x, values, support: list | np.ndarray, at) -> np.ndarray:
    """At points ``at`` the polynomial through those ``values`` of points (n,) at x that ``support`` lists."""
    support = np.sort(support)
    support = support[np.diff(x[support], prepend=-np.inf) > 0]
    return np.polynomial.Polynomial.fit(x[support], values[support], len(support) - 1)(at)
