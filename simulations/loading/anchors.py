"""Points that come to stick within an increment, and where they do.

As the contact grows, the edges of contact and of stick pass points one after the other, and each of them stops where
the surface is at that moment. Anchored where they were when the increment began they would all be too early, the
last the most: a sawtooth in the traction, a tooth an increment, which smaller increments only make finer. Instead they
are anchored on the curve that the edge has drawn.
"""

import numpy as np
from mpi4py import MPI

from forms.contact import CLOSED, OPEN

from ..fem.contact_problem import ContactProblem


class Newcomers:
    """Anchors the newcomers of a frictional problem."""

    def __init__(self, problem: ContactProblem):
        self._problem, self._comm = problem, problem.body.mesh.comm
        parts = self._comm.allgather((problem.points.x, problem.points.middle))
        x, cell = (np.concatenate(part) for part in zip(*parts))
        self._order = np.lexsort((cell, x))
        self._x = x[self._order]
        start = sum(len(part[0]) for part in parts[: self._comm.rank])
        self._mine = np.argsort(self._order)[start : start + len(parts[self._comm.rank][0])]

    def begin(self):
        """Keep the anchors with which an increment was solved."""
        self._start = self._problem.memory.save()
        self._moved = np.zeros(len(self._mine), dtype=bool)

    def anchor(self) -> bool:
        """Move the newcomers' anchors to where their edges are now thought to have passed; whether there are any."""
        memory = self._problem.memory
        local = memory.states_at_rest(), self._problem.terms.contact_states(), memory.rest_positions()
        places, positions = stops(self._x, *(np.concatenate(self._comm.allgather(v))[self._order] for v in local))
        self._moved = places[self._mine]
        memory.restore(self._start)
        memory.move_anchors(self._moved, positions[self._mine])
        return bool(np.any(places))

    def are_settled(self) -> bool:
        """Whether all points whose anchors were moved stick still: one that slides would do so from the wrong place."""
        stick = np.all(self._problem.terms.contact_states()[self._moved] == CLOSED)
        return self._comm.allreduce(bool(stick), MPI.LAND)


def stops(x, before, after, rest):
    """Which of the points x, in order, are newcomers (bool, (n,)), and where they stopped (n,).

    before, after: contact states; rest: where each point would be anchored now. The edge that passed a run of points
    that stick now is the point beyond it that does not: it is open, or slides. From there inwards those are newcomers
    that were open before, or slid the same way; a point that slid the other way stopped as the load turned back.
    """
    places, positions = np.zeros(len(x), dtype=bool), rest.copy()
    fresh = (before != CLOSED) & (after == CLOSED)
    fresh[[0, -1]] = False
    steps = np.diff(fresh.astype(int))
    for left, right in zip(np.flatnonzero(steps > 0), np.flatnonzero(steps < 0) + 1):  # the points next to the run
        run = np.arange(left + 1, right)
        if after[left] != CLOSED and after[right] != CLOSED:
            if np.all(before[run] == OPEN) and x[left] < 0 < x[right]:
                places[run], positions[run] = True, _first_contact(x[run], x[[left, right]], rest[[left, right]])
            continue
        for inner, outer, inwards in ((left, right, run[::-1]), (right, left, run)):
            passed = (before[inwards] == OPEN) | (before[inwards] == after[outer])
            new = inwards[: len(run) if passed.all() else np.argmin(passed)]
            if after[outer] != CLOSED and len(new):
                inner = new[-1] + np.sign(inner - outer)
                places[new], positions[new] = True, _drawn(x, after, rest, inner, outer)(x[new])
    return places, positions


def _first_contact(x, edges, rest):
    """Positions at x, between two edges that started from x = 0 on an indenter of curvature, like x |x|."""
    return np.where(x < 0, rest[0] * (x / edges[0]) ** 2, rest[1] * (x / edges[1]) ** 2)


def _drawn(x, after, rest, inner, outer):
    """Curve through the point that sticks already, the edge and, where it sticks too, a point as far inwards again."""
    behind = np.clip(np.searchsorted(x, 2 * x[inner] - x[outer]), 0, len(x) - 1)
    support = [inner, outer]
    if x[behind] != x[inner] and np.all(after[min(behind, inner) : max(behind, inner) + 1] == CLOSED):
        support.append(behind)
    return np.polynomial.Polynomial.fit(x[support], rest[support], len(support) - 1)
