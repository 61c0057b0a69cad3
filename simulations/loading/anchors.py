"""Anchors of points that enter contact within a load step: their relative displacement when the edge reached them.

Between two load steps the edge of contact passes points one after the other. Anchored where the step began they would
all be too early, those passed last the most. How far a point has moved when it touches is known from how far it was
from touching (``approach``). Points that slide when they enter and then stop, as the edge of stick follows that of
contact, are anchored on the curve that this edge draws (``stopped_points``). Where the contact is known to grow similar
to itself, they are anchored where that lets them stick.

The state after a step depends on the anchors: solve, measure, anchor, solve again. Where that does not settle, the
state whose anchors would change least is taken.
"""

from collections.abc import Callable

import numpy as np

from analytic.stuck_edge import StuckEdge
from forms.contact import CLOSED, OPEN

from ..fem.contact_problem import ContactProblem
from ..fem.surface_points import SIDES, AllPoints
from .approach import Approach, Ratio
from .contact_points import BESIDE, Surface, open_points
from .stopped_points import StickCurves

KEEPS = 6  # solves after which the points that stop are those of the best state up to there


class EnteringPoints:
    """Anchors the points that enter contact in the load steps of a frictional problem; edge: of a coupled one.

    iteration: that of the present load step.
    """

    iteration: "AnchorIteration"

    def __init__(self, problem: ContactProblem, edge: StuckEdge | None):
        self._problem, self._points = problem, AllPoints(problem.points)
        is_uncoupled = problem.held is not None
        self._approach = Approach(self._points.x, None if is_uncoupled else edge, is_uncoupled)
        self._start = dict.fromkeys(SIDES, np.nan)  # from where on edges of stick draw; nan where they do not

    def begin(self, clearance: np.ndarray, is_first_contact: bool, stuck: Callable | None = None):
        """Keep the state before a step, and anchor open points as if they went on as in the step before.

        clearance: of this rank's points (m,) before the step; stuck: where points at x stick after it, nan where they
        do not, if this is known.
        """
        memory, x = self._problem.memory, self._points.x
        states = memory.states_at_rest()
        states = np.where(states == OPEN, CLOSED, states)  # all in contact stick after a frictionless stage
        states = np.where((clearance > 0) | is_first_contact, OPEN, states)
        before = self._surface(states, memory.anchors(), clearance)
        self._approach.begin()
        stick = np.full(len(x), np.nan) if stuck is None else stuck(x)
        self.iteration = AnchorIteration(x, before, self._approach, self._start, stick)
        if not is_first_contact or stuck:
            self._put(self.iteration.touching())

    def renew(self, clearance: np.ndarray, settled: float) -> bool:
        """Measure r in the state after the step and anchor what has entered; False where it is anchored so already.

        clearance: of this rank's points (m,) now; settled: change of anchors that does not count, over how far the
        points in contact have moved.
        """
        memory, states = self._problem.memory, self._problem.terms.contact_states()
        after = self._surface(states, memory.rest_positions(), clearance)
        new = self.iteration.renewed(after, self._points.gathered(memory.anchors()), settled)
        if new is None:
            return False
        self._put(new)
        return True

    def save(self) -> dict[str, np.ndarray]:
        """What the next step needs (4,): r at both edges of contact, and from where on both edges of stick draw."""
        values = [self._approach.ratios[side].value for side in SIDES]
        return {"ratios": np.array([*values, *(self._start[side] for side in SIDES)])}

    def restore(self, saved: dict[str, np.ndarray]):
        """Go on from what ``save`` returned."""
        self._approach.ratios = {side: Ratio(float(r)) for side, r in zip(SIDES, saved["ratios"][:2])}
        self._start = {side: float(x) for side, x in zip(SIDES, saved["ratios"][2:])}

    def end(self):
        """After the points have come to rest: anchor open ones beside an edge, in line with those inside.

        Their own displacement and clearance have the error of the facet that the edge cuts. With them the next step
        would anchor points out of line with their neighbours, and the traction would zigzag.
        """
        before, after = self.iteration.before, self.iteration.after
        self._start = self.iteration.starts
        anchors = self._points.gathered(self._problem.memory.anchors())
        for side in SIDES:
            beyond = open_points(after.states, side)
            inside = beyond[:1] - side  # sorted by x: the last in contact
            beyond = beyond[before.states[beyond] == OPEN]
            closed = before.clearance[beyond] - after.clearance[beyond]
            led, guides = np.split(np.arange(len(beyond))[: 2 * BESIDE], [BESIDE])
            if not len(guides) or not np.all(closed[: 2 * BESIDE] > 0):
                continue
            entered = before.states[inside] == OPEN and before.clearance[inside] > 0  # a flat touches at once
            if entered and after.states[inside] == CLOSED:
                r = (anchors[inside] - before.s[inside]) / before.clearance[inside]
            elif self._approach.is_uncoupled:  # none has entered, or those that have slide: as the ones further out
                r = np.mean((anchors[beyond[guides]] - before.s[beyond[guides]]) / closed[guides])
            else:
                continue
            led = beyond[led]
            whole, rest = self._approach.beside(r, before, after, side, inside, led)
            s = before.s[led] + whole * before.clearance[led] - rest * after.clearance[led]
            # with coupling r is about right: further out their own displacement takes over
            fading = 1.0 if self._approach.is_uncoupled else 1.0 - np.arange(len(led)) / len(led)
            anchors[led] += fading * (s - anchors[led])
        self._put(anchors)

    def _surface(self, *local) -> Surface:
        return Surface(*map(self._points.gathered, local))

    def _put(self, anchors):
        self._problem.memory.move_anchors(self._points.mine(anchors))


