"""Anchors of points that enter contact or come to stick within a load step, on the curve that the edges draw.

The anchor of such a point is its relative displacement s when an edge passed it, somewhere between the loads before
and after the step. Two relations give it from the states before and after:

* A point that is still open moves along s as it comes closer: ds = -r d(clearance), with a ratio r that hardly changes
  within a step (in uncoupled contact it is constant, alpha dQ/dP). One that enters is anchored at
  s_before + r clearance_before; r is measured on points that are open still.
* A point that slides comes to a smooth stop as the edge of stick passes it: after the stick edge has moved from c0 to
  c1 it has slid by B ((x - c0)^m - (x - c1)^m), m = (5 - k)/2, and where it sticks by B (x - c0)^m.

Both amplitudes depend on the state after the step, which depends on them: solve, measure, anchor, solve again.
"""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from forms.contact import CLOSED, OPEN

from ..fem.contact_problem import ContactProblem

NEAR, FAR = 0.25, 1.25
SETTLED = 1e-3
NEXT = 8  # points beside an edge whose displacement carries its discretisation error
REACH = 1.0  # amplitudes are measured up to this many edge motions beyond an edge


@dataclass(frozen=True)
class Surface:
    """Of the surface points sorted by x (n,): contact states, positions s (anchors where they stick), clearances."""

    states: np.ndarray
    s: np.ndarray
    clearance: np.ndarray


class Newcomers:
    """Anchors the newcomers of a frictional problem."""

    def __init__(self, problem: ContactProblem, k: float = 0.0):
        self._problem, self._comm, self.k = problem, problem.body.mesh.comm, k
        parts = self._comm.allgather((problem.points.x, problem.points.middle))
        x, cell = (np.concatenate(part) for part in zip(*parts))
        self._order = np.lexsort((cell, x))
        self._x = x[self._order]
        start = sum(len(part[0]) for part in parts[: self._comm.rank])
        self._amplitudes = {}
        self._mine = np.argsort(self._order)[start : start + len(parts[self._comm.rank][0])]

    def begin(self, clearance):
        """Keep the state before a step. clearance: of the surface points (m,), where the present one is not meant."""
        p = self._problem.memory
        local = p.states_at_rest(), p.anchors(), clearance
        self._before = Surface(*self._gathered(*local))
        self._amplitudes = {s: (Amplitude(r.value), Amplitude(B.value)) for s, (r, B) in self._amplitudes.items()}

    def predict(self):
        """Anchor open points where they will touch if they go on as in the step before."""
        if not self._amplitudes: return
        b = self._before
        r = np.where(self._x < np.mean(self._x[b.states != OPEN]) , self._amplitudes[-1][0].value, self._amplitudes[1][0].value)
        new = np.where(b.states == OPEN, b.s + r * b.clearance, b.s)
        self._problem.memory.move_anchors(np.ones(len(self._mine), bool), new[self._mine])

    def anchor(self, clearance) -> bool:
        """Anchor the newcomers anew; False where they are anchored so already, to SETTLED of how far they moved."""
        p = self._problem.memory
        after = Surface(*self._gathered(self._problem.terms.contact_states(), p.rest_positions(), clearance))
        (old,) = self._gathered(p.anchors())
        new = drawn(self._x, self._before, after, self.k, self._amplitudes)
        self._after = after
        touching = after.states != OPEN
        moved = np.abs(new - self._before.s)[touching].max()
        self.change = np.abs(new - old)[touching].max() / moved if moved else 0.0
        if self.change < SETTLED:
            return False
        p.move_anchors(np.ones(len(self._mine), bool), new[self._mine])
        return True

    def finish(self):
        """Open points beside the edges, after a step has ended: they come closer as those further out."""
        (anchors,) = self._gathered(self._problem.memory.anchors())
        b, a = self._before, self._after
        touching = np.flatnonzero(a.states != OPEN)
        for side, beyond in ((-1, np.arange(touching[0])[::-1]), (1, np.arange(touching[-1] + 1, len(self._x)))):
            beyond = beyond[:NEXT]
            r = self._amplitudes[side][0]
            closing = (b.states[beyond] == OPEN) & (a.clearance[beyond] < b.clearance[beyond])
            if r.measured:
                i = beyond[closing]
                anchors[i] = b.s[i] + r.value * (b.clearance[i] - a.clearance[i])
        self._problem.memory.move_anchors(np.ones(len(self._mine), bool), anchors[self._mine])

    def _gathered(self, *local):
        return [np.concatenate(self._comm.allgather(values))[self._order] for values in local]


def drawn(x, before, after, k, amplitudes):
    """Anchors (n,) of all points: those before the step but where edges passed.

    amplitudes: r and B of each edge by its side and number, from the last pass; renewed.
    """
    anchors = before.s.copy()
    touching = np.flatnonzero(after.states != OPEN)
    first, end = touching[0], touching[-1] + 1
    for side in (-1, 1):
        order = np.arange(first, len(x)) if side > 0 else np.arange(end)[::-1]
        edge = Edge(side * x[order], _at(before, order), _at(after, order), end - first, k)
        r, B = amplitudes.setdefault(side, (Amplitude(), Amplitude()))
        edge.measure(r, B)
        where, positions = edge.positions(r.value, B.value)
        anchors[order[where]] = positions
    return anchors


