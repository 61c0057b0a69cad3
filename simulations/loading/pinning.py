"""Pins one point of the surface when the stick zone is narrower than a facet, so that the tangent stays regular.

An iterate in which all points slide leaves the indenter free to move: the tangent is singular. There the point that
slides least is pinned, which means that it sticks whatever its traction. Should its traction exceed the limit of
friction it is let go, and pinned is the one that slides least of those that slide the other way, or of all others
where all slide the same way.
"""

import numpy as np
from mpi4py import MPI

from forms.contact import BACKWARD, CLOSED, FORWARD

from ..fem.contact_problem import ContactProblem

SAME = 1e-12  # of the contact half-width: points this close are one node's


class PinnedPoint:
    """The pinned point of a frictional problem; none at first."""

    def __init__(self, problem: ContactProblem):
        self._problem, self._comm = problem, problem.body.mesh.comm
        self._x = problem.points.x
        self._pinned: float | None = None  # abscissa

    def update(self) -> bool:
        """Pin a point if all in contact slide at the present iterate; whether one was pinned anew."""
        if self._problem.safeguards.is_predicting:
            return False
        states = self._problem.terms.contact_states()
        sliding = (states == FORWARD) | (states == BACKWARD)
        state = self._state_of_pinned(states)
        sticks, slides = np.any(self._comm.allgather((np.any(states == CLOSED), np.any(sliding))), axis=0)
        if sticks and state != CLOSED:  # others do
            self.release()
        if sticks or not slides:
            return False
        found = self._least(sliding & (states != state))
        self._pinned = self._least(sliding & ~self._at_pinned()) if found is None else found
        self._problem.safeguards.pin(self._at_pinned())
        return self._pinned is not None

    def release(self):
        """Forget which point was pinned."""
        self._pinned = None

    def _least(self, among) -> float | None:
        """x of the point that slides least among those (bool (m,)) of all ranks; None without any."""
        beyond = np.where(among, self._problem.safeguards.slip_beyond_limit(), np.inf)
        least = [(beyond[i], self._x[i]) for i in np.argsort(beyond)[:1] if among[i]]
        return min(sum(self._comm.allgather(least), []), default=(0.0, None))[1]

    def _at_pinned(self):
        return np.abs(self._x - self._pinned) <= SAME if self._pinned is not None else np.zeros(len(self._x), bool)

    def _state_of_pinned(self, states) -> int:
        """The contact state of the point pinned before; -1 if there was none."""
        return self._comm.allreduce(int(states[self._at_pinned()].max(initial=-1)), MPI.MAX)
