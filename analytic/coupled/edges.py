"""Newton's method for the edges of contact and stick of a state."""

import numpy as np

from ..checks import ContactNotConverged
from .linear import solve
from .stick import FEATURE

LONGEST_STEP = 0.3  # change of a variable in one step
ITERATIONS = 30
CUTS = 3  # steps in a row that would leave no stick, or leave the contact at the turn with it
SLOW, STALLS = 0.8, 4  # part of the amplitudes left after a step with a new Jacobian, and how often that is borne
LAST = 4  # steps after an edge is known to FEATURE, before that is enough
GROWTH = 1.5  # of the amplitudes that is borne in a step,
FREE = 1e-3  # and amplitudes that are borne in any case
FLAT = 0.03  # derivative of the amplitude at an edge of stick by its own variable; it is 0.1 to 0.3 elsewhere
LEAP_MARGIN = 0.01  # over the width of slip, by which a leap goes too far; a tenth of it at the next one
SHORTER = 0.1  # change of the widths of slip in a guess that leaves no stick
LEAST_STICK, LEAST_SLIP = 1e-4, 1e-12  # shares of the contact that have to stick, and to slip at each edge
SETTLED = 1e-8  # largest amplitude (see ``linear.Solution``) at which the edges rest,
BORNE = 1e-7  # and that borne where it falls no further: rounding, where slip has hardly begun;
WITH_KINKS = 1e-6, 1e-5  # the same on kernels that are not smooth, where the number of panels changes with the edges
JUMP = 1e-6  # amplitude borne at a place that is known to FEATURE: there the basis changes, and the amplitude with it
FADED = 0.1  # part of the present amplitude below which an opposite one, halved again and again, counts no more
REACHED = 0.99  # share of the way to a place with an amplitude of the other sign, from which a step passes it
STICK = ((1, -1), (2, 1))  # edges of stick, and which way is outwards