class AnchorIteration:
    """Anchors in one load step: from the state that they led to, where they should have been, until both agree.

    before, after: surface before the load step and as last measured, its points (n,) at x; start: from where on edges
    of stick drew curves before it; stuck (n,): where points stick, as far as it is known, else nan. starts: from where
    on they draw now; unsettled: change of anchors that the last state asks for, over the motion; is_best: whether no
    state of this load step asks for less.
    """

    def __init__(self, x, before: Surface, approach: Approach, start: dict[int, float], stuck: np.ndarray):
        self._approach, self._stuck = approach, stuck
        self.before = self.after = before
        self._curves = StickCurves(x, before, start)
        self.starts = self._curves.starts
        self._solves = 0
        self.unsettled, self.is_best = 0.0, False
        self._best: tuple = ()  # of the state that asks for least: what it asks for, ``after`` and ``starts``

    def renewed(self, after: Surface, old: np.ndarray, settled: float) -> np.ndarray | None:
        """The next anchors (n,), from the state ``after`` that the ``old`` ones led to; None where these stay."""
        self.after = after
        self._approach.measure(self.before, after)
        touch = self.touching()
        new, change = touch, self._change(touch, old)
        is_known = self._approach.is_uncoupled or np.any(np.isfinite(self._stuck))
        self._solves += 1
        if self._curves.drawn or not is_known and change <= settled:
            if self._solves == KEEPS + 1:
                self._curves.keep(self._best[1].states)
            new = self._curves.draw(after, touch)  # what slides with these ratios does slide
            self.starts, change = self._curves.starts, self._change(new, old)
        if change <= settled:
            new = self._inside()
            if new is None:
                self.unsettled = 0.0
                return None
        self.unsettled, asks = change, (not (self._curves.drawn or is_known), change)
        self.is_best = not self._best or asks <= self._best[0]
        if self.is_best:
            self._best = asks, after, self.starts
        return self._curves.accelerate(old, new)

    def go_back(self):
        """The state is again that which asked for least."""
        (_, self.unsettled), self.after, self.starts = self._best

    def touching(self) -> np.ndarray:
        """Anchors (n,) where points stick, as far as that is known, and otherwise where they would touch."""
        touch = self._approach.anchors(self.before, self.after)
        return np.where(np.isnan(self._stuck), touch, self._stuck)

    def _inside(self) -> np.ndarray | None:
        """Anchors without those points known to stick that slide on: the mesh has its edge of stick further inside."""
        slide_on = np.isfinite(self._stuck) & (self.after.states != OPEN) & (self.after.states != CLOSED)
        if not np.any(slide_on):
            return None
        self._stuck[slide_on] = np.nan
        return self.touching()

    def _change(self, new, old) -> float:
        """Largest change of anchors over the largest motion; points that slide with the new ones too do not count."""
        direction = self.after.states - CLOSED  # in which the traction of a point is at its limit
        slides_still = (direction != 0) & (direction * (new - self.after.s) >= 0)
        counts = (self.after.states != OPEN) & ~slides_still
        moved = np.abs(new - self.before.s)[counts].max(initial=0.0)
        return float(np.abs(new - old)[counts].max() / moved) if moved else 0.0
