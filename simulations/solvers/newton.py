"""Newton's method for a contact problem: PETSc SNES around one of two ways to solve a step.

``full.FullSystem`` has every displacement as unknown, ``condensed.CondensedSystem`` the contact forces alone. Both
carry the rigid displacements of the indenter and linearise the same forms. Options are open on the command
line under the prefix ``fretting_``.
"""

import weakref
from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from .bulk_solver import with_defaults
from .edge_jumps import EdgeJumps
from .last_steps import LastSteps
from .path import follow
from .system import System

SNES_OPTIONS = {
    "snes_type": "newtonls",
    "snes_linesearch_type": "basic",  # full steps: the semismooth method ends after finitely many
    "snes_max_it": 60,
    "ksp_type": "preonly",
}
PREFIX = "fretting_"
FORCE_TOLERANCE = 1e-9  # force residual and load imbalance / P, where round-off lets them get there
OVER_ROUND_OFF = 4.0  # residuals are balanced this many times above the last digits' own, measured for k from -0.9 to 0
SETTLED = 1e-11  # force residual / P above which a balanced state gets one more step: then ranks do not change numbers;
# where contact states are at rest it has to be above round-off too
PATH = "path_max_it", 400  # option: steps at most of a path on which contact states change one by one
ATTAINABLE = 1e-6  # residual up to which a solve may end that round-off holds up


@dataclass(frozen=True)
class NewtonResult:
    """How a solve ended: iterations, relative force residual, and a reason if it failed."""

    converged: bool
    iterations: int
    residual: float
    reason: str
    tolerance: float = FORCE_TOLERANCE  # of the residual: the attainable one where that is larger
    changes: tuple[int, ...] = ()  # points whose contact state (open, stick, slip) changed, iteration by iteration


class _Operator:
    """Context through which PETSc multiplies by the system's Jacobian (mult) and by its inverse (apply).

    right: the right-hand side to take instead of PETSc's, where contact states are imposed on a step; else None.
    """

    def __init__(self, system: System):
        self.system = system
        self.right: PETSc.Vec | None = None

    def mult(self, matrix, x, y):
        self.system.multiply(x, y)

    def apply(self, pc, b, x):
        self.system.solve(b if self.right is None else self.right, x)


def read_options(snes: PETSc.SNES) -> int:
    """Give ``snes`` its options; returns how many steps a path has at most. PETSc.Error where one cannot be read."""
    snes.setOptionsPrefix(PREFIX)
    with_defaults(PREFIX, SNES_OPTIONS, snes.setFromOptions)
    return PETSc.Options(PREFIX).getInt(*PATH)


def _weakly(method):
    """A bound method that does not keep its object alive: Python's collector does not see what PETSc refers to."""
    weak = weakref.WeakMethod(method)
    return lambda *arguments: weak()(*arguments)  # type: ignore[misc]  # called while the object lives


