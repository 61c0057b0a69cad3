"""Anchors of points that enter contact within a load step: their relative displacement when the edge reached them.

Between two load steps the edge of contact passes points one after the other. Anchored where the step began they would
all be too early, those passed last the most. How far a point has moved when it touches is known from how far it was
from touching: as a point comes closer it moves sideways in proportion,

    s(at touch) = s_before + r clearance_before,      r = (s_after - s_before)/(clearance_before - clearance_after),

where r is measured on points that are open still. In uncoupled contact with a power law, r is alpha dQ/dP as long as
the surface beside the edge sticks, the same everywhere: then this is exact, however large the step is. With coupling
displacements oscillate ahead of an edge that sticks, and r depends on the distance from it as ``StuckEdge`` tells: one
r for all would leave an error of first order in the step. Points that slide when they enter and then stop, as the edge
of stick follows that of contact, are anchored on the curve that this edge draws. Where the contact is known to grow
similar to itself, they are anchored where that lets them stick.

The state after a step depends on the anchors: solve, measure, anchor, solve again. Where that does not settle, the
state whose anchors would change least is taken.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from analytic.stuck_edge import StuckEdge
from forms.contact import CLOSED, OPEN

from ..fem.contact_problem import ContactProblem
from ..fem.surface_points import AllPoints
from .contact_points import BESIDE, Surface, edge_of_contact, open_points
from .stopped_points import anchors_of_stopped, without_kink

# r is measured between two distances from the edge, in units of its motion in the step. The further out, the better a
# wrong r is seen; the closer, the more it is the edge's own. Without coupling r is the same everywhere.
COUPLED, UNCOUPLED = (0.1, 0.6), (0.5, 2.0)
STEPS = 0.3, 3.0  # shortest and longest step of the secant method, over the defect
FASTEST = 10.0  # longest step along the last change of anchors, over that change
PATIENT = 5  # solves after which edges of stick draw, though the ratios have not settled
KEEPS = 6  # solves after which the points that stop are those of the best state up to there
SIDES = (-1, 1)  # left, right


class EnteringPoints:
    """Anchors the points that enter contact in a load step of a frictional problem; edge: of a coupled one."""

    def __init__(self, problem: ContactProblem, edge: StuckEdge | None = None):
        self._problem, self._points = problem, AllPoints(problem.points)
        self._x = self._points.x
        self._is_uncoupled = problem.held is not None
        self._edge = None if self._is_uncoupled else edge
        self._window = UNCOUPLED if self._is_uncoupled else COUPLED
        self._beside = BESIDE if self._is_uncoupled else 0  # points that r is not measured on, and which ``end`` leads
        self._ratios = {side: Ratio() for side in SIDES}
        self._before: Surface = None  # type: ignore[assignment]  # made by ``begin``
        self._after: Surface = None  # type: ignore[assignment]  # as last measured
        self._draws = False  # anchors points that stop where the edge of stick drew them
        self._solves = 0  # of this step
        self._curves: dict[int, tuple] = {}  # of points that stop, drawn in this step; by side
        self._tried: dict[int, tuple] = {}  # points that stop, where they were anchored, and where they should be
        self.unsettled = 0.0  # change of anchors that the state last measured asks for; see ``renew``
        self.is_best = False  # whether no state of this step asks for less
        self._best: tuple = ()  # of that which asks for least: what it asks for, ``_after`` and ``_began``
        self._kept: np.ndarray | None = None  # states that tell which points stop, once they are to stay
        self._stuck: np.ndarray = None  # type: ignore[assignment]  # where points stick, as far as it is known
        # from where on the edges of stick drew their curves: before a step, and after it; nan where they did not
        self._start = self._began = dict.fromkeys(SIDES, np.nan)

    def begin(self, clearance: np.ndarray, is_first_contact: bool, stuck: Callable | None = None):
        """Keep the state before a step, and anchor open points as if they went on as in the step before.

        clearance: of this rank's points (m,) before the step; stuck: where points at x stick after it, nan where they
        do not, if this is known.
        """
        memory = self._problem.memory
        states = memory.states_at_rest()
        states = np.where(states == OPEN, CLOSED, states)  # all in contact stick after a frictionless stage
        states = np.where((clearance > 0) | is_first_contact, OPEN, states)
        self._before = Surface(*map(self._points.gathered, (states, memory.anchors(), clearance)))
        self._ratios = {side: Ratio(ratio.value) for side, ratio in self._ratios.items()}
        self._draws, self._solves, self._curves = False, 0, {}
        self._tried, self._best, self._kept, self.unsettled = {}, (), None, 0.0
        self._began = dict.fromkeys(SIDES, np.nan)
        self._after = None  # type: ignore[assignment]
        self._stuck = np.full(len(self._x), np.nan) if stuck is None else stuck(self._x)
        if not is_first_contact or stuck:
            self._put(self._touching(self._before))

    def renew(self, clearance: np.ndarray, settled: float) -> bool:
        """Measure r in the state after the step and anchor what has entered; False where it is anchored so already.

        clearance: of this rank's points (m,) now; settled: change of anchors that does not count, over how far the
        points in contact have moved.
        """
        problem, before = self._problem, self._before
        local = problem.terms.contact_states(), problem.memory.rest_positions(), clearance
        self._after = after = Surface(*map(self._points.gathered, local))
        old = self._points.gathered(problem.memory.anchors())
        measure(self._x, before, after, self._ratios, self._window, self._beside, self._edge)
        touch = self._touching(after)
        new = touch.copy()
        change = self._change(new, old)
        known = self._is_uncoupled or np.any(np.isfinite(self._stuck))
        self._solves += 1
        if (change <= settled or self._solves >= PATIENT) and not known:  # what slides with these ratios does slide
            self._draws = True
        if self._draws:
            if self._solves == KEEPS + 1:
                self._kept = self._best[1].states
            seen = after if self._kept is None else Surface(self._kept, after.s, after.clearance)
            for side in SIDES:
                start = self._start[side]
                curve = anchors_of_stopped(self._x, before, seen, side, touch, start)
                if len(curve[0]) or side not in self._curves:  # what sticks because of a curve is no reason to drop it
                    self._curves[side] = curve
                stopped, positions, self._began[side] = self._curves[side]
                new[stopped] = positions
            change = self._change(new, old)
        if change <= settled:
            slide_on = np.isfinite(self._stuck) & (after.states != OPEN) & (after.states != CLOSED)
            if not np.any(slide_on):
                self.unsettled = 0.0
                return False
            self._stuck[slide_on] = np.nan  # the mesh has its edge of stick a little further inside
            new = self._touching(after)
        self.unsettled, asks = change, (not (self._draws or known), change)
        self.is_best = not self._best or asks <= self._best[0]
        if self.is_best:
            self._best = asks, after, dict(self._began)
        for side, (stopped, positions, _) in self._curves.items():
            last = self._tried.get(side)
            self._tried[side] = stopped, old[stopped], positions
            if last is not None and np.array_equal(last[0], stopped):
                new[stopped] = accelerated(old[stopped], positions, *last[1:])
        self._put(new)
        return True

    def go_back(self):
        """The state is again that which asked for least."""
        (_, self.unsettled), self._after, self._began = self._best

    def _touching(self, after):
        """Anchors of all points where they stick, as far as that is known, and otherwise where they would touch."""
        touch = anchors_of_entering(self._x, self._before, after, self._ratios, self._edge)
        for side in () if self._is_uncoupled else SIDES:
            touch = without_kink(self._x, self._before, after, side, touch)
        return np.where(np.isnan(self._stuck), touch, self._stuck)

    def _change(self, new, old) -> float:
        """Largest change of anchors over the largest motion, but of points that slide with the new ones as well."""
        direction = self._after.states - CLOSED  # in which the traction of a point is at its limit
        slides_still = (direction != 0) & (direction * (new - self._after.s) >= 0)
        counts = (self._after.states != OPEN) & ~slides_still
        moved = np.abs(new - self._before.s)[counts].max(initial=0.0)
        return float(np.abs(new - old)[counts].max() / moved) if moved else 0.0

    def ratios(self) -> np.ndarray:
        """What the next step needs (4,): r at both edges of contact, and from where on both edges of stick draw."""
        return np.array([*(self._ratios[side].value for side in SIDES), *(self._start[side] for side in SIDES)])

    def take_up(self, ratios: np.ndarray):
        """Go on from an earlier run's ``ratios``."""
        self._ratios = {side: Ratio(float(r)) for side, r in zip(SIDES, ratios)}
        self._start = {side: float(x) for side, x in zip(SIDES, [*ratios[2:], np.nan, np.nan])}

    def end(self):
        """After the points have come to rest: let open ones beside an edge go on as those inside were anchored.

        Their own displacement has the error of the facet that the edge cuts, and that is no part of a path. Were they
        left there, the next step would anchor them aside of their neighbours, and k < 0 would feel it as a zigzag.
        """
        before, after, self._start = self._before, self._after, self._began
        if after is None or not self._beside:
            return
        anchors = self._points.gathered(self._problem.memory.anchors())
        for side in SIDES:
            beyond = open_points(after.states, side)
            inside = beyond[:1] - side  # sorted by x: the last in contact
            beyond = beyond[before.states[beyond] == OPEN]
            closed = before.clearance[beyond] - after.clearance[beyond]
            led, guides = np.split(np.arange(len(beyond))[: 2 * self._beside], [self._beside])
            if len(guides) and np.all(closed[: 2 * self._beside] > 0):
                if before.states[inside] == OPEN and after.states[inside] == CLOSED:
                    r = (anchors[inside] - before.s[inside]) / before.clearance[inside]
                else:  # none has entered, or those that have slide: as the open ones further out
                    r = np.mean((anchors[beyond[guides]] - before.s[beyond[guides]]) / closed[guides])
                anchors[beyond[led]] = before.s[beyond[led]] + r * closed[led]
        self._put(anchors)

    def _put(self, anchors):
        self._problem.memory.move_anchors(self._points.mine(anchors))


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