class Amplitude:
    """A number that equals what is measured with it, found by the secant method."""

    def __init__(self, value=0.0):
        self.value, self._tried = value, []
    @property
    def measured(self): return bool(self._tried)

    def improve(self, measured):
        self._tried.append((self.value, measured - self.value))
        (v1, f1) = self._tried[-1]
        if len(self._tried) == 1:
            self.value = measured
            return
        (v0, f0) = self._tried[-2]
        self.value = v1 - f1 * (v1 - v0) / (f1 - f0) if f1 != f0 else measured

    def __repr__(self): return f"{self.value:.5f}"


def _at(surface, order):
    return Surface(surface.states[order], surface.s[order], surface.clearance[order])


class Edge:
    """One side of a contact: points in order from the other side outwards, y increasing; the first n are in contact."""

    def __init__(self, y, before: Surface, after: Surface, n: int, k: float):
        self.y, self.before, self.after, self.n = y, before, after, n
        self.open_exponent, self.slip_exponent = (3 - k) / 2, (5 - k) / 2
        entered = before.states[:n] == OPEN
        self.first_contact = bool(entered.all())
        if self.first_contact:
            self.entered = int(np.argmin(before.clearance[:n]))
            self.e0 = y[self.entered]
        else:
            self.entered = n - _run_length(entered[::-1])
            self.e0 = self._between(self.entered)
        self.e1 = self._between(n)
        b, a = before.states[:n], after.states[:n]
        self.slides = n - _run_length((a == a[n - 1])[::-1]) if a[n - 1] != CLOSED else n
        self.sticks = self.slides
        if self.slides < n:
            new = (a == CLOSED) & ((b == a[n - 1]) | (b == OPEN))
            self.sticks -= _run_length(new[: self.slides][::-1])
            if self.first_contact:
                self.sticks = min(max(self.sticks, self.entered), self.slides)
        self.c0 = self.e0 if self.first_contact else self._between(self.sticks)
        self.c1 = self._between(self.slides)

    def _between(self, i):
        i = min(max(i, 1), len(self.y) - 1)
        return (self.y[i - 1] + self.y[i]) / 2

    def measure(self, r, B):
        """The amplitudes r, B from the state after the step, which was found with these."""
        if self.entered < self.n:
            measured = self._ratio()
            if measured is not None: r.improve(measured)

    def _ratio(self):
        b, a = self.before, self.after
        beyond = np.arange(self.n, len(self.y))
        beyond = beyond[: _run_length((b.states[beyond] == OPEN) & (a.states[beyond] == OPEN))]
        motion = self.e1 - self.e0
        d = self.y[beyond] - self.e1
        start = min(max(np.searchsorted(d, NEAR * motion), NEXT), len(d) - 1)
        stop = max(np.searchsorted(d, FAR * motion), start + NEXT)
        beyond = beyond[start:stop]
        closed = b.clearance[beyond] - a.clearance[beyond]
        if not np.all(closed > 0):
            return None
        return float(np.mean((a.s[beyond] - b.s[beyond]) / closed))

    def shape(self, y, c):
        """What a point slides after the stick edge was at c, over B."""
        if self.first_contact and c == self.e0:
            return self.before.clearance
        return np.maximum(y - c, 0.0) ** self.slip_exponent

    def _slip_defect(self, r, B):
        b, a, motion = self.before, self.after, self.c1 - self.c0
        d = self.y[self.slides : self.n] - self.c1
        count = max(np.searchsorted(d, REACH * motion), 3)
        beyond = np.arange(self.slides, self.n)[:count]
        d = d[:count]
        if len(d) < 2:
            return 0.0
        slid = a.s[beyond] - b.s[beyond] - r * b.clearance[beyond]
        if self.first_contact:
            scale = self.before.clearance[beyond]
            measured = slid / scale
            found = np.linalg.lstsq(np.stack([scale, d**self.slip_exponent], 1), slid, rcond=None)[0]
            return found[0] - B
        measured = slid / (self.shape(self.y, self.c0) - self.shape(self.y, self.c1))[beyond]
        return _fit(measured - B, _share(d, motion, self.slip_exponent), d / motion)

    def positions(self, r, B):
        """Which points are to be anchored anew, and where."""
        b, a = self.before, self.after
        where = np.arange(self.n)
        s = b.s + r * b.clearance
        s = s[: self.n]
        slid = (B * self.shape(self.y, self.c0))[: self.n]
        stuck = np.arange(self.sticks, self.slides)
        s[stuck] += slid[stuck]
        sliding = np.arange(self.slides, self.n)
        moved = a.s[sliding] - s[sliding]
        s[sliding] += np.where(moved * slid[sliding] > 0, np.sign(moved) * np.minimum(abs(moved), abs(slid[sliding])), 0)
        chosen = where >= min(self.entered, self.sticks)
        return where[chosen], s[chosen]


def _share(d, motion, exponent):
    """How much of a wrong amplitude is seen at the distances d (n,) beyond an edge that has moved by ``motion``."""
    d = np.maximum(d, 1e-12 * motion)
    return d ** (exponent - 1) * motion * exponent / ((d + motion) ** exponent - d**exponent)


def _fit(values, share, distance):
    """Amplitude A with values = share A (1 + b distance), by least squares."""
    if len(values) < 3:
        return float(share @ values / (share @ share))
    return float(np.linalg.lstsq(np.stack([share, distance * share], 1), values, rcond=None)[0][0])


def _run_length(mask):
    """Number of leading True."""
    mask = np.asarray(mask)
    return len(mask) if mask.all() else int(np.argmin(mask))
