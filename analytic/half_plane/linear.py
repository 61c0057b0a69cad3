"""Linear problems of an increment whose nodes have a fixed status: in contact or not, stick or slip.

From one to the next few nodes change their status, and with it their equations. So one problem is factorised, the base;
others are solved as that one with some equations replaced (Woodbury), and refined once.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from ..checks import ContactNotConverged
from .operator import SurfaceOperator


@dataclass(frozen=True)
class ContactSets:
    """Status of each node: in contact, or not; ``slipping`` is the sign of the traction where it slips, else 0."""

    closed: np.ndarray
    slipping: np.ndarray

    @property
    def stuck(self):
        """Nodes in contact that do not slip."""
        return self.closed & (self.slipping == 0)

    def same(self, other):
        """Nodes whose status is that of ``other``."""
        return (self.closed == other.closed) & (self.slipping == other.slipping)


@dataclass(frozen=True)
class Data:
    """What an increment is given: the indenter's height and u_x - delta_x at rest at the nodes [length]; the loads."""

    height: np.ndarray
    rest: np.ndarray
    P: float
    Q: float

    def __sub__(self, other):
        return Data(self.height - other.height, self.rest - other.rest, self.P - other.P, self.Q - other.Q)


@dataclass(frozen=True)
class IncrementSolution:
    """Tractions at the nodes [stress], rigid displacements of the indenter [length], and what follows."""

    x: np.ndarray
    pressure: np.ndarray
    traction: np.ndarray
    gap: np.ndarray
    position: np.ndarray  # u_x - delta_x
    delta_x: float
    delta_y: float
    sets: ContactSets


MANY = 0.15  # share of equations replaced beyond which another problem is the base
BASE_RESIDUAL = 1e-13  # residual over the largest traction, beyond which the base was no good for a problem


class LinearProblems:
    """p in contact, q where it sticks, delta_x and delta_y for fixed sets and any number of data."""

    def __init__(self, operator: SurfaceOperator, mu: float):
        self.operator, self.mu = operator, mu
        self._width = np.ptp(operator.nodes)  # with it, equations are comparable
        self._unit = np.abs(operator.normal).sum(axis=1).max()  # compliance, length over stress
        self._base: _Base | None = None

    def solve(self, sets: ContactSets, *data: Data) -> list[IncrementSolution]:
        """Solution for each of the ``data``; it is linear in them."""
        stick = self._stick(sets)
        if not sets.closed.any():
            raise ContactNotConverged("no node is in contact")
        if self.mu and not stick.any():
            raise ContactNotConverged("every node in contact slips")
        n = len(stick)
        right = np.zeros((2 * n + 2, len(data)))
        for column, d in zip(right.T, data, strict=True):
            column[:n] = np.where(sets.closed, -d.height / self._unit, 0.0)
            column[n:-2] = np.where(stick, d.rest / self._unit, 0.0)
            column[-2:] = d.P / self._width, d.Q / self._width if self.mu else 0.0
        unknowns = self._solved(sets, right)
        return [self._solution(sets, stick, u, d) for u, d in zip(unknowns.T, data, strict=True)]

    def _stick(self, sets):
        return sets.stuck & (self.mu > 0)

    def _solved(self, sets, right):
        """Unknowns (2n + 2, m), from the base or, where too much has changed since, from a new one."""
        base = self._base
        if base is not None:
            rows = base.other_rows(sets)
            if not len(rows):
                return base.solve(right)
            if len(np.union1d(rows, base.rows)) <= MANY * len(right):
                unknowns = self._replaced(sets, rows, right)
                unknowns += self._replaced(sets, rows, self._rest(sets, unknowns, right))
                if np.all(np.abs(self._rest(sets, unknowns, right)) <= BASE_RESIDUAL * np.abs(unknowns).max(axis=0)):
                    return unknowns
        self._base = _Base(self.operator, self.mu, sets, self._stick(sets), self._unit, self._width)
        return self._base.solve(right)

    def _replaced(self, sets, rows, right):
        """The base's solution with its equations ``rows`` replaced by those of other ``sets``; nan if singular."""
        n, others = len(sets.closed), right.copy()
        others[rows] = 0.0
        found, columns = self._base.solve(others), self._base.columns(rows)
        nodes = np.unique(rows % n)
        left = self._left(sets, np.hstack([found, columns]), nodes)
        left = left[np.searchsorted(nodes, rows % n) + len(nodes) * (rows >= n)]
        m = right.shape[1]
        _, _, share, info = lapack.dgesv(left[:, m:], right[rows] - left[:, :m])
        return found + columns @ share if info == 0 else np.full_like(found, np.nan)

    def _rest(self, sets, unknowns, right):
        """What is left of the right-hand sides."""
        return right - np.vstack([self._left(sets, unknowns, slice(None)), self._base.sums(unknowns)])

    def _left(self, sets, unknowns, nodes):
        """Left-hand sides (2c, m) of the equations of ``nodes``."""
        op, n = self.operator, len(sets.closed)
        p, q, delta_y, delta_x = unknowns[:n], unknowns[n:-2], unknowns[-2], unknowns[-1]
        gap = (op.normal[nodes] @ p - op.coupling_q[nodes] @ q) / self._unit - delta_y
        position = (op.tangential[nodes] @ q + op.coupling[nodes] @ p) / self._unit - delta_x
        friction = self.mu * sets.slipping[nodes, None] * p[nodes]
        gap = np.where(sets.closed[nodes, None], gap, p[nodes])
        return np.vstack([gap, np.where(self._stick(sets)[nodes, None], position, q[nodes] - friction)])

    def _solution(self, sets, stick, unknown, data):
        op, n = self.operator, len(stick)
        p = np.where(sets.closed, unknown[:n], 0.0)
        q = np.where(stick, unknown[n:-2], self.mu * sets.slipping * p)
        delta_y, delta_x = unknown[-2:] * self._unit
        u_x, u_y = op.displacement(p, q)
        gap = np.where(sets.closed, 0.0, data.height + u_y - delta_y)
        position = u_x - delta_x
        position[stick] = data.rest[stick]
        return IncrementSolution(op.nodes, p, q, gap, position, delta_x, delta_y, sets)


