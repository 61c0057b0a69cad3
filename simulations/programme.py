"""The load programme: press, then rock, increment by increment, with smaller steps where Newton fails."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from .newton import Newton, NewtonResult
from .problem import ContactProblem, HalfPlane

MAX_CUTS = 6


class SolveError(RuntimeError):
    """Newton failed and smaller increments did not help; the message says where and why."""


@dataclass(frozen=True)
class Increment:
    """One load level: line loads (dimensionless), the branch it lies on, and a letter for the paper's states."""

    P: float
    Q: float = 0.0
    branch: str = "normal"  # normal, initial, unloading, reloading
    state: str = ""  # A ... E of Figure 11
    cycle: int = 0

    @property
    def load(self) -> tuple[float, float]:
        """Line loads as (Q, P)."""
        return self.Q, self.P


@dataclass(frozen=True)
class Outcome:
    """What an increment took."""

    increment: Increment
    results: tuple[NewtonResult, ...] = field(default=())

    @property
    def iterations(self) -> int:
        """Newton iterations, cuts included."""
        return sum(result.iterations for result in self.results)

    @property
    def cuts(self) -> int:
        """Solves that failed and were repeated in smaller steps."""
        return sum(not result.converged for result in self.results)


def fretting_programme(P: float, Q_A: float, cycles: int, quarter: int) -> list[Increment]:
    """Press with P, rock to +Q_A, then ``cycles`` times to -Q_A and back, ``quarter`` increments per Q_A.

    States of Figure 11: A = +Q_A, B = +Q_A/2 on the way down, C = 0, D = -Q_A/2, E = -Q_A. B and D are marked on the
    nearest increments.
    """
    ramp = np.arange(1, quarter + 1) / quarter
    swing = np.arange(1, 2 * quarter + 1) / quarter
    programme = [Increment(P)]
    programme += [Increment(P, Q_A * z, "initial") for z in ramp]
    programme[-1] = replace(programme[-1], state="A")
    for cycle in range(1, cycles + 1):
        down = [Increment(P, Q_A * (1 - z), "unloading", cycle=cycle) for z in swing]
        for state, share in (("B", 0.25), ("C", 0.5), ("D", 0.75), ("E", 1.0)):
            i = round(share * 2 * quarter) - 1
            if i >= 0:
                down[i] = replace(down[i], state=state)
        up = [Increment(P, -Q_A * (1 - z), "reloading", cycle=cycle) for z in swing]
        up[-1] = replace(up[-1], state="A")
        programme += down + up
    return programme


class LoadProgramme:
    """Runs increments on a half-plane: the normal stage without friction, the rest with it."""

    def __init__(self, frictionless: ContactProblem, frictional: ContactProblem, system, mu: float):
        """system: function from a problem to the newton.System that solves its steps."""
        self.problem, self.frictional = frictionless, frictional
        self.body, self.mu, self._system = frictionless.body, mu, system
        self._newton = self._start(self.problem)

    def run(self, programme: list[Increment]) -> Iterator[Outcome]:
        """Yield each outcome while its state is on the half-plane; SolveError ends the run."""
        before = Increment(P=0.0)
        for increment in programme:
            if increment.branch != "normal" and self.problem is not self.frictional:
                self._begin_friction()
            results: list[NewtonResult] = []
            self._advance(before, increment, results, cuts=0)
            yield Outcome(increment, tuple(results))
            before = increment

    def _start(self, problem):
        return Newton(self._system(problem), self.body.mesh.comm)

    def _begin_friction(self):
        self.problem = self.frictional
        self._newton = self._start(self.frictional)
        self.frictional.mu.value = self.mu
        self.frictional.release()

    def _advance(self, before: Increment, after: Increment, results: list[NewtonResult], cuts: int):
        friction = self.problem is self.frictional
        saved = self._save()
        result = self._newton.solve(after.load, predict=self.problem.all_stick if friction else None)
        results.append(result)
        if result.converged:
            if friction:
                self.frictional.come_to_rest()
            return
        self._restore(saved)
        if cuts == MAX_CUTS:
            raise SolveError(
                f"no equilibrium between Q/P = {before.Q / after.P:.6g} and {after.Q / after.P:.6g} "
                f"({after.branch}): {result.reason}; force residual {result.residual:.1e} P after "
                f"{result.iterations} iterations and {cuts} halvings of the increment"
            )
        middle = replace(after, P=(before.P + after.P) / 2, Q=(before.Q + after.Q) / 2, state="")
        self._advance(before, middle, results, cuts + 1)
        self._advance(middle, after, results, cuts + 1)

    def _fields(self):
        return [self.body.u.x, self.frictional.anchor.x]

    def _save(self):
        return [f.array.copy() for f in self._fields()], self.body.delta.value.copy()

    def _restore(self, saved):
        arrays, delta = saved
        for f, array in zip(self._fields(), arrays):
            f.array[:] = array
        self.body.delta.value[:] = delta
