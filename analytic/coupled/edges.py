"""Newton's method (Broyden's updates) for the edges of contact and stick of a state."""

import numpy as np

from ..half_plane.linear import ContactNotConverged
from .linear import solve
from .tractions import references

PROBE = 1e-3  # difference of a variable for the Jacobian
LONGEST = 0.3  # change of a variable in one step
ITERATIONS = 40
DECIDED = 0.3  # share of the largest amplitude at which the sign of another one counts
SETTLED = 3e-9  # motion of the edges over the half-width of the contact at which they rest
VANISHING = 1e-10  # amplitudes (see ``linear.Solution``) taken for zero,
BORNE, PATIENCE = 1e-5, 1  # and those borne after so many steps that did not lower them: rounding for k < 0, and where
# a stick edge comes back to a place where it turned before, which it is nearly neutral to leave


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
            return self._solution(Q, y, zones)

        now, best = solution(y), (np.inf, None, y)
        bounds = np.full((2, 4), [[-np.inf], [np.inf]])
        stalls = 0
        for _ in range(ITERATIONS):
            fresh = self.jacobian is None
            if fresh:
                columns = [(solution(y + PROBE * e).amplitudes - now.amplitudes) / PROBE for e in np.eye(4)]
                self.jacobian = np.stack(columns, axis=1)
            amplitude = np.abs(now.amplitudes).max()
            best = min(best, (amplitude, now.state, y), key=lambda b: b[0])
            self._narrow(bounds, y, now.amplitudes)
            step = self._step(now.amplitudes, y, bounds)
            motion = load * np.abs(step * np.exp([0, y[1], y[2], 0])).max()
            if motion < SETTLED or amplitude < VANISHING or (best[0] < BORNE and stalls > PATIENCE):
                return best[1:]
            new = solution(y + step)
            grown = np.abs(new.amplitudes).max() > 0.5 * amplitude
            stalls += grown
            if grown and not fresh:
                self.jacobian = None
            else:
                self.jacobian += np.outer(new.amplitudes - now.amplitudes - self.jacobian @ step, step) / (step @ step)
            y, now = y + step, new
        raise ContactNotConverged(f"tractions without bound remain at the edges, their amplitudes are {best[0]:.1e}")

    def _solution(self, Q, y, zones):
        self.solves += 1
        return solve(self.problem, self.base, self.friction, self._edges(y, abs(Q - self.base.Q)), zones, Q)

    def _narrow(self, bounds, y, amplitudes):
        """Bounds for the widths of slip: beyond the limit of friction they are too small, below it too large."""
        for j in (1, 2):
            beyond = -np.sign(self.friction) * amplitudes[j]
            if abs(beyond) > DECIDED * np.abs(amplitudes).max():
                bounds[0 if beyond > 0 else 1, j] = y[j]

    def _step(self, amplitudes, y, bounds):
        """Newton's step; the widths of slip stay within their bounds, and the others follow them."""
        step = -np.linalg.solve(self.jacobian, amplitudes)
        low, high = np.maximum(bounds[0] - y, -LONGEST), np.minimum(bounds[1] - y, LONGEST)
        taken = np.zeros(4, dtype=bool)
        for j in (1, 2):
            if not low[j] < step[j] < high[j]:
                taken[j] = True
                both = np.isfinite(bounds[:, j]).all() and high[j] - low[j] < LONGEST
                step[j] = (low[j] + high[j]) / 2 if both else np.clip(step[j], low[j], high[j])
        if taken.any():
            free = ~taken
            right = -amplitudes - self.jacobian[:, taken] @ step[taken]
            step[free] = np.linalg.solve(self.jacobian[np.ix_(free, free)], right[free])
        return np.clip(step, -LONGEST, LONGEST)

    def _edges(self, y, load):
        edges = edges_of(y, load, self.base.contact)
        if not (np.diff(edges) > 0).all():
            raise ContactNotConverged("no stick is left between the zones of slip")
        return edges