class Newton:
    """Solves a System for given line loads, from its present state; tolerance: of forces and loads, over P."""

    def __init__(self, system: System, tolerance: float = FORCE_TOLERANCE):
        self.system, self._wanted = system, tolerance
        comm = system.problem.body.mesh.comm
        self.x, self._f = system.create_vector(), system.create_vector()
        shape = (self.x.getLocalSize(), None)
        self._operator = _Operator(system)
        jacobian = PETSc.Mat().createPython((shape, shape), self._operator, comm)
        jacobian.setUp()
        self.snes = PETSc.SNES().create(comm)
        self.snes.setFunction(_weakly(self._residual), self._f)
        self.snes.setJacobian(_weakly(self._linearise), jacobian)
        self.snes.setConvergenceTest(_weakly(self._test))
        self.snes.ksp.pc.setType(PETSc.PC.Type.PYTHON)
        self.snes.ksp.pc.setPythonContext(self._operator)
        self._most_followed = read_options(self.snes)
        self._polished = False
        self._last_force = self._least = np.inf
        self._best = self.x.copy()  # iterate with the least force residual
        self._scale, self._norms, self._tolerance, self._round_off = 1.0, (np.inf, np.inf), tolerance, 0.0
        self._states: np.ndarray | None = None
        self._changes: list[int] = []
        self._jumps = EdgeJumps(system.problem) if system.problem.friction else None
        self._may_jump = False
        self._imposed = system.create_vector()  # residual under imposed contact states
        self.last_steps = LastSteps()
        self._solved = None  # load of the last solve, if it converged

    def solve(self, load, predict=False, extrapolate=False, jump=False) -> NewtonResult:
        """Balance the line loads ``load`` (fem.load.Load), P > 0.

        predict: start with a step in which all points in contact stick; extrapolate: start from the line through the
        last two load steps; jump: let edges of contact and stick jump.
        """
        self._polished = False
        self._begin(load)
        if extrapolate:
            self.last_steps.extrapolate(load, self.x)
            self.system.start_elsewhere()
        self._may_jump = jump
        if jump:
            # new anchors make points slide that are to stick: the states of the last anchors are closer
            self._jumps.begin(load if extrapolate else None, self._states if self.has_solved(load) else None)
        self.x.copy(self._best)
        if predict:
            step = self.x.duplicate()
            with self.system.problem.safeguards.all_stick():
                self.system.residual(self.x, self._f)
                self.system.linearise(self.x)
                self.system.solve(self._f, step)
            self.x.axpy(-1.0, step)
        self._states, self._changes, self._least = None, [], np.inf
        try:
            self.snes.solve(None, self.x)
        except PETSc.Error as error:  # in which PETSc wraps whatever a callback raises, Ctrl-C too
            raise (error.__cause__ or error) from None
        code = self.snes.getConvergedReason()
        self.system.finish(self.x)
        converged = code > 0 and max(self._norms) <= 10 * ATTAINABLE  # whatever rule of PETSc's ended it
        self._solved = load if converged else None
        return NewtonResult(
            converged=converged,
            iterations=self.snes.getIterationNumber() + predict,
            residual=self._norms[0],
            reason="" if converged else _REASONS.get(code, f"PETSc ended it, SNES reason {code}"),
            tolerance=self._tolerance,
            changes=tuple(self._changes),
        )

    def follow(self, load) -> NewtonResult:
        """To balanced loads along the ``path`` from the best iterate of the last solve; ``solve`` is to judge."""
        self._begin(load)
        self._best.copy(self.x)
        self.system.start_elsewhere()

        def residual(x):
            self._residual(self.snes, x, self._f)
            return self._f, self._balanced()

        steps, arrived = follow(self.system, self.x, residual, load, self._most_followed)
        residual(self.x)
        self.system.finish(self.x)
        reason = "" if arrived else f"the path does not arrive in {steps} step{'s' * (steps != 1)}"
        return NewtonResult(arrived, steps, self._norms[0], reason, self._tolerance)

    def has_solved(self, load) -> bool:
        """Whether the last solve was one under ``load``, and converged."""
        return self._solved == load

    def accept(self, load):
        """Keep what was solved: a load step has ended. A dwell is no turn of the load: what led to it leads on."""
        if self.last_steps.stays(load):
            return
        if self._jumps is not None and self._states is not None:
            self._jumps.accept(load, self._states, self.last_steps.turned(load))
        self.last_steps.keep(load, self.x)

    def save(self) -> dict[str, np.ndarray]:
        """What the next solve takes from earlier load steps, as arrays by name, of rank 0.

        {} by the full method, whose unknowns no rank has alone: its next solve starts as where the load turns.
        """
        if not self.system.last_forces().size:
            return {}
        return self.last_steps.save() | (self._jumps.save() if self._jumps else {})

    def restore(self, saved: dict[str, np.ndarray]):
        """Go on from what ``save`` returned, which every rank has among ``saved``."""
        self.last_steps.restore(saved, self.x)
        if self._jumps:
            self._jumps.restore(saved)

    def balance(self, load) -> NewtonResult:
        """Whether the present state already balances the loads, by the same measure; nothing is moved."""
        self._begin(load)
        self._residual(self.snes, self.x, self._f)
        self._states = self.system.problem.terms.contact_states().astype(np.int8)
        balanced = self._balanced()
        reason = "" if balanced else "the state does not balance the loads"
        return NewtonResult(balanced, 0, self._norms[0], reason, self._tolerance)

    def _begin(self, load):
        self._scale = load.P
        self.system.problem.body.stretch(load.strain)
        self.system.begin(load, self.x)
        self._round_off = self.system.problem.terms.round_off() / self._scale
        self._tolerance = min(max(self._wanted, OVER_ROUND_OFF * self._round_off), ATTAINABLE)

    def _balanced(self):
        force, imbalance = self._norms
        return force <= self._tolerance and imbalance <= max(self._wanted, self._tolerance)

    def _residual(self, snes, x, f):
        force, imbalance = self.system.residual(x, f)
        self._norms = (force / self._scale, imbalance / self._scale)

    def _linearise(self, snes, x, jacobian, preconditioner):
        self._operator.right = imposed = None
        if self._may_jump and self._states is not None:
            imposed = self._jumps.after(self._states)
        if imposed is None:
            self.system.linearise(x)
        else:
            with self.system.problem.safeguards.imposed(imposed):
                self.system.residual(x, self._imposed)
                self.system.linearise(x)
            self._operator.right = self._imposed
        jacobian.assemble()

    def _count_changes(self):
        """Count the contact states that changed in the last iteration."""
        states, before = self.system.problem.terms.contact_states().astype(np.int8), self._states
        self._states = states
        if before is not None:
            changed = int(np.count_nonzero(states != before))
            self._changes.append(self.snes.comm.tompi4py().allreduce(changed))

    def _test(self, snes, iteration, norms):
        before = self._last_force
        self._last_force = self._norms[0]
        if self._last_force < self._least:
            self._least = self._last_force
            self.x.copy(self._best)
        self._count_changes()
        force, imbalance = self._norms
        reason = PETSc.SNES.ConvergedReason
        if not np.isfinite(norms[2]):
            return reason.DIVERGED_FNORM_NAN
        last = iteration >= snes.getTolerances()[3]
        if self._balanced():
            settled = max(SETTLED, OVER_ROUND_OFF * self._round_off) if self._changes[-1:] == [0] else SETTLED
            if force <= settled or iteration == 0 or last or self._polished:
                return reason.CONVERGED_FNORM_ABS
            self._polished = True
            return reason.CONVERGED_ITERATING
        # With the contact states at rest the problem is linear and one step ends it: what is left is round-off.
        at_rest = self._changes[-2:] == [0, 0] and force > before / 10
        if at_rest and force <= ATTAINABLE and imbalance <= 10 * ATTAINABLE:  # a sum of many forces
            self._tolerance = max(self._tolerance, force, imbalance / 10)
            return reason.CONVERGED_SNORM_RELATIVE
        if last:
            return reason.DIVERGED_MAX_IT
        return reason.CONVERGED_ITERATING


_REASONS = {
    PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN: "the residual is not a number (singular tangent)",
    PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT: "too many iterations",
    PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the linear solve failed",
    PETSc.SNES.ConvergedReason.DIVERGED_LINE_SEARCH: "the line search failed",
}
