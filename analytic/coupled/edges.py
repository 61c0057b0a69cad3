"""Newton's method (Broyden's updates) for the edges of contact and stick of a state."""

import numpy as np

from ..half_plane.linear import ContactNotConverged
from .linear import solve
from .stick import layout

PROBE = 1e-4  # difference of a variable for the Jacobian
LONGEST = 0.3  # change of a variable in one step
ITERATIONS = 30
LARGER = 1.3  # how much too large the panels at the ends of stick may be
CUTS = 3  # steps in a row that would leave no stick, or leave the contact at the turn with it
SLOW, STALLS = 0.8, 4  # part of the amplitudes left after a step with a new Jacobian, and how often that is borne
GROWTH = 1.5  # of the amplitudes that is borne in a step,
FREE = 1e-3  # and amplitudes that are borne in any case
FLAT = 0.03  # derivative of the amplitude at an edge of stick by its own variable; it is 0.1 to 0.3 elsewhere
MARGIN = 0.01  # over the width of slip, by which a leap goes too far; a tenth of it at the next one
SHORTER = 0.1  # change of the widths of slip in a guess that leaves no stick
LEAST = 1e-4  # share of the contact that has to stick
SETTLED = 1e-8  # largest amplitude (see ``linear.Solution``) at which the edges rest,
BORNE = 1e-7  # and that borne where it falls no further: rounding, where slip has hardly begun

ARRIVAL = "points come into contact in stick"  # and keep the displacement with which they came
ARRIVED = 0.02  # distance of stick from the edge of the contact at the turn over the contact, where the search stopped


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
        x_l, c_l, c_r, x_r = self._edges(y, load)
        way = SHORTER if c_l > self.base.contact[0] and c_r < self.base.contact[1] else -SHORTER
        y = self._valid(y, [0, -way, -way, 0], load)
        return self._found(Q, y, load, self._layout(self._edges(y, load)))

    def _found(self, Q, y, load, panels):
        """State and its variables, from the variables y and panels for them."""

        def solution(y):
            self.solves += 1
            return solve(self.problem, self.base, self.friction, self._edges(y, load), panels, Q)

        now, before, fresh, longest, cuts, margin, stalls = solution(y), np.inf, False, LONGEST, 0, MARGIN, 0
        for _ in range(ITERATIONS):
            fitting = self._layout(self._edges(y, load))
            if any(used[1] > LARGER * fit[1] for used, fit in zip(panels, fitting, strict=True)):
                panels = fitting
                now = solution(y)
            size = np.abs(now.amplitudes).max()
            if size < SETTLED or (fresh and size > before / 2 and size < BORNE):
                return now.state, y
            stalls += fresh and size > SLOW * before
            if stalls > STALLS:
                break
            if self.jacobian is None or size > before / 2:
                # where stick turned before the derivatives jump: those on the side where the root is
                probes = -np.copysign(PROBE, now.amplitudes)
                columns = [(solution(y + h * e).amplitudes - now.amplitudes) / h for h, e in zip(probes, np.eye(4))]
                self.jacobian, fresh = np.stack(columns, axis=1), True
            else:
                fresh = False
            step = -np.linalg.solve(self.jacobian, now.amplitudes)
            step *= min(1.0, longest / np.abs(step).max())
            if fresh and (leaps := self._leaps(y, now.amplitudes, step, load, margin)):
                step, margin = _with_leaps(self.jacobian, now.amplitudes, leaps), margin / 10
                y, before = self._valid(y + step, -step / 8, load), 0.0
                now = solution(y)
                continue
            aim, taken = y + step, self._valid(y + step, -step / 8, load)
            cuts = 0 if np.array_equal(taken, aim) else cuts + 1
            if cuts > CUTS:
                self._refuse(aim, load)
            step = taken - y
            new = solution(y + step)
            if not np.abs(new.amplitudes).max() < max(GROWTH * size, FREE):  # too long a step
                longest, before = np.abs(step).max() / 4, 0.0 if not fresh else np.inf
                continue
            self.jacobian += np.outer(new.amplitudes - now.amplitudes - self.jacobian @ step, step) / (step @ step)
            y, now, before = y + step, new, size
        x_l, c_l, c_r, x_r = self._edges(y, load)
        if min(c_l - self.base.contact[0], self.base.contact[1] - c_r) < ARRIVED * (x_r - x_l):
            raise ContactNotConverged(ARRIVAL)
        raise ContactNotConverged(f"tractions without bound remain at the edges, their amplitudes are {size:.1e}")

    def _leaps(self, y, amplitudes, step, load, margin):
        """Changes of variables that take an edge of stick over a stretch on which its amplitude hardly changes.

        Where the load comes back to that of an earlier turn, a stretch between two places where stick turned may reach
        the limit of friction all at once. The edge then is beyond the next of these places, by the share ``margin``.
        """
        edges, leaps = self._edges(y, load), {}
        after = self._edges(y + step, load)
        for e, outwards in ((1, -1), (2, 1)):
            way = outwards * np.sign(amplitudes[e])
            beyond = way * (self.base.breaks - edges[e])
            if self.jacobian[e, e] > FLAT or not (beyond > 0).any():
                continue
            distance = beyond[beyond > 0].min()
            if self.jacobian[e, e] > 0 and way * (after[e] - edges[e]) < distance:
                continue
            width = outwards * (edges[e + outwards] - edges[e])
            leaps[e] = np.log1p(-outwards * way * min(distance / width + margin, 1 - np.exp(-LONGEST)))
        return leaps

    def _layout(self, edges):
        _, c_l, c_r, _ = edges
        return layout(c_l, c_r, [*edges, *self.base.contact, *self.base.breaks])

    def _edges(self, y, load):
        return edges_of(y, load, self.base.contact)

    def _valid(self, y, back, load):
        """Variables, so many times ``back`` from y, with which some stick is left, within the contact at the turn."""
        for times in range(8):
            taken = y + times * np.asarray(back)
            x_l, c_l, c_r, x_r = self._edges(taken, load)
            outside = c_l <= self.base.contact[0] or c_r >= self.base.contact[1]
            if c_r - c_l > LEAST * (x_r - x_l) and not outside:
                return taken
        return self._refuse(y, load)

    def _refuse(self, y, load):
        _, c_l, c_r, _ = self._edges(y, load)
        outside = c_l <= self.base.contact[0] or c_r >= self.base.contact[1]
        reason = ARRIVAL if outside else "no stick is left between the zones of slip"
        raise ContactNotConverged(reason)


def _with_leaps(jacobian, amplitudes, leaps):
    """Step of Newton's method with some of its components given, whose amplitudes are left."""
    step = np.zeros(4)
    step[list(leaps)] = list(leaps.values())
    free = [i for i in range(4) if i not in leaps]
    step[free] = -np.linalg.solve(jacobian[np.ix_(free, free)], amplitudes[free] + jacobian[free] @ step)
    return np.clip(step, -LONGEST, LONGEST)
