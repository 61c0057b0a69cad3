"""One load increment of frictional contact on fixed nodes: Signorini's and Coulomb's conditions by active sets."""

from dataclasses import dataclass

import numpy as np

from ..checks import ContactNotConverged
from .linear import ContactSets, Data, IncrementSolution, LinearProblems
from .operator import SurfaceOperator
from .path import followed, near, sticking

MAX_ITERATIONS = 60  # of the semismooth Newton method
RETURN = 2  # nodes by which a stick zone grows in one iteration
ROUNDING = 1e-12, 1e-9  # of the largest pressure or displacement: violations below are rounding; after the path


@dataclass(frozen=True)
class Increment:
    """An increment with its data and the coefficient of friction."""

    operator: SurfaceOperator
    mu: float
    data: Data

    def solve(self, sets: ContactSets) -> IncrementSolution:
        """Solution reached from the initial ``sets``.

        Each iteration solves the linear problem of the current sets, and then changes the status of every
        node that violates its conditions (a semismooth Newton step). Should the sets cycle, a path of
        solutions is followed from the sets reached, which ends. Raises ContactNotConverged.
        """
        seen, problems = set(), LinearProblems(self.operator, self.mu)
        try:
            for _ in range(MAX_ITERATIONS):
                (solution,) = problems.solve(sets, self.data)
                new = self._updated(solution, ROUNDING[0])
                changed = self._changed(solution, new, ROUNDING[0])
                if not changed.any():
                    return solution
                if new.same(sets).all():
                    break
                key = new.closed.tobytes() + new.slipping.tobytes()
                if key in seen:
                    break
                seen.add(key)
                sets = new
            solution = self._followed(problems, solution)
            changed = self._changed(solution, self._updated(solution, ROUNDING[1]), ROUNDING[1])
            if changed.any():
                x = self.operator.nodes[changed]
                raise ContactNotConverged(
                    f"{changed.sum()} nodes between x = {x.min():g} and {x.max():g} still change between contact and "
                    "gap, or stick and slip"
                )
            return solution
        except ContactNotConverged as failure:
            raise ContactNotConverged(f"P = {self.data.P:g}, Q = {self.data.Q:g}: {failure}") from None

    def _followed(self, problems, guess):
        """Solution at the end of a path: from the ``guess``, or from a state where all sticks if that path fails."""
        try:
            return followed(problems, self.data, near(self.operator, self.mu, self.data, guess))
        except ContactNotConverged:
            return followed(problems, self.data, sticking(self.operator, self.data, guess))

    def _changed(self, s, new, rounding):
        """Nodes whose status is to change; also the last that sticks, which stays so, beyond the limit of friction."""
        beyond = np.abs(s.traction) - self.mu * np.maximum(s.pressure, 0.0) > rounding * s.pressure.max()
        return ~new.same(s.sets) | (s.sets.stuck & beyond & (self.mu > 0))

    def _updated(self, s, rounding):
        """Sets after Signorini's and Coulomb's conditions at every node."""
        p_rounding = rounding * s.pressure.max()
        u_rounding = rounding * np.ptp(self.data.height)
        closed = np.where(s.sets.closed, s.pressure > -p_rounding, s.gap < -u_rounding)
        if not self.mu:
            return ContactSets(closed, s.sets.slipping)
        was_slipping = s.sets.slipping
        limit = self.mu * np.maximum(s.pressure, 0.0) + p_rounding
        begins = np.where(np.abs(s.traction) > limit, np.sign(s.traction), 0.0)
        backwards = was_slipping * (s.position - self.data.rest) > u_rounding
        beside_stick = np.convolve(s.sets.stuck, np.ones(2 * RETURN + 1), "same") > 0.5
        if (backwards & beside_stick).any():
            backwards &= beside_stick
        slipping = np.where(was_slipping == 0, begins, np.where(backwards, 0.0, was_slipping))
        free_motion = np.sign(s.position - self.data.rest)  # of a point that comes into contact
        slipping = np.where(s.sets.closed, slipping, -free_motion)
        slipping = np.where(closed, slipping, 0.0)
        if closed.any() and slipping[closed].all():  # |Q| < mu P: somewhere slip changes its sign
            slipping[np.where(closed, np.abs(s.position - self.data.rest), np.inf).argmin()] = 0.0
        return ContactSets(closed, slipping)
