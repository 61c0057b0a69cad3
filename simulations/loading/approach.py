"""Where points that are open still would touch: they move sideways in proportion as they come closer to the indenter.

    s(at touch) = s_before + r clearance_before,      r = (s_after - s_before)/(clearance_before - clearance_after),

with r measured at both edges of contact, on points that are open before and after a load step. In uncoupled contact
with a power law, r is alpha dQ/dP as long as the surface beside the edge sticks, the same everywhere: then this is
exact, however large the step is. With coupling displacements oscillate ahead of an edge that sticks, and r depends on
the distance from it as ``StuckEdge`` tells: one r for all would leave an error of first order in the step.
"""

from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from analytic.stuck_edge import StuckEdge
from forms.contact import OPEN

from ..fem.surface_points import SIDES
from .contact_points import BESIDE, Surface, edge_by_clearance, open_points

# r is measured between two distances from the edge, in units of its motion in the step. The further out, the better a
# wrong r is seen; the closer, the more it is the edge's own. Without coupling r is the same everywhere.
COUPLED, UNCOUPLED = (0.1, 0.6), (0.5, 2.0)
STEPS = 0.3, 3.0  # shortest and longest step of the secant method, over the defect


class Approach:
    """r at both edges of contact, of points (n,) at x; edge: of coupled contact.

    Without coupling r is not measured on the points beside the edge, whose displacement has the error of its facet.
    """

    def __init__(self, x: np.ndarray, edge: StuckEdge | None, is_uncoupled: bool = False):
        self._x, self._edge, self.is_uncoupled = x, edge, is_uncoupled
        if edge:  # asked for the same two surfaces by all three methods below
            self._advance = lru_cache(maxsize=len(SIDES))(partial(Advance.of, x, power=edge.power))
        self.ratios = {side: Ratio() for side in SIDES}

    def begin(self):
        """Another load step: keep the values, not how they were found."""
        self.ratios = {side: Ratio(ratio.value) for side, ratio in self.ratios.items()}

    def measure(self, before: Surface, after: Surface):
        """Improve r by points that are open before and after."""
        x, edge = self._x, self._edge
        (near, far), beside = (UNCOUPLED, BESIDE) if self.is_uncoupled else (COUPLED, 0)
        for side in SIDES:
            beyond = open_points(after.states, side)
            entered = open_points(before.states, side)
            if len(entered) <= len(beyond) or not len(beyond):
                continue
            motion = abs(x[beyond[0]] - x[entered[0]])
            beyond = beyond[before.states[beyond] == OPEN]
            distance = np.abs(x[beyond] - x[beyond[0]])
            first = min(max(np.searchsorted(distance, near * motion), beside), len(beyond) - 1)
            end = max(np.searchsorted(distance, far * motion), first + max(beside, 1))
            b, a = before.at(beyond[first:end]), after.at(beyond[first:end])
            closed = b.clearance - a.clearance
            if np.all(closed > 0):
                r = (a.s - b.s) / closed
                way = self._advance(before, after, side) if edge else None
                if way and way.length > 0:  # it may be 0 where only one of a node's points has entered
                    distance = side * (x[beyond[first:end]] - way.start)
                    r = edge.turned(r, -side * edge.angle(distance, way.length, way.width))
                self.ratios[side].improve(float(np.mean(r)))

    def anchors(self, before: Surface, after: Surface) -> np.ndarray:
        """Anchors (n,): where points open before would touch, those that were in contact as they were.

        Each goes with the edge on its side: of the contact before, or of the point that was first to touch.
        """
        x, edge = self._x, self._edge
        contact = np.flatnonzero(before.states != OPEN)
        middle = x[contact].mean() if len(contact) else x[np.argmin(before.clearance)]
        r = np.where(x < middle, self.ratios[-1].value, self.ratios[1].value)
        for side in SIDES if edge and np.any(after.states != OPEN) else ():
            way = self._advance(before, after, side)
            distance = side * (x - way.start)
            passed = (distance > 0) & (distance < way.length)
            if np.any(passed):
                r[passed] = edge.turned(r[passed], side * edge.angle(distance[passed], way.length, way.width))
        return np.where(before.states == OPEN, before.s + r * before.clearance, before.s)

    def beside(self, r, before: Surface, after: Surface, side: int, inside, beyond):
        """The r of points ``beyond`` an edge, from before the load step and from after it until they touch.

        r: of the point ``inside``, from before the load step until it touched; all are indices.
        """
        if not (edge := self._edge):
            return r, r
        way = self._advance(before, after, side)
        if not way.length > 0:
            return r, r
        entered, distance = (side * (self._x[points] - way.start) for points in (inside, beyond))
        known = edge.touching(entered, way.width)
        whole = edge.touching(distance, way.width)
        rest = edge.touching(distance - way.length, way.width + way.length)
        return edge.turned(r, side * (whole - known)), edge.turned(r, side * (rest - known))


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
    def of(cls, x, before: Surface, after: Surface, side: int, power: float) -> "Advance":
        """Of points (n,) at x; power: of the distance from the edge, with which the clearance grows.

        A load step may move an edge by a few facets only: half a facet more or less would put points out of line.
        """
        tip = float(x[np.argmin(before.clearance)])  # from where the first contact grows
        is_new = np.all(before.states == OPEN)
        start, far = (tip if is_new else edge_by_clearance(x, before, which, power) for which in (side, -side))
        end = edge_by_clearance(x, after, side, power)
        return cls(start, side * (end - start), side * (start - far))