ARRIVAL = "points come into contact in stick"  # and keep the displacement with which they came
ARRIVED = 0.02  # over the contact: a search that ends with stick this close to the old edge of contact has met that


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

    The variables (4,) of ``edges_of``, for load = |Q - Q at the turn|, change little with the load.
    """

    def __init__(self, base, friction):
        self.base, self.friction = base, friction
        self._settled, self._borne = (SETTLED, BORNE) if base.problem.kinks is None else WITH_KINKS

    def state(self, Q, y, iterations=ITERATIONS):
        """State at Q and its variables, from the guess y. Raises ContactNotConverged."""
        load = abs(Q - self.base.Q)
        x_l, c_l, c_r, x_r = self._edges(y, load)
        way = SHORTER if c_l > self.base.contact[0] and c_r < self.base.contact[1] else -SHORTER
        y = self._valid(y, [0, -way, -way, 0], load)
        return self._found(Q, y, load, iterations)

    def _found(self, Q, y, load, iterations):
        """State and its variables, from the variables y."""

        def solution(y):
            return solve(self.base, self.friction, self._edges(y, load), Q)

        now, before, longest, cuts, margin, stalls = solution(y), np.inf, LONGEST_STEP, 0, LEAP_MARGIN, 0
        bracket, closed = Bracket(), 0
        for _ in range(iterations):
            edges, size = self._edges(y, load), np.abs(now.amplitudes).max()
            # after one step at least: a guess by another order of the basis would be returned as it is
            if (size < self._settled and before < np.inf) or (size > before / 2 and size < self._borne):
                return now.state, y
            closed += bracket.closed(edges, now.amplitudes)
            if closed > LAST:
                return now.state, y
            stalls += size > SLOW * before
            if stalls > STALLS:
                break
            step = self._step(edges, now, load)
            step *= min(1.0, longest / np.abs(step).max())
            leaps = self._leaps(edges, self._edges(y + step, load), now, margin)
            step[list(leaps)] = list(leaps.values())
            inside = bracket.steps(edges, self._edges(y + step, load), now.amplitudes)
            step[list(inside)] = list(inside.values())
            if leaps or inside:
                taken = self._valid(y + np.clip(step, -LONGEST_STEP, LONGEST_STEP), -step / 8, load)
                margin, before = margin / 10 if leaps else margin, np.inf
                new = solution(taken)
                bracket.note(edges, now.amplitudes, new.amplitudes)
                y, now = taken, new
                continue
            aim, taken = y + step, self._valid(y + step, -step / 8, load)
            cuts = 0 if np.array_equal(taken, aim) else cuts + 1
            if cuts > CUTS:
                raise ContactNotConverged(self._lack(aim, load))
            new = solution(taken)
            if not np.abs(new.amplitudes).max() < max(GROWTH * size, FREE):  # too long a step
                longest, before = np.abs(taken - y).max() / 4, np.inf
                continue
            bracket.note(edges, now.amplitudes, new.amplitudes)
            y, now, before = taken, new, size
        x_l, c_l, c_r, x_r = self._edges(y, load)
        if min(c_l - self.base.contact[0], self.base.contact[1] - c_r) < ARRIVED * (x_r - x_l):
            raise ContactNotConverged(ARRIVAL)
        raise ContactNotConverged(f"tractions without bound remain at the edges, their amplitudes are {size:.1e}")

    def _step(self, edges, now, load):
        """Step of Newton's method: each edge moves outwards by its amplitude over its rate."""
        x_l, c_l, c_r, x_r = edges
        widths = np.array([c_l - x_l, c_l - x_l, x_r - c_r, x_r - c_r])
        left, inner_left, inner_right, right = now.amplitudes / now.rates * widths
        motions = -left, left - inner_left, right - inner_right, right
        return np.array(motions) / [load, widths[1], widths[2], load]

    def _leaps(self, edges, aims, now, margin):
        """Changes of variables that take an edge of stick over a stretch on which its amplitude hardly changes;
        aims: edges after Newton's step.

        Where the load comes back to that of an earlier turn, a stretch between two places where stick turned may reach
        the limit of friction all at once. The edge then is beyond the next of these places, by the share ``margin``.
        """
        leaps = {}
        for e, outwards in STICK:
            way = outwards * np.sign(now.amplitudes[e])
            beyond = way * (self.base.breaks - edges[e])
            if now.rates[e] > FLAT or not (beyond > 0).any():
                continue
            distance = beyond[beyond > 0].min()
            if now.rates[e] > 0 and way * (aims[e] - edges[e]) < distance:
                continue
            width = outwards * (edges[e + outwards] - edges[e])
            leaps[e] = np.log1p(-outwards * way * min(distance / width + margin, 1 - np.exp(-LONGEST_STEP)))
        return leaps

    def _edges(self, y, load):
        return edges_of(y, load, self.base.contact)

    def _valid(self, y, back, load):
        """Variables, so many times ``back`` from y, with which stick and slip are left inside the old contact."""
        for times in range(8):
            taken = y + times * np.asarray(back)
            if not self._lack(taken, load):
                return taken
        raise ContactNotConverged(self._lack(y, load))

    def _lack(self, y, load):
        """Why there can be no edges with these variables; "" where there can."""
        x_l, c_l, c_r, x_r = self._edges(y, load)
        if c_l <= self.base.contact[0] or c_r >= self.base.contact[1]:
            return ARRIVAL
        if min(c_l - x_l, x_r - c_r) <= LEAST_SLIP * (x_r - x_l):
            return "no slip is left at an edge"
        if not c_r - c_l > LEAST_STICK * (x_r - x_l):  # nan too
            return "no stick is left between the zones of slip"
        return ""


class Bracket:
    """Last places of the edges of stick at which their amplitudes had the other sign, for steps between them.

    Where an edge comes to a place where stick turned earlier, the amplitude has a kink: Newton's method goes to and fro
    between two places there.
    """

    def __init__(self):
        self._passed: dict[int, tuple[float, float]] = {}

    def note(self, edges, before, after):
        """Amplitudes at ``edges`` and after a step from there. That of a place which stays is halved (Illinois)."""
        for e, _ in STICK:
            if before[e] * after[e] < 0:
                self._passed[e] = edges[e], before[e]
            elif e in self._passed:
                place, amplitude = self._passed[e]
                self._passed[e] = place, amplitude / 2
                if abs(amplitude) < FADED * abs(after[e]):
                    del self._passed[e]

    def steps(self, edges, aims, amplitudes):
        """Changes of variables by false position, of edges that would go to the place in question or past it."""
        found = {}
        for e, outwards in STICK:
            place, amplitude = self._passed.get(e, (edges[e], np.nan))
            if place != edges[e] and (aims[e] - edges[e]) / (place - edges[e]) > REACHED:
                share = amplitudes[e] / (amplitudes[e] - amplitude)
                width = outwards * (edges[e + outwards] - edges[e])
                found[e] = np.log1p(-outwards * share * (place - edges[e]) / width)
        return found

    def closed(self, edges, amplitudes):
        """True where an edge is known to FEATURE, within which singular points are one, and all else has settled."""
        close = [e for e, (place, _) in self._passed.items() if abs(place - edges[e]) < FEATURE * (edges[2] - edges[1])]
        return bool(close) and np.abs(np.delete(amplitudes, close)).max() < SETTLED and np.abs(amplitudes).max() < JUMP
