"""Newton's method (Broyden's updates) for the edges of contact and stick of a state."""

import numpy as np

from ..half_plane_linear import ContactNotConverged
from .linear import solve
from .tractions import references

PROBE = 1e-3  # difference of a variable for the Jacobian
LONGEST = 0.3  # change of a variable in one step
ITERATIONS = 30
SETTLED = 1e-8  # motion of the edges over the half-width of the contact at which they rest,
BORNE, PATIENCE = 1e-7, 8  # and that which is borne after so many steps, as rounding may not let it get smaller


def edges_of(y, load, contact):
    """Edges (4,) from the variables: motion of the edges of contact and logarithm of the widths of slip, over load."""
    x_l, x_r = contact[0] + load * y[0], contact[1] + load * y[3]
    return np.array([x_l, x_l + load * np.exp(y[1]), x_r - load * np.exp(y[2]), x_r])


def variables_of(edges, load, contact):
    """Inverse of ``edges_of``."""
    x_l, c_l, c_r, x_r = edges
    widths = np.log([(c_l - x_l) / load, (x_r - c_r) / load])
    return np.array([(x_l - contact[0]) / load, *widths, (x_r - contact[1]) / load])


class EdgeSolver:
    """States since the turn ``base`` with slip of one direction: q = friction p.

    The variables (4,) of ``edges_of``, for load = |Q - Q at the turn|, change little with the load, and so does the
    Jacobian of the amplitudes, which is handed on from one load to the next. solves: number of linear systems.
    """

    def __init__(self, problem, base, friction):
        self.problem, self.base, self.friction = problem, base, friction
        self.jacobian = None
        self.solves = 0

    def state(self, Q, y):
        """State at Q and its variables, from the guess y. Raises ContactNotConverged."""
        load = abs(Q - self.base.Q)
        zones = references(self.problem, self.friction, self._edges(y, load), self.base)

        def solution(y):
            self.solves += 1
            return solve(self.problem, self.base, self.friction, self._edges(y, load), zones, Q)

        now = solution(y)
        for iteration in range(ITERATIONS):
            fresh = self.jacobian is None
            if fresh:
                columns = [(solution(y + PROBE * e).amplitudes - now.amplitudes) / PROBE for e in np.eye(4)]
                self.jacobian = np.stack(columns, axis=1)
            step = -np.linalg.solve(self.jacobian, now.amplitudes)
            motion = load * np.abs(step * np.exp([0, y[1], y[2], 0])).max()
            if motion < SETTLED or (motion < BORNE and iteration > PATIENCE):
                return now.state, y
            step *= min(1.0, LONGEST / np.abs(step).max())
            new = solution(y + step)
            grown = np.abs(new.amplitudes).max() > 0.5 * np.abs(now.amplitudes).max()
            if grown and not fresh:
                self.jacobian = None
            else:
                self.jacobian += np.outer(new.amplitudes - now.amplitudes - self.jacobian @ step, step) / (step @ step)
            y, now = y + step, new
        raise ContactNotConverged(f"the edges of contact and stick still move by {motion:.1e} of the contact's half-width")

    def _edges(self, y, load):
        edges = edges_of(y, load, self.base.contact)
        if not (np.diff(edges) > 0).all():
            raise ContactNotConverged("no stick is left between the zones of slip")
        return edges
