"""The record of a run: one entry a load step, with everything that files, plots and errors are made from."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from analytic.straight_way import StraightWay

from ..fem.surface import SurfaceState, fitted_contact_edges, fitted_stick_edges
from ..loading.schedule import LoadStep, pressed_first
from ..loading.stepping import Outcome
from .frictional_work import frictional_work, loss, work_of_pressing

SEPARATED, STICK, SLIP = 0, 1, 2  # contact states in files
PARABOLA = 2.0  # exponent for the first load step of a contact that does not grow similar to itself: an estimate


@dataclass(frozen=True)
class Entry:
    """State at the end of a load step (dimensionless) and what it took."""

    step: LoadStep
    surface: SurfaceState
    slip: np.ndarray  # (n,) u_x - delta_x since tangential loading began
    contact: tuple[float, float]  # edges of the contact
    stick: tuple[float, float]  # edges of the stick zone
    own_work: np.ndarray  # (n,) frictional work per area of surface in the load step, as two states tell it
    work: np.ndarray  # (n,) the same since the start, its sum as the balance of energy tells it
    dissipated: float  # its integral over the surface
    iterations: int
    cuts: int
    unsettled: float  # change of anchors that its state still asks for, over the motion in the load step
    residual: float
    seconds: float
    tolerance: float  # of the residual
    changes: tuple[int, ...]  # points whose contact state changed, in each iteration of the solve that counts
    number: int  # place in the history

    @property
    def a(self) -> float:
        """Contact half-width."""
        return float(self.contact[1] - self.contact[0]) / 2

    @property
    def peak_pressure(self) -> float:
        """Largest nodal pressure."""
        return float(self.surface.pressure.max())

    @property
    def carried(self) -> tuple[float, float]:
        """Line loads P, Q that the tractions carry; the prescribed ones to the tolerance of the load balance."""
        return self.surface.line_load(self.surface.pressure), self.surface.line_load(self.surface.traction)

    @property
    def c(self) -> float:
        """Stick half-width."""
        return float(self.stick[1] - self.stick[0]) / 2

    @property
    def stick_zones(self) -> np.ndarray:
        """Edges of the stick zone, (1, 2); (0, 2) where every point slips."""
        return np.array([self.stick]) if np.isfinite(self.stick[0]) else np.empty((0, 2))

    @property
    def contact_states(self) -> np.ndarray:
        """SEPARATED, STICK or SLIP at each node (n,). Without friction what is in contact counts as STICK."""
        return np.where(self.surface.pressure > 0, np.where(self.surface.slides != 0, SLIP, STICK), SEPARATED)

    def pressure_at(self, x) -> np.ndarray:
        """p at x, between nodes interpolated."""
        return np.interp(x, self.surface.x, self.surface.pressure)

    def traction_at(self, x) -> np.ndarray:
        """q, likewise."""
        return np.interp(x, self.surface.x, self.surface.traction)

    def slip_at(self, x) -> np.ndarray:
        """``slip``, likewise."""
        return np.interp(x, self.surface.x, self.slip)


@dataclass
class History:
    """Entries of a run so far. k: exponent of the modulus beside the edges of contact; mu: coefficient of friction, 0
    without a tangential problem.

    m: of an indenter |x|^m whose contact grows similar to itself while it is pressed on with friction; None where it
    does not. exponents: of tractions at x_l, c_l, c_r and x_r, a function of friction where slip has q = friction p;
    None: (1+k)/2, as without coupling. coupled: slip changes the pressure.
    """

    k: float
    mu: float
    m: float | None
    exponents: Callable[[float], tuple[float, ...]] | None
    coupled: bool
    entries: list[Entry] = field(default_factory=list)
    _way: StraightWay = field(init=False, repr=False)  # the present one
    _rest: np.ndarray = field(init=False, repr=False)  # (n,) relative displacement from which slip counts

    def append(self, outcome: Outcome, surface: SurfaceState, seconds: float) -> Entry:
        """Add the state that ``outcome`` ended with."""
        step, s = outcome.step, surface.relative_displacement
        ends = surface.slides[np.flatnonzero(surface.pressure > 0)[[0, -1]]]  # they differ while P changes
        x_l, x_r = (self._exponents(sign or step.direction)[i] for i, sign in zip((0, -1), ends))
        contact = fitted_contact_edges(surface, (x_l, x_r))
        stick, own_work = contact, np.zeros_like(s)
        if self.friction and np.any(surface.traction):
            left, right = fitted_stick_edges(surface, step.direction, lambda sign: self._exponents(sign)[1:3])
            stick = max(left, contact[0]), min(right, contact[1])  # each is fitted by itself
        if self.friction:
            own_work = self._own_work(step, surface, contact)
        if step.branch == "normal":
            self._rest = s
        entry = Entry(
            step=step,
            surface=surface,
            slip=s - self._rest,
            contact=contact,
            stick=stick,
            own_work=own_work,
            work=own_work,
            dissipated=0.0,
            iterations=outcome.iterations,
            cuts=outcome.cuts,
            unsettled=outcome.unsettled,
            residual=outcome.results[-1].residual,
            seconds=seconds,
            tolerance=max(result.tolerance for result in outcome.results),
            changes=outcome.results[-1].changes,
            number=len(self.entries),
        )
        self.entries.append(entry)
        self._add_work()
        return self.entries[-1]

    def _exponents(self, sign: float) -> tuple[float, ...]:
        """At x_l, c_l, c_r and x_r, where slip beside an edge has q = sign mu p."""
        return self.exponents(sign * self.mu) if self.exponents else 4 * ((1 + self.k) / 2,)

    def _own_work(self, step: LoadStep, after: SurfaceState, contact: tuple[float, float]) -> np.ndarray:
        """Frictional work (n,) of a load step; while P alone grows from first contact, what is new since the last."""
        steps = [*(entry.step for entry in self.entries), step]
        if not self.entries or self.m and pressed_first(steps) == len(steps):
            so_far = work_of_pressing(after, self.k, self.m or PARABOLA)
            return so_far - self.entries[-1].work if self.entries else so_far
        before = self.entries[-1]
        others = (entry.surface for entry in reversed(self.entries) if not entry.step.load.is_near(before.step.load))
        edges = before.contact, contact
        return frictional_work(before.surface, after, edges, self.k, next(others, None))

    def _add_work(self):
        """Sum up the frictional work on the present straight way of the loads: that of points in its load steps, times
        what makes its sum that of the balance of energy.
        """
        first, entry = len(self.entries) - 1, self.entries[-1]
        load, conjugates = entry.step.load, entry.surface.conjugates
        if entry.step.branch == "normal" or not first:
            self._way, share = StraightWay(self.mu, self.coupled, (load,), (conjugates,)), 1.0
        else:
            way = self._way.towards(load)
            lost = loss(self.entries[-2].surface, entry.surface, self.coupled)
            self._way = way.to(load, conjugates, lost, entry.surface.line_load(entry.own_work))
            share = self._way.share
            if share != way.share:  # all of the way has another sum
                first -= len(way.loads) - 1
        work = self.entries[first - 1].work if first else np.zeros_like(entry.own_work)
        for entry in self.entries[first:]:
            work = work + share * entry.own_work
            self.entries[entry.number] = replace(entry, work=work, dissipated=entry.surface.line_load(work))

    @property
    def friction(self) -> bool:
        """True where there is a tangential problem."""
        return self.mu > 0

    @property
    def has_cycle(self) -> bool:
        """True once a full cycle is done."""
        return self._full_cycles > 0

    @property
    def last_cycle(self) -> list[Entry]:
        """Entries of the last full cycle, without the one it starts from."""
        cycle = self._full_cycles
        return [entry for entry in self.entries if entry.step.cycle == cycle]

    @property
    def _full_cycles(self) -> int:
        """How many cycles have come to their end, the state A."""
        return max((entry.step.cycle for entry in self.entries if entry.step.state == "A"), default=0)

    @property
    def work(self) -> np.ndarray:
        """Frictional work per area of surface (n,) in the last full cycle, w of (51); where there is none, since the
        start.
        """
        return self.last_cycle[-1].work - self._before_cycle.work if self.has_cycle else self.entries[-1].work

    @property
    def dissipated_energy(self) -> float:
        """Energy dissipated in the last full cycle, the integral of ``work``; where there is none, since the start."""
        if not self.has_cycle:
            return float(self.entries[-1].dissipated)
        return float(self.last_cycle[-1].dissipated - self._before_cycle.dissipated)

    @property
    def _before_cycle(self) -> Entry:
        """What the last full cycle starts from."""
        return self.entries[self.last_cycle[0].number - 1]


def all_states(history: History) -> list[Entry]:
    """Entries of the last cycle; where there is none those with a tangential load; where there is none either, or
    friction acts from first contact, all since P is first reached, and without friction all.
    """
    if history.has_cycle:
        return history.last_cycle
    entries = history.entries
    if not history.friction:
        return entries
    pressed = pressed_first([entry.step for entry in entries])
    pressed_with_friction = np.any(entries[pressed - 1].surface.traction)
    tangential = [entry for entry in entries if entry.step.branch != "normal"]
    return entries[pressed - 1 :] if pressed_with_friction or not tangential else tangential
