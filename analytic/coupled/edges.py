"""Newton's method (Broyden's updates) for the edges of contact and stick of a state."""

import numpy as np

from ..half_plane.linear import ContactNotConverged
from .linear import solve
from .stick import layout

PROBE = 1e-4  # difference of a variable for the Jacobian
LONGEST = 0.3  # change of a variable in one step
ITERATIONS = 30
SHORTER = 0.1  # change of the widths of slip in a guess that leaves no stick
LEAST = 1e-4  # share of the contact that has to stick
SETTLED = 1e-10  # largest amplitude (see ``linear.Solution``) at which the edges rest,
BORNE = 1e-7  # and that borne where it falls no further: rounding, where slip has hardly begun


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
        y = self._valid(y, [0, -SHORTER, -SHORTER, 0], load)
        panels = self._layout(self._edges(y, load))

        def solution(y):
            self.solves += 1
            return solve(self.problem, self.base, self.friction, self._edges(y, load), panels, Q)

        now, size, fresh = solution(y), np.inf, False
        for _ in range(ITERATIONS):
            before, size = size, np.abs(now.amplitudes).max()
            if size < SETTLED or (fresh and size > before / 2 and size < BORNE):
                return now.state, y
            fresh = self.jacobian is None or size > before / 2
            if fresh:
                columns = [(solution(y + PROBE * e).amplitudes - now.amplitudes) / PROBE for e in np.eye(4)]
                self.jacobian = np.stack(columns, axis=1)
            step = -np.linalg.solve(self.jacobian, now.amplitudes)
            step *= min(1.0, LONGEST / np.abs(step).max())
            step = self._valid(y + step, -step / 8, load) - y
            new = solution(y + step)
            self.jacobian += np.outer(new.amplitudes - now.amplitudes - self.jacobian @ step, step) / (step @ step)
            y, now = y + step, new
        raise ContactNotConverged(f"tractions without bound remain at the edges, their amplitudes are {size:.1e}")

    def _layout(self, edges):
        _, c_l, c_r, _ = edges
        return layout(c_l, c_r, [*edges, *self.base.contact, *self.base.breaks])

    def _edges(self, y, load):
        return edges_of(y, load, self.base.contact)

    def _valid(self, y, back, load):
        """Variables, so many times ``back`` from y, with which some stick is left between the zones of slip."""
        for times in range(8):
            taken = y + times * np.asarray(back)
            x_l, c_l, c_r, x_r = self._edges(taken, load)
            if c_r - c_l > LEAST * (x_r - x_l):
                return taken
        raise ContactNotConverged("no stick is left between the zones of slip")
