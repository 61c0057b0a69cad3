"""One load increment of frictional contact on fixed nodes: Signorini's and Coulomb's conditions by active sets."""

from dataclasses import dataclass

import numpy as np

from .half_plane_operator import SurfaceOperator

MAX_ITERATIONS = 400
RETURN = 2  # nodes by which a stick zone grows in one iteration
ROUNDING = 1e-12, 1e-9  # of the largest pressure or displacement: violations below are rounding; once sets cycle


class ContactNotConverged(RuntimeError):
    """The active sets did not settle; the message says what was still changing."""


@dataclass(frozen=True)
class ContactSets:
    """Status of each node: in contact, or not; ``slipping`` is the sign of the traction where it slips, else 0."""

    closed: np.ndarray
    slipping: np.ndarray


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


@dataclass(frozen=True)
class Increment:
    """Data of an increment: the indenter's height at the nodes, u_x - delta_x at rest, mu, and the loads."""

    operator: SurfaceOperator
    height: np.ndarray
    rest: np.ndarray
    mu: float
    P: float
    Q: float

    def solve(self, sets: ContactSets) -> IncrementSolution:
        """Solution reached from the initial ``sets``.

        Each iteration solves the linear problem of the current sets, and then changes the status of every
        node that violates its conditions (a semismooth Newton step). Should the sets cycle, the violated node
        farthest to the right is changed alone (Murty's rule), which ends after finitely many steps if the matrix is
        a P-matrix; that of friction need not be one, hence the limit. Raises ContactNotConverged.
        """
        seen, cycling = set(), False
        for iteration in range(1, MAX_ITERATIONS + 1):
            solution = self._linear(sets, iteration)
            new = self._updated(solution, ROUNDING[cycling])
            changed = (new.closed != sets.closed) | (new.slipping != sets.slipping)
            if not changed.any():
                return solution
            key = new.closed.tobytes() + new.slipping.tobytes()
            cycling = cycling or key in seen
            seen.add(key)
            if cycling:
                only = np.arange(len(changed)) == np.flatnonzero(changed)[-1]
                new = ContactSets(
                    np.where(only, new.closed, sets.closed), np.where(only, new.slipping, sets.slipping)
                )
            sets = new
        raise ContactNotConverged(
            f"P = {self.P:g}, Q = {self.Q:g}: after {MAX_ITERATIONS} iterations {changed.sum()} nodes between "
            f"x = {self.operator.nodes[changed].min():g} and {self.operator.nodes[changed].max():g} "
            "still change between contact and gap, or stick and slip"
        )

    def _linear(self, sets, iteration):
        """Solution of fixed sets: unknown p in contact, q where it sticks, delta_x and delta_y."""
        op, n = self.operator, len(self.height)
        closed = np.flatnonzero(sets.closed)
        stick = np.flatnonzero(sets.closed & (sets.slipping == 0)) if self.mu else closed[:0]
        friction = self.mu * sets.slipping[closed]
        nc, ns = len(closed), len(stick)
        if nc == 0:
            raise ContactNotConverged(f"P = {self.P:g}, Q = {self.Q:g}: no node is in contact")
        if self.mu and ns == 0:
            raise ContactNotConverged(f"P = {self.P:g}, Q = {self.Q:g}: every node in contact slips")
        width = np.ptp(op.nodes)  # scales that make the rows of the system comparable
        stress = self.P / width
        length = np.abs(op.normal).sum(axis=1).max() * stress

        size = nc + ns + (2 if ns else 1)
        A, rhs = np.zeros((size, size)), np.zeros(size)
        cc, cs = np.ix_(closed, closed), np.ix_(closed, stick)
        A[:nc, :nc] = op.normal[cc] - op.coupling_q[cc] * friction
        A[:nc, nc : nc + ns] = -op.coupling_q[cs]
        A[:nc, nc + ns] = -length / stress
        rhs[:nc] = -self.height[closed]
        A[nc + ns, :nc] = op.weight[closed]
        rhs[nc + ns] = self.P
        if ns:
            sc, ss = np.ix_(stick, closed), np.ix_(stick, stick)
            A[nc : nc + ns, :nc] = op.coupling[sc] + op.tangential[sc] * friction
            A[nc : nc + ns, nc : nc + ns] = op.tangential[ss]
            A[nc : nc + ns, -1] = -length / stress
            rhs[nc : nc + ns] = self.rest[stick]
            A[-1, :nc] = op.weight_q[closed] * friction
            A[-1, nc : nc + ns] = op.weight_q[stick]
            rhs[-1] = self.Q
        A[: nc + ns] *= stress / length
        rhs[: nc + ns] /= length
        A[nc + ns :] /= width
        rhs[nc + ns :] /= self.P
        unknown = np.linalg.solve(A, rhs)

        p, q = np.zeros(n), np.zeros(n)
        p[closed] = unknown[:nc] * stress
        q[closed] = friction * p[closed]
        q[stick] = unknown[nc : nc + ns] * stress
        delta_y = unknown[nc + ns] * length
        delta_x = unknown[-1] * length if ns else 0.0
        u_x, u_y = op.displacement(p, q)
        gap = np.where(sets.closed, 0.0, self.height + u_y - delta_y)
        position = u_x - delta_x
        position[stick] = self.rest[stick]
        return IncrementSolution(op.nodes, p, q, gap, position, delta_x, delta_y, sets, iteration)

    def _updated(self, s, rounding):
        """Sets after Signorini's and Coulomb's conditions at every node."""
        p_rounding = rounding * s.pressure.max()
        u_rounding = rounding * np.ptp(self.height)
        closed = np.where(s.sets.closed, s.pressure > -p_rounding, s.gap < -u_rounding)
        if not self.mu:
            return ContactSets(closed, s.sets.slipping)
        was_slipping = s.sets.slipping
        limit = self.mu * np.maximum(s.pressure, 0.0) + p_rounding
        begins = np.where(np.abs(s.traction) > limit, np.sign(s.traction), 0.0)
        backwards = was_slipping * (s.position - self.rest) > u_rounding
        beside_stick = s.stuck.copy()
        for _ in range(RETURN):
            beside_stick[1:] |= beside_stick[:-1].copy()
            beside_stick[:-1] |= beside_stick[1:].copy()
        if (backwards & beside_stick).any():
            backwards &= beside_stick
        slipping = np.where(was_slipping == 0, begins, np.where(backwards, 0.0, was_slipping))
        free_motion = np.sign(s.position - self.rest)  # of a point that comes into contact
        slipping = np.where(s.sets.closed, slipping, -free_motion)
        slipping = np.where(closed, slipping, 0.0)
        if closed.any() and slipping[closed].all():  # |Q| < mu P: somewhere slip changes its sign
            slipping[np.where(closed, np.abs(s.position - self.rest), np.inf).argmin()] = 0.0
        return ContactSets(closed, slipping)
