"""Work of friction while the loads go straight on, from the balance of energy.

States tell the work of each point in a load step to leading order: where it begins to slide, or an edge passes it,
within the step is not known. The sum over all points and load steps follows from the balance of energy better, as
displacements of the indenter are smooth functions of the load. With means of the forces before and after a load step
this balance is exact: tractions lose the work of the loads less the change of stored energy. All but the work of the
loads is what it is with loads that change steadily. So its error is put right, that of trapezoids for

    ∫ g dt,    g = δ_x ΔQ + δ_y ΔP + Δε ∫ q x dx,

with t from 0 to 1 on the way, whose length is ΔP, ΔQ, Δε. g is a cubic spline between the states.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import make_interp_spline

FEWEST = 4  # load steps from which the balance of energy counts
SMOOTH = 0.03  # of the energy: by how much every second load step may change it
KNOWN = 3e-4  # of the energy: what the balance is off by itself, so that it corrects no less
FAR = 10.0  # times the way of the loads: a limit of friction that is farther does not matter
SAME = 1e-9  # of the largest load: loads this close are equal


@dataclass(frozen=True)
class StraightWay:
    """States under loads that go straight on, in any units, and the work of friction since the first of them.

    mu: coefficient of friction; coupled: slip changes the pressure, so that pressure takes part in the balance. loads:
    P, Q and the strain along x in each state; conjugates: δ_y, δ_x and ∫ q x dx. Summed over the load steps, loss:
    what tractions, and with coupling pressures, lose by means of the forces; of_points: work of friction as each
    point's two states tell it.
    """

    mu: float
    coupled: bool
    loads: tuple[Sequence[float], ...]
    conjugates: tuple[Sequence[float], ...]
    loss: float = 0.0
    of_points: float = 0.0

    def goes_on(self, load: Sequence[float]) -> bool:
        """Whether the last load lies on the straight way from the first to this one."""
        come, way = _ways_from(self.loads[0], (self.loads[-1], load))
        share = np.clip(come @ way / max(way @ way, SAME**2), 0.0, 1.0)
        return bool(np.all(np.abs(come - share * way) <= SAME))

    def to(self, load: Sequence[float], conjugates: Sequence[float], loss: float, of_points: float) -> "StraightWay":
        """The way with one more load step."""
        return replace(
            self,
            loads=(*self.loads, load),
            conjugates=(*self.conjugates, conjugates),
            loss=self.loss + loss,
            of_points=self.of_points + of_points,
        )

    def towards(self, load: Sequence[float]) -> "StraightWay":
        """The way on which this load comes next: this one, or a new one from its last state where the load turns."""
        return self if self.goes_on(load) else StraightWay(self.mu, self.coupled, self.loads[-1:], self.conjugates[-1:])

    @property
    def work(self) -> float:
        """Work of friction on the way."""
        return self.share * self.of_points

    @cached_property
    def share(self) -> float:
        """Work of friction by the balance of energy, over that of points. 1 where it is not known: with less than
        FEWEST load steps, or where every second of them alone says otherwise. 1 also where points are as good.
        """
        loads = np.array(self.loads, dtype=float)
        if self.of_points <= 0 or not self.coupled and np.ptp(loads[:, 0]) <= SAME * loads[0, 0]:
            return 1.0  # where the pressure stays that of points is exact
        ways = _ways_from(self.loads[0], self.loads)
        t = ways @ ways[-1] / max(ways[-1] @ ways[-1], SAME**2)
        steps = np.flatnonzero(np.diff(t, prepend=-1.0) > SAME)  # without dwells
        if len(steps) <= FEWEST:
            return 1.0
        g = np.array(self.conjugates) * (self.coupled, 1.0, 1.0) @ (loads[-1] - loads[0])
        last = self._last_to_slide()
        fine, coarse = (_integral(t[n], g[n], last) for n in (steps, np.append(steps[:-1:2], steps[-1])))
        work = self.loss + float(np.trapezoid(g, t)) - fine
        smooth = abs(fine - coarse) < SMOOTH * work
        return work / self.of_points if smooth and abs(work - self.of_points) > KNOWN * work else 1.0

    def _last_to_slide(self) -> float:
        """t at which the last point would begin to slide, |Q| = mu P; after a turn, |ΔQ| = mu (P + P(0))."""
        mu, (P, Q, _), (dP, dQ, _) = self.mu, self.loads[0], np.subtract(self.loads[-1], self.loads[0])
        found = [FAR]
        for sign in (1, -1):
            if sign * dQ > mu * dP:
                room = mu * P - sign * Q if sign * Q >= 0 else 2.0 * mu * P
                found.append(room / (sign * dQ - mu * dP))
        return max(min(found), 1.0)


def _ways_from(start, loads) -> np.ndarray:
    """Ways (s, 3) from a load to others, P and Q over the largest of all, the strain over its own largest."""
    P, Q, strain = np.abs((start, *loads)).max(axis=0)
    return np.subtract(loads, start) / (max(P, Q), max(P, Q), strain or 1.0)


def _integral(t: np.ndarray, g: np.ndarray, last: float) -> float:
    """∫ g dt from 0 to 1, g smooth in w = 1 - sqrt(1 - t/last), as displacements end steeply at ``last``."""
    w = 1.0 - np.sqrt(1.0 - t / last)
    once = make_interp_spline(w, g, k=min(3, len(w) - 1)).antiderivative()
    twice = once.antiderivative()
    return 2.0 * last * float((1.0 - w[-1]) * once(w[-1]) + twice(w[-1]))  # dt = 2 last (1 - w) dw, by parts
