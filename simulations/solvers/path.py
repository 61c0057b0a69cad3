"""Newton's steps, each cut where the first point changes its contact state: a path that ends at the solution.

While no point changes its state the equations are linear. So along a step the residual shrinks on a line, until a point
opens, closes, sticks or slides. Its state changes, and the next step is that of the new states. Where the determinant
of the tangent changes its sign the path turns round for a while. It visits no states twice, and so does not cycle
(Katzenelson, Bell System Technical Journal 44, 1965, 1605; Chien and Kuh, IEEE Transactions on Circuits and Systems 23,
1976, 305). It takes a step for each change of state, and is short where it begins near the solution. It may lead away,
not to the solution, where contact terms are not stable or the start is far off.

Where all points slide the indenter is free to move aside and the tangent is singular. It goes to where friction carries
the load, so that some of the points stick. If none sticks there either, as between two nodes in the middle of a
symmetric contact, it stays there for a step.
"""

from collections.abc import Callable

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.optimize import brentq

from forms.contact import CLOSED, OPEN, X, Y

from ..fem.load import Load
from .system import System

FIXED = 1e-9, 200  # of the way on which a point sticks: where the indenter is fixed; halvings that take it there
BEYOND = 1e-6, 1e-9  # how much further than to a change a step goes, past round-off: of its length, and of a whole step

Residual = Callable[[PETSc.Vec], tuple[PETSc.Vec, bool]]


def follow(system: System, x: PETSc.Vec, residual: Residual, load: Load, most: int) -> tuple[int, bool]:
    """Lead ``x`` along the path to ``load``; how many steps it took, and whether it arrived.

    residual: renews the fields at an x; returns the residual there, and whether loads and forces balance; most: steps.
    """
    terms, comm = system.problem.terms, system.problem.body.mesh.comm
    step, end = x.duplicate(), x.duplicate()
    direction, whole, free = 1.0, False, False
    entered: tuple[np.ndarray, int] | None = None  # the condition that the last step broke, on the rank of its point
    for number in range(most):
        f, balanced = residual(x)
        if balanced:
            return number, True
        trials, conditions = terms.trials(), _conditions(terms.contact_states(), system.problem.mu)
        system.linearise(x)
        system.solve(f, step)
        if free and not _is_finite(step, comm):
            system.solve(f, step, fixed=True)
        if not _is_finite(step, comm):  # all points slide
            if free or not system.problem.friction or not _fix_indenter(system, x, residual, load.Q):
                return number, False
            free, entered = True, None
            continue
        free = False
        end.waxpy(-1.0, step, x)
        residual(end)
        change = terms.trials() - trials
        # what the last step broke goes on to break
        if comm.allreduce(direction * entered[0] @ change[:, entered[1]] if entered else 0.0) > 0.0:
            direction = -direction
        length, entered = _first_change(conditions, trials, direction * change)
        shortest, rank = comm.allreduce((length, comm.rank), MPI.MINLOC)
        entered = entered if comm.rank == rank else None
        length = shortest * (1.0 + BEYOND[0]) + BEYOND[1]
        if direction > 0 and length >= 1.0:
            x.axpy(-1.0, step)
            if whole:  # nothing changes any more: round-off is left
                return number + 1, True
            whole, entered = True, None
            continue
        if not np.isfinite(shortest):
            return number, False
        whole = False
        x.axpy(-direction * length, step)
    return most, False


def _is_finite(vector, comm) -> bool:
    # not by the norm, which PETSc keeps: of a vector on rank 0 the others do not see that it has changed
    return comm.allreduce(bool(np.all(np.isfinite(vector.array_r))), MPI.LAND)


def _fix_indenter(system, x, residual, Q) -> bool:
    """Move the indenter, free where all points slide, to where friction carries Q; whether there is such a place."""
    terms, comm = system.problem.terms, system.problem.body.mesh.comm

    def at(distance):
        moved = x.copy()
        system.move_indenter(moved, distance)
        residual(moved)
        return moved

    def excess(distance):
        at(distance)
        return comm.allreduce(terms.nodal_forces(X).sum()) - Q

    trials = terms.trials()
    at(1.0)
    stiffness = np.abs(terms.trials()[X] - trials[X])
    limit = system.problem.mu * np.maximum(trials[Y], 0.0)
    reach = comm.allreduce(float(np.max((np.abs(trials[X]) + limit) / stiffness, initial=0.0)), MPI.MAX)
    within = comm.allreduce(float(np.max(limit / stiffness, initial=0.0)), MPI.MAX)
    if not excess(-reach) * excess(reach) < 0.0:
        return False
    share, halvings = FIXED
    at(brentq(excess, -reach, reach, xtol=share * within, maxiter=halvings)).copy(x)
    return True


def _conditions(states: np.ndarray, mu: float) -> np.ndarray:
    """Factors (3, 2, m) of trial traction and pressure in what is positive while states (m,) last; zero for none."""
    factors = np.zeros((3, 2, len(states)))
    factors[0, Y] = np.where(states == OPEN, -1.0, 1.0)
    slides = np.where(states == OPEN, 0.0, states - CLOSED)
    sticks = states == CLOSED
    factors[1, X] = np.where(sticks, -1.0, slides)
    factors[1, Y] = np.where(sticks, mu, -mu * np.abs(slides))
    factors[2, X], factors[2, Y] = sticks, mu * sticks
    return factors


def _first_change(conditions, trials, change) -> tuple[float, tuple[np.ndarray, int] | None]:
    """Share of a step at which a condition is broken, infinite if none is, and its factors (2,) and point."""
    value = np.maximum(np.sum(conditions * trials, axis=1), 0.0)
    rate = -np.sum(conditions * change, axis=1)
    share = np.where(rate > 0.0, value / np.where(rate > 0.0, rate, 1.0), np.inf)
    if not share.size:
        return np.inf, None
    which, point = np.unravel_index(share.argmin(), share.shape)
    return float(share[which, point]), (conditions[which, :, point], int(point))