class _Base:
    """A factorised problem in 2n + 2 unknowns and equations: p, q of every node, delta_y and delta_x over ``unit``.

    Equations of a node: gap zero, or p = 0 where it is open; position that at rest, or q = 0 where it is open, or q as
    friction where it slips. Only p in contact, q in stick and the motions are factorised. rows: equations on whose unit
    right-hand side it was solved.
    """

    def __init__(self, operator: SurfaceOperator, mu: float, sets: ContactSets, stick, unit: float, width: float):
        self._operator, self._sets, self._unit, self._width = operator, sets, unit, width
        self._closed, self._stick = np.flatnonzero(sets.closed), np.flatnonzero(stick)
        self._friction = mu * sets.slipping[self._closed]
        self._lu, self._pivots, info = lapack.dgetrf(self._matrix(), overwrite_a=True)
        if info:
            raise ContactNotConverged("the equations of contact are singular")
        self.rows = np.zeros(0, dtype=int)
        self._columns = np.zeros((2 * len(stick) + 2, 0))

    def other_rows(self, sets: ContactSets) -> np.ndarray:
        """Equations that are others with ``sets``."""
        same = self._sets.same(sets)
        return np.concatenate([np.flatnonzero(self._sets.closed != sets.closed), len(same) + np.flatnonzero(~same)])

    def sums(self, unknowns: np.ndarray) -> np.ndarray:
        """Left-hand sides (2, m) of the last two equations: P and Q over the width; without stick, delta_x is zero."""
        n, op = len(self._sets.closed), self._operator
        P, Q = op.weight @ unknowns[:n] / self._width, op.weight_q @ unknowns[n:-2] / self._width
        return np.vstack([P, Q if len(self._stick) else unknowns[-1]])

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solutions (2n + 2, m) for right-hand sides."""
        op, closed, stick, n = self._operator, self._closed, self._stick, len(self._sets.closed)
        nc, ns = len(closed), len(stick)
        known = right.copy()
        known[closed] = known[n + stick] = 0.0
        reduced = np.empty((len(self._lu), right.shape[1]))
        u_x, u_y = op.displacement(known[:n], known[n:-2]) if known[:-2].any() else (known, known)
        reduced[:nc] = right[closed] - u_y[closed] / self._unit
        reduced[nc : nc + ns] = right[n + stick] - u_x[stick] / self._unit
        reduced[nc + ns :] = (right[-2:] - self.sums(known))[: 2 if ns else 1]
        found, _ = lapack.dgetrs(self._lu, self._pivots, reduced, overwrite_b=True)
        known[closed] = found[:nc]
        known[n + closed] += self._friction[:, None] * found[:nc]
        known[n + stick] = found[nc : nc + ns]
        known[2 * n : 2 * n + len(found) - nc - ns] = found[nc + ns :]
        return known

    def columns(self, rows: np.ndarray) -> np.ndarray:
        """Solutions (2n + 2, r) for a unit on the right-hand side of one equation each."""
        missing = np.setdiff1d(rows, self.rows)
        if len(missing):
            unit = np.zeros((len(self._columns), len(missing)))
            unit[missing, np.arange(len(missing))] = 1.0
            self.rows = np.concatenate([self.rows, missing])
            self._columns = np.hstack([self._columns, self.solve(unit)])
        order = np.argsort(self.rows)
        return self._columns[:, order[np.searchsorted(self.rows, rows, sorter=order)]]

    def _matrix(self):
        op, closed, stick, friction = self._operator, self._closed, self._stick, self._friction
        nc, ns = len(closed), len(stick)
        A = np.zeros((nc + ns + (2 if ns else 1),) * 2, order="F")
        cc, cs = np.ix_(closed, closed), np.ix_(closed, stick)
        A[:nc, :nc] = op.normal[cc] - op.coupling_q[cc] * friction
        A[:nc, nc : nc + ns] = -op.coupling_q[cs]
        A[:nc, nc + ns] = -self._unit
        A[nc + ns, :nc] = op.weight[closed]
        if ns:
            sc, ss = np.ix_(stick, closed), np.ix_(stick, stick)
            A[nc : nc + ns, :nc] = op.coupling[sc] + op.tangential[sc] * friction
            A[nc : nc + ns, nc : nc + ns] = op.tangential[ss]
            A[nc : nc + ns, -1] = -self._unit
            A[-1, :nc] = op.weight_q[closed] * friction
            A[-1, nc : nc + ns] = op.weight_q[stick]
        A[: nc + ns] /= self._unit
        A[nc + ns :] /= self._width
        return A