class Ratio:
    """r of a point that an edge has just reached: it equals what is measured with it, by the secant method."""

    def __init__(self, value: float = 0.0):
        self.value = value
        self._last: tuple[float, float] | None = None  # a value tried, and how far what was measured was from it

    def improve(self, measured: float):
        """Take in what was measured with the present value."""
        value, defect, step = self.value, measured - self.value, 1.0
        if self._last is not None and defect != self._last[1]:
            before, defect_before = self._last
            step = np.clip((value - before) / (defect_before - defect), *STEPS)
        self.value = value + step * defect
        self._last = value, defect


@dataclass(frozen=True)
class Advance:
    """Of one edge of contact in a load step: where it was, how far it has come, the width of the contact before."""

    start: float
    length: float
    width: float

    @classmethod
    def of(cls, x, before: Surface, after: Surface, side: int) -> "Advance":
        """Of points (n,) at x; an edge lies half way from the last node in contact to the next."""
        tip = float(x[np.argmin(before.clearance)])  # from where the first contact grows
        old = before.states if np.any(before.states != OPEN) else None
        start, far = (tip if old is None else edge_of_contact(x, old, which) for which in (side, -side))
        end = edge_of_contact(x, after.states, side)
        return cls(start, side * (end - start), side * (start - far))


def measure(
    x, before: Surface, after: Surface, ratios: dict[int, Ratio], window, beside: int, edge: StuckEdge | None = None
):
    """Improve r of both edges by points (n,) at x that are open before and after; edge: of coupled contact."""
    for side in SIDES:
        beyond = open_points(after.states, side)
        entered = open_points(before.states, side)
        if len(entered) <= len(beyond) or not len(beyond):
            continue
        motion = abs(x[beyond[0]] - x[entered[0]])
        beyond = beyond[before.states[beyond] == OPEN]
        distance = np.abs(x[beyond] - x[beyond[0]])
        first = min(max(np.searchsorted(distance, window[0] * motion), beside), len(beyond) - 1)
        end = max(np.searchsorted(distance, window[1] * motion), first + max(beside, 1))
        b, a = before.at(beyond[first:end]), after.at(beyond[first:end])
        closed = b.clearance - a.clearance
        if np.all(closed > 0):
            r = (a.s - b.s) / closed
            way = Advance.of(x, before, after, side)
            if edge and way.length > 0:  # it is 0 where only one of a node's points has entered
                distance = side * (x[beyond[first:end]] - way.start)
                r = edge.turned(r, -side * edge.angle(distance, way.length, way.width))
            ratios[side].improve(float(np.mean(r)))


def anchors_of_entering(
    x, before: Surface, after: Surface, ratios: dict[int, Ratio], edge: StuckEdge | None = None
) -> np.ndarray:
    """Anchors (n,): where points open before would touch, those that were in contact as they were.

    Each goes with the edge on its side: of the contact before, or of the point that was first to touch. edge: of
    coupled contact.
    """
    contact = np.flatnonzero(before.states != OPEN)
    middle = x[contact].mean() if len(contact) else x[np.argmin(before.clearance)]
    r = np.where(x < middle, ratios[-1].value, ratios[1].value)
    for side in SIDES if edge and np.any(after.states != OPEN) else ():
        way = Advance.of(x, before, after, side)
        distance = side * (x - way.start)
        passed = (distance > 0) & (distance < way.length)
        if np.any(passed):
            r[passed] = edge.turned(r[passed], side * edge.angle(distance[passed], way.length, way.width))
    return np.where(before.states == OPEN, before.s + r * before.clearance, before.s)
