"""Load stepping: press, then rock, load step by load step; in half steps where every way of solving one fails, or where
tractions zigzag and do so less with half steps."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from analytic.material import GradedHalfPlane
from analytic.stuck_edge import StuckEdge

from ..fem.contact_problem import ContactProblem
from ..fem.load import NO_LOAD, Load
from ..solvers.newton import FORCE_TOLERANCE, Newton, NewtonResult
from ..solvers.system import System
from . import present_state
from .anchors import EnteringPoints
from .fallbacks import FALLBACKS, Limits
from .schedule import LoadStep, pressed_first

Stuck = Callable[[float, np.ndarray], np.ndarray]


class SolveError(RuntimeError):
    """A load step has no answer, and smaller ones did not help; after: the load that was not reached, where known."""

    def __init__(self, reason: str, after: Load | None = None):
        super().__init__(reason)
        self.after = after


@dataclass(frozen=True)
class Outcome:
    """What a load step took: all solves and halvings; by how much anchors did not settle, over the motion."""

    step: LoadStep
    results: tuple[NewtonResult, ...]
    cuts: int
    unsettled: float

    @property
    def iterations(self) -> int:
        """Newton iterations, those of failed attempts included."""
        return sum(result.iterations for result in self.results)


class LoadStepping:
    """Runs load steps on a body, each by the problem of its stage.

    normal: the frictionless problem; frictional: the one that takes over when tangential loading starts, or from
    the first contact on (``friction_first``), or None; system: function from a problem to the
    solvers.system.System that solves it; tolerance: Newton's, of forces and loads over P; stuck: where points at x (n,)
    stick while P grows from first contact under friction, as a function of P and x, nan where they do not; None where
    this is not known;
    solid: the half-plane that the body is near its surface, None where r of ``anchors`` is to be the same everywhere;
    zigzag: by how much coupled tractions of the present state zigzag, over what is allowed, on every rank.
    """

    def __init__(
        self,
        normal: ContactProblem,
        frictional: ContactProblem | None,
        system,
        friction_first=False,
        tolerance: float = FORCE_TOLERANCE,
        stuck: Stuck | None = None,
        solid: GradedHalfPlane | None = None,
        zigzag: Callable[[], float] = lambda: 0.0,
    ):
        self.problem, self.normal, self.frictional = normal, normal, frictional
        self.body, self._system = normal.body, system
        self._friction_first, self._tolerance, self._stuck = friction_first, tolerance, stuck
        self._edge, self._zigzag = StuckEdge(solid) if solid else None, zigzag
        self.limits = Limits()
        self._newton: Newton = None  # type: ignore[assignment]  # made when the stage begins
        self._normal_newton: Newton = None  # type: ignore[assignment]
        self._results: list[NewtonResult] = []  # of this load step
        self._unsettled = 0.0
        self._is_pressed_only = False  # in this load step and all before

    @property
    def system(self) -> System:
        """What solves the present stage."""
        return self._newton.system

    def save(self) -> dict[str, np.ndarray]:
        """What the next step takes from those before beside the present state, of rank 0, by name."""
        saved = self._newton.save()
        if self.problem.friction:
            saved |= self.entering.save()
        if self._is_uncoupled:
            saved |= {"normal forces": self._normal_newton.system.last_forces()}
        return saved

    def restore(self, saved: dict[str, np.ndarray]):
        """Go on from what ``save`` returned; the present state is already back."""
        self._newton.restore(saved)
        if self.problem.friction:
            self.entering.restore(saved)
        if self._is_uncoupled:  # these forces belong to the state that is held
            state = self.body.state.x.array.copy()
            self.body.state.x.array[:] = self.problem.held.state.x.array
            self._normal_newton.system.take_up(saved["normal forces"])
            self.body.state.x.array[:] = state

    def skip(self, done: list[LoadStep]):
        """Stand where a run stands that has done these steps; its memory is yet to be restored."""
        self._newton = self._start(self.normal)
        if self.frictional and (self._friction_first or any(step.branch != "normal" for step in done)):
            self._normal_newton, self.problem = self._newton, self.frictional
            self._newton = self._start(self.frictional)

    def run(self, schedule: list[LoadStep], done: int = 0) -> Iterator[Outcome]:
        """Yield each outcome after the first ``done`` while its state is on the body; SolveError ends the run."""
        before = schedule[done - 1].load if done else NO_LOAD
        if not done:
            self._newton = self._start(self.problem)
        pressed = pressed_first(schedule)
        for number, step in enumerate(schedule[done:], done):
            self._results, self._unsettled, cuts = [], 0.0, 0
            self._is_pressed_only = number < pressed
            if self.problem is not self.frictional and (step.branch != "normal" or self._friction_first):
                if self._friction_first:  # the frictionless contact of the first step is where Newton starts
                    cuts = self._advance(before, step)
                self._begin_friction()
            cuts += self._take(before, step)
            yield Outcome(step, tuple(self._results), cuts, self._unsettled)
            before = step.load

    @property
    def _is_uncoupled(self):
        return self.problem.held is not None

    @cached_property
    def entering(self) -> EnteringPoints:
        """Anchors of the points that enter contact under friction."""
        return EnteringPoints(self.problem, self._edge)

    def _start(self, problem):
        return Newton(self._system(problem), self._tolerance)

    def _begin_friction(self):
        self._normal_newton, self.problem = self._newton, self.frictional
        if self._is_uncoupled:
            self.problem.hold_pressure(self.normal)
        if not self._friction_first:  # there the surface came to rest before it was touched, at s = 0
            self.problem.memory.release()
        self._newton = self._start(self.problem)

    def _take(self, before: Load, step: LoadStep) -> int:
        """``_advance``; where tractions zigzag after a step it is solved in two halves as well, and the smoother stays.

        Points that slide through a long step are anchored where an estimate says that they stopped.
        """
        if self._is_uncoupled or not self.problem.friction:
            return self._advance(before, step)
        begun = self._everything()
        cuts, unsettled = self._advance(before, step), self._unsettled
        zigzag = 0.0 if cuts else self._zigzag()
        if zigzag <= 1.0:
            return cuts
        whole = self._everything()
        self._put_back(begun)
        self._unsettled = 0.0
        try:
            cuts = self._in_halves(before, step)
            if self._zigzag() < zigzag:
                return cuts
        except SolveError:
            pass
        self._put_back(whole)
        self._unsettled = unsettled
        self._results.append(self._newton.balance(step.load))
        return 0

    def _everything(self):
        return present_state.save(self.system), self.save()

    def _put_back(self, saved):
        state, memory = saved
        present_state.restore(self.system, state)
        self.restore(self.body.mesh.comm.bcast(memory))

    def _advance(self, before: Load, step: LoadStep, depth: int = 0) -> int:
        """Solve a step, in two halves should every way fail; returns the number of halvings."""
        saved, after = present_state.save(self.system), step.load
        # at a dwell anchors stay: changes of them have no motion to be measured by
        moves = self.problem.friction and not before.is_near(after)
        # without coupling and with P as it was no edge of contact moves
        enters = moves and not (self._is_uncoupled and before.P == after.P)
        tried = self._with_entering_points(before, after) if enters else self._solve(after)
        if tried[-1].converged:
            if moves:
                self.problem.memory.come_to_rest()
            if enters:
                self.entering.end()
                self._unsettled = max(self._unsettled, self.entering.iteration.unsettled)
            self._newton.accept(after)
            return 0
        present_state.restore(self.system, saved)
        first, last = tried[0], tried[-1]
        if depth == self.limits.halvings:
            changes = ", ".join(map(str, first.changes[-4:])) or "none"
            raise SolveError(
                f"no equilibrium: {first.reason}, and at last {last.reason}; force residual {first.residual:.1e} P "
                f"after {first.iterations} iterations and {depth} halvings of the load step, contact states changed "
                f"in the last iterations: {changes}",
                after,
            )
        return self._in_halves(before, step, depth)

    def _in_halves(self, before: Load, step: LoadStep, depth: int = 0) -> int:
        half = replace(step, angle=step.angle / 2)
        middle = replace(half, load=step.on_the_way(before, 0.5))
        cuts = self._advance(before, middle, depth + 1)
        return 1 + cuts + self._advance(middle.load, half, depth + 1)

    def _solve(self, load: Load, newton: Newton | None = None) -> list[NewtonResult]:
        """What the ways of solving ended with, in order, up to the first that converged; newton: the stage's own."""
        newton = newton or self._newton
        saved, tried = present_state.save(self.system), []
        for way in FALLBACKS:
            if way.applies(newton.system.problem):
                results = way.solve(newton, load)
                self._results += results
                tried.append(results[-1])
                if results[-1].converged:
                    break
                present_state.restore(self.system, saved)
        return tried

    def _with_entering_points(self, before, after):
        """``_solve``, again and again until the points that enter contact are anchored where the edge passed them."""
        first_contact = before.P == 0.0
        # at rest the clearance is the indenter's height
        clearance = self._clearance_at(0.0, 0.0) if first_contact else self._clearance()
        stuck = partial(self._stuck, after.P) if self._stuck and self._is_pressed_only else None
        self.entering.begin(clearance, first_contact, stuck)
        if self._is_uncoupled:
            tried = self._renew_pressure(after)
            if not tried[-1].converged:
                return tried
        tried = self._solve(after)
        if tried[-1].converged:
            self._settle_anchors(after)
        return tried

    def _settle_anchors(self, load: Load):
        """Renew the anchors and solve again until they stay; else, and where there is no answer with the new ones, end
        with the state that asks for least.
        """
        limits = self.limits
        settled = limits.anchors_settled_uncoupled if self._is_uncoupled else limits.anchors_settled
        best: present_state.Arrays = {}
        for solves_left in reversed(range(limits.anchor_passes + 1)):
            found = present_state.save(self.system)
            if not self.entering.renew(self._clearance(), settled):
                return
            best = found if self.entering.iteration.is_best else best
            if not solves_left or not self._solve(load)[-1].converged:
                self.entering.iteration.go_back()
                present_state.restore(self.system, best)
                self._results.append(self._newton.balance(load))
                return

    def _clearance(self):
        """Of the surface points; without coupling from the frictionless problem, whose state is held."""
        if not self._is_uncoupled:
            return self.problem.terms.clearance.values()
        return self._clearance_at(self.problem.held.state.x.array, self.body.delta.value)

    def _clearance_at(self, state, rigid):
        """By the frictionless problem, with this state of the body and these rigid displacements; its own stay."""
        body = self.body
        kept = body.state.x.array.copy(), body.delta.value.copy()
        body.state.x.array[:], body.delta.value[:] = state, rigid
        clearance = self.normal.terms.clearance.values()
        body.state.x.array[:], body.delta.value[:] = kept
        return clearance

    def _renew_pressure(self, load: Load) -> list[NewtonResult]:
        """Without coupling: the frictionless contact under a new P, beneath an unchanged tangential problem."""
        tangential = self.problem.held.remove_tangential()
        tried = self._solve(Load(load.P), self._normal_newton)
        if tried[-1].converged:
            self.problem.hold_pressure(self.normal)
            self.body.state.x.array[:] += tangential
        return tried
