"""The point that stands still while every other point in contact slides, forward on one side of it and backward on
the other.

Such a stick zone is narrower than a facet. An iterate in which all points slide leaves the cylinder free to move: the
tangent is singular. There one point is held instead, the one that slides least; if it takes more than its limit of
friction it slides after all, and the next one on the far side of it is held.
"""

import numpy as np
from mpi4py import MPI

from .problem import BACKWARD, CLOSED, FORWARD, ContactProblem

SAME = 1e-12  # of the contact half-width: points this close are one node's


class HeldPoint:
    """Holds one point of a frictional problem while nothing else does."""

    def __init__(self, problem: ContactProblem):
        self._problem, self._comm = problem, problem.body.mesh.comm
        self._x = problem.surface_abscissae()[0]
        self._held: float | None = None  # abscissa

    def update(self) -> bool:
        """Hold a point if all in contact slide at the present iterate, and tell whether one is."""
        states = self._problem.contact_states()
        sliding = (states == FORWARD) | (states == BACKWARD)
        sticks, slides = np.any(self._comm.allgather((np.any(states == CLOSED), np.any(sliding))), axis=0)
        if sticks or not slides:
            return False
        excess = np.where(sliding & (states != self._way(states)), self._problem.slip_beyond_limit(), np.inf)
        if self._comm.allreduce(excess.min(initial=np.inf), MPI.MIN) == np.inf:
            return False
        nearest = [(excess[i], self._x[i]) for i in np.argsort(excess)[:1]]
        _, self._held = min(sum(self._comm.allgather(nearest), []))
        self._problem.hold(self._at_held())
        return True

    def release(self):
        """Hold none."""
        self._held = None

    def _at_held(self):
        return np.abs(self._x - self._held) <= SAME if self._held is not None else np.zeros(len(self._x), bool)

    def _way(self, states) -> int:
        """The contact state of the point held before; -1 if there was none."""
        return self._comm.allreduce(int(states[self._at_held()].max(initial=-1)), MPI.MAX)
