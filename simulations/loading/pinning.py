"""The point that stands still while every other point in contact slides, forward on one side of it and backward on
the other.

Such a stick zone is narrower than a facet. An iterate in which all points slide leaves the cylinder free to move: the
tangent is singular. There one point is held instead, the one that slides least. If it would take more than its limit
of friction it slides after all, and held is the one that slides least of those that slide the other way, or of the
others where all go one way.
"""

import numpy as np
from mpi4py import MPI

from forms.contact import BACKWARD, CLOSED, FORWARD

from ..fem.contact_problem import ContactProblem

SAME = 1e-12  # of the contact half-width: points this close are one node's


class HeldPoint:
    """Holds one point of a frictional problem while nothing else does."""

    def __init__(self, problem: ContactProblem):
        self._problem, self._comm = problem, problem.body.mesh.comm
        self._x = problem.points.x
        self._held: float | None = None  # abscissa

    def update(self) -> bool:
        """Hold a point if all in contact slide at the present iterate, and tell whether one is held anew."""
        if self._problem.safeguards.is_predicting:
            return False
        states = self._problem.terms.contact_states()
        sliding = (states == FORWARD) | (states == BACKWARD)
        state = self._state_of_held(states)
        sticks, slides = np.any(self._comm.allgather((np.any(states == CLOSED), np.any(sliding))), axis=0)
        if sticks and state != CLOSED:  # others do
            self.release()
        if sticks or not slides:
            return False
        found = self._least(sliding & (states != state))
        self._held = self._least(sliding & ~self._at_held()) if found is None else found
        self._problem.safeguards.pin(self._at_held())
        return self._held is not None

    def release(self):
        """Forget which point was held."""
        self._held = None

    def _least(self, among) -> float | None:
        """x of the point that slides least among those (bool (m,)) of all ranks; None without any."""
        beyond = np.where(among, self._problem.safeguards.slip_beyond_limit(), np.inf)
        least = [(beyond[i], self._x[i]) for i in np.argsort(beyond)[:1] if among[i]]
        return min(sum(self._comm.allgather(least), []), default=(0.0, None))[1]

    def _at_held(self):
        return np.abs(self._x - self._held) <= SAME if self._held is not None else np.zeros(len(self._x), bool)

    def _state_of_held(self, states) -> int:
        """The contact state of the point held before; -1 if there was none."""
        return self._comm.allreduce(int(states[self._at_held()].max(initial=-1)), MPI.MAX)
