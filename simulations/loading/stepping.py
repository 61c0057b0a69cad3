"""The load programme: press, then rock, increment by increment, with smaller steps where Newton fails."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

from ..fem.contact_problem import ContactProblem, X, Y
from ..solvers.newton import FORCE_TOLERANCE, Newton, NewtonResult, System
from .anchors import Newcomers
from .pinning import HeldPoint
from .schedule import Increment

MAX_CUTS = 6
MAX_SWEEPS = 60  # of the fixed point
SETTLINGS, MAX_SETTLINGS = 3, 8  # solves for where newcomers stopped: more while some of them slide again


class SolveError(RuntimeError):
    """Newton failed and smaller increments did not help; the message says why.

    load: the line loads (Q, P), in scaled units, that were not reached.
    """

    def __init__(self, reason: str, load=None):
        super().__init__(reason)
        self.load = load


@dataclass(frozen=True)
class Outcome:
    """What an increment took."""

    increment: Increment
    results: tuple[NewtonResult, ...] = field(default=())
    cuts: int = 0  # halvings

    @property
    def iterations(self) -> int:
        """Newton iterations, those of failed attempts included."""
        return sum(result.iterations for result in self.results)


class LoadProgramme:
    """Runs increments on a half-plane, each by the problem of its stage.

    normal: the frictionless problem; frictional: the one that takes over when tangential loading starts, or from
    the first contact on (``friction_first``), or None; system: function from a problem to the newton.System that
    solves it; tolerance: Newton's, of forces and loads over P.
    """

    def __init__(
        self,
        normal: ContactProblem,
        frictional: ContactProblem | None,
        system,
        friction_first=False,
        tolerance: float = FORCE_TOLERANCE,
    ):
        self.problem, self.normal, self.frictional = normal, normal, frictional
        self.body, self._system = normal.body, system
        self._friction_first, self._tolerance = friction_first, tolerance
        self.confirms = False  # set before ``run``: solves under Coulomb's law as it is are confirmed (newton.Newton)

    @property
    def system(self) -> System:
        """What solves the present stage."""
        return self._newton.system

    @property
    def normal_system(self) -> System:
        """What solved the normal stage, once friction has begun."""
        return self._normal_newton.system

    def skip(self, done: list[Increment]):
        """Stand where a run stands that has done these increments; its memory is yet to be restored."""
        self._newton = self._start(self.normal)
        if self.frictional and (self._friction_first or any(increment.branch != "normal" for increment in done)):
            self._normal_newton, self.problem = self._newton, self.frictional
            self._newton = self._start(self.frictional)

    def run(self, programme: list[Increment], done: int = 0) -> Iterator[Outcome]:
        """Yield each outcome after the first ``done`` while its state is on the half-plane; SolveError ends the run."""
        before = programme[done - 1] if done else Increment(P=0.0)
        if not done:
            self._newton = self._start(self.problem)
        for increment in programme[done:]:
            results: list[NewtonResult] = []
            if self.problem is not self.frictional and (increment.branch != "normal" or self._friction_first):
                if self._friction_first:  # the frictionless contact of the first increment is where Newton starts
                    self._advance(before, increment, results)
                self._begin_friction()
            uncoupled = self.problem is self.frictional and Y not in self.problem.directions
            if uncoupled and increment.P != before.P:
                self._renew_pressure(increment, results)
            cuts = self._advance(before, increment, results)
            yield Outcome(increment, tuple(results), cuts)
            before = increment

    @cached_property
    def _newcomers(self):
        return Newcomers(self.problem)

    @cached_property
    def _held_point(self):
        return HeldPoint(self.problem)

    def _start(self, problem):
        return Newton(self._system(problem), self.body.mesh.comm, tolerance=self._tolerance)

    def _begin_friction(self):
        self._normal_newton, self.problem = self._newton, self.frictional
        if Y not in self.frictional.directions:
            self.frictional.hold_pressure(self.normal)
        if not self._friction_first:  # there the surface came to rest before it was touched, at s = 0
            self.frictional.memory.release()
        self._newton = self._start(self.frictional)

    def _renew_pressure(self, increment: Increment, results: list[NewtonResult]):
        """Without coupling: the frictionless contact under a new P, beneath an unchanged tangential problem."""
        tangential = self.problem.held.remove_tangential()
        result = self._normal_newton.solve((0.0, increment.P), confirm=self.confirms)
        results.append(result)
        if not result.converged:
            raise SolveError(f"no frictionless contact: {result.reason}", increment.load)
        self.problem.hold_pressure(self.normal)
        self.body.state.x.array[:] += tangential

    def _advance(self, before: Increment, after: Increment, results: list[NewtonResult], depth: int = 0) -> int:
        """Newton; where it fails guarded Newton, then the fixed point in the pressure, then two half increments.

        Appends every solve to ``results`` and returns the number of halvings.
        """
        saved = self._save()
        result, first = self._solve(after.load, results)
        if result.converged:
            if self.problem.friction:
                if after.branch == "normal":
                    self._settle(after.load, results)
                self.problem.memory.come_to_rest()
            return 0
        self._restore(saved)
        if depth == MAX_CUTS:
            raise SolveError(
                f"no equilibrium: {first.reason}, and at last {result.reason}; force residual "
                f"{first.residual:.1e} P after {first.iterations} iterations and {depth} halvings of the increment, "
                f"contact states changed in the last iterations: {', '.join(map(str, first.changes[-4:])) or 'none'}",
                after.load,
            )
        P = (before.P + after.P) / 2 if Y in self.problem.directions else after.P
        middle = replace(after, P=P, Q=(before.Q + after.Q) / 2, state="")
        cuts = self._advance(before, middle, results, depth + 1)
        return 1 + cuts + self._advance(middle, after, results, depth + 1)

    def _solve(self, load, results: list[NewtonResult]) -> tuple[NewtonResult, NewtonResult]:
        """The last attempt, converged or not, and the first."""
        saved = self._save()
        attempts = [lambda: self._newton.solve(load, self.problem.friction, confirm=self.confirms)]
        if self.problem.friction:
            attempts.append(lambda: self._guarded(load, results))
        if self.problem.directions == (X, Y):
            attempts.append(lambda: self._fixed_point(load, results))
        tried = []
        for attempt in attempts:
            tried.append(attempt())
            results.append(tried[-1])
            if tried[-1].converged:
                break
            self._restore(saved)
        return tried[-1], tried[0]

    def _settle(self, load, results: list[NewtonResult]):
        """Find out where points that came to stick as the contact grew under P alone did so.

        Not where it moves aside: there that changes as much as it cures, and takes twice the time (measured).
        """
        saved = self._save()
        self._newcomers.begin()
        for solves in range(MAX_SETTLINGS):
            if solves >= SETTLINGS and self._newcomers.are_settled():
                return
            any_new = self._newcomers.anchor()
            if not any_new and solves == 0:
                return
            if not any_new or not self._solve(load, results)[0].converged:
                break
        self._restore(saved)
        results.append(self._newton.balance(load))

    def _guarded(self, load, results: list[NewtonResult]) -> NewtonResult:
        """Newton in which no point turns round without sticking in between, then Newton as it is to confirm.

        One point sticks at least: where all would slide, one is held.
        """
        safeguards, newton = self.problem.safeguards, self._newton
        newton.after_linearise, newton.after_residual = safeguards.note_sliding, self._held_point.update
        guarded = newton.solve(load, predict=True)
        newton.after_linearise, newton.after_residual = lambda: None, lambda: False
        safeguards.forget()
        self._held_point.release()
        if not guarded.converged:
            return guarded
        results.append(guarded)
        return newton.solve(load, confirm=self.confirms)

    def _fixed_point(self, load, results: list[NewtonResult]) -> NewtonResult:
        """Friction limited by the last sweep's pressure, sweep after sweep until that is the present one.

        Each sweep is the tangent of a convex minimum, on which Newton does not cycle; the sweeps contract by about
        mu times the coupling.
        """
        for sweeps in range(MAX_SWEEPS):
            with self.problem.safeguards.lagged_pressure():
                sweep = self._newton.solve(load, predict=sweeps == 0)
            if not sweep.converged:
                return replace(sweep, reason=f"in a fixed-point sweep, {sweep.reason}")
            results.append(sweep)
            balance = self._newton.balance(load)
            if balance.converged:
                return balance
        return balance

    def _save(self):
        memory = self.problem.memory.save() if self.problem.friction else None
        return self.body.state.x.array.copy(), self.body.delta.value.copy(), memory

    def _restore(self, saved):
        self.body.state.x.array[:], self.body.delta.value[:], memory = saved
        if memory is not None:
            self.problem.memory.restore(memory)
