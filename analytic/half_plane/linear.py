"""Linear problem of an increment whose nodes have a fixed status: in contact or not, stick or slip."""

from dataclasses import dataclass

import numpy as np

from .operator import SurfaceOperator


class ContactNotConverged(RuntimeError):
    """The contact problem was not solved; the message says what was still changing."""


@dataclass(frozen=True)
class ContactSets:
    """Status of each node: in contact, or not; ``slipping`` is the sign of the traction where it slips, else 0."""

    closed: np.ndarray
    slipping: np.ndarray

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
    iterations: int

    @property
    def stuck(self):
        """Nodes in contact that do not slip."""
        return self.sets.closed & (self.sets.slipping == 0)


class LinearProblem:
    """p in contact, q where it sticks, delta_x and delta_y for fixed sets and any number of data."""

    def __init__(self, operator: SurfaceOperator, mu: float, sets: ContactSets):
        self.operator, self.mu, self.sets = operator, mu, sets
        self._closed = np.flatnonzero(sets.closed)
        self._stick = np.flatnonzero(sets.closed & (sets.slipping == 0)) if mu else self._closed[:0]
        self._friction = mu * sets.slipping[self._closed]
        if len(self._closed) == 0:
            raise ContactNotConverged("no node is in contact")
        if mu and len(self._stick) == 0:
            raise ContactNotConverged("every node in contact slips")
        self._width = np.ptp(operator.nodes)  # with it, rows of the system are comparable
        self._compliance = np.abs(operator.normal).sum(axis=1).max()  # length over stress

    def _matrix(self):
        op, closed, stick, friction = self.operator, self._closed, self._stick, self._friction
        nc, ns = len(closed), len(stick)
        A = np.zeros((nc + ns + (2 if ns else 1),) * 2)
        cc, cs = np.ix_(closed, closed), np.ix_(closed, stick)
        A[:nc, :nc] = op.normal[cc] - op.coupling_q[cc] * friction
        A[:nc, nc : nc + ns] = -op.coupling_q[cs]
        A[:nc, nc + ns] = -self._compliance
        A[nc + ns, :nc] = op.weight[closed]
        if ns:
            sc, ss = np.ix_(stick, closed), np.ix_(stick, stick)
            A[nc : nc + ns, :nc] = op.coupling[sc] + op.tangential[sc] * friction
            A[nc : nc + ns, nc : nc + ns] = op.tangential[ss]
            A[nc : nc + ns, -1] = -self._compliance
            A[-1, :nc] = op.weight_q[closed] * friction
            A[-1, nc : nc + ns] = op.weight_q[stick]
        A[: nc + ns] /= self._compliance
        A[nc + ns :] /= self._width
        return A

    def solve(self, *data: Data, iterations=0) -> list[IncrementSolution]:
        """Solution for each of the ``data``; it is linear in them."""
        closed, stick = self._closed, self._stick
        nc, ns = len(closed), len(stick)
        rhs = np.zeros((nc + ns + (2 if ns else 1), len(data)))
        for column, d in zip(rhs.T, data, strict=True):
            column[:nc] = -d.height[closed] / self._compliance
            column[nc + ns] = d.P / self._width
            if ns:
                column[nc : nc + ns] = d.rest[stick] / self._compliance
                column[-1] = d.Q / self._width
        unknowns = np.linalg.solve(self._matrix(), rhs)
        return [self._solution(u, d, iterations) for u, d in zip(unknowns.T, data, strict=True)]

    def _solution(self, unknown, data, iterations):
        op, closed, stick = self.operator, self._closed, self._stick
        nc, ns = len(closed), len(stick)
        p, q = np.zeros(len(op.nodes)), np.zeros(len(op.nodes))
        p[closed] = unknown[:nc]
        q[closed] = self._friction * p[closed]
        q[stick] = unknown[nc : nc + ns]
        delta_y = unknown[nc + ns] * self._compliance
        delta_x = unknown[-1] * self._compliance if ns else 0.0
        u_x, u_y = op.displacement(p, q)
        gap = np.where(self.sets.closed, 0.0, data.height + u_y - delta_y)
        position = u_x - delta_x
        position[stick] = data.rest[stick]
        return IncrementSolution(op.nodes, p, q, gap, position, delta_x, delta_y, self.sets, iterations)
