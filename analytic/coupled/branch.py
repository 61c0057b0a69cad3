"""States between two turns of the tangential load, and the work that friction takes since the first of them."""

from functools import cached_property

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.optimize import brentq

from ..half_plane.linear import ContactNotConverged
from .edges import EdgeSolver, edges_of, variables_of
from .panels import gauss
from .problem import NormalStage

FIRST = 0.02  # the least of them over the span of the branch,
FIRST_BORNE = 0.3  # and the least that must have a solution
POWER = 1.5  # of the variable in which the loads are spread, see ``Branch._spread``
MIDDLE = 0.3  # span at which the first of them is sought
CONDITIONS = 1e-5  # violation of the conditions of friction that is borne, in units of the problem
WORK_NODES = 24  # of the integral over the loads, and of that over each part of a zone of slip


class Branch:
    """States while Q moves from the turn ``base`` in one direction, +1 or -1, up to the distance ``span``.

    guess: variables of the edges (see ``edges_of``) as a function of the distance from the turn.
    loads: distances from the turn at which states are known; parts: those where a stick edge passes a place where it
    turned before, between which delta_x is smooth.
    """

    def __init__(self, problem, base, direction, span, guess):
        self.problem, self.base, self.direction, self.span = problem, base, direction, span
        self._limit = problem.mu * (1 if isinstance(base, NormalStage) else 2)
        self._solver = EdgeSolver(problem, base, direction * problem.mu)
        self._guess = guess
        self.loads, self._known = np.empty(0), []
        nodes = [self._spread(0.0, span)]
        self._solve_at(nodes[0])
        crossings = self._crossings()
        self.parts = np.array([0.0, *crossings, span])
        if crossings:
            nodes = [self._spread(low, high) for low, high in zip(self.parts, self.parts[1:], strict=False)]
            for loads in nodes:
                self._solve_at(loads)
        self._nodes = nodes

    def _progress(self, load):
        """1 - c/a as it is without coupling, (48): in this variable delta_x is smooth up to full slip."""
        return -np.expm1(np.log1p(-load / self._limit) / (2 + self.problem.k))

    def _spread(self, low, high):
        """Loads between low and high, Chebyshev points in a power of ``_progress``, both ends included or nearly so."""
        first = FIRST * high if low == 0 else low
        first, last = (self._progress(load) ** (1 / POWER) for load in (first, high))
        count = max(self.problem.order, 4)
        v = first + (last - first) * (1 - np.cos(np.pi * np.arange(count) / (count - 1))) / 2
        loads = -self._limit * np.expm1(np.log1p(-(v**POWER)) * (2 + self.problem.k))
        loads[-1] = high
        return loads

    def _solve_at(self, loads):
        """Adds the states at ``loads``, one after the other from the middle up, and then down.

        Just after the turn points may come into contact in stick; loads without a solution there are left out.
        """
        start = int(np.searchsorted(loads, MIDDLE * self.span)) % len(loads)
        for load in (*loads[start:], *loads[:start][::-1]):
            if np.any(np.abs(self.loads - load) < 1e-12 * self.span):
                continue
            try:
                self._add(load, *self._solved(load))
            except ContactNotConverged:
                if load > FIRST_BORNE * self.span or not len(self.loads):
                    raise
                break

    def _add(self, load, state, variables):
        self._known.append((load, state, variables - self._guess(load), self._solver.jacobian))
        self._known.sort(key=lambda known: known[0])
        self.loads = np.array([known[0] for known in self._known])

    def _solved(self, load):
        if len(self.loads):
            self._solver.jacobian = self._known[int(np.abs(np.log(self.loads / load)).argmin())][3]
        Q = self.base.Q + self.direction * load
        return self._solver.state(Q, self.guessed(load))

    def guessed(self, load):
        """Variables of the edges at a distance from the turn: the guess, and what it lacks at known states, between
        which this is interpolated over the logarithm of the load."""
        if not len(self.loads):
            return self._guess(load)
        i = int(np.searchsorted(self.loads, load))
        reach = 3 if 0 < i < len(self.loads) else 2
        near = np.arange(max(i - reach, 0), min(i + reach, len(self.loads)))
        t, at = np.log(self.loads[near]), np.log(load)
        weights = [np.prod((at - np.delete(t, i)) / (t[i] - np.delete(t, i))) for i in range(len(t))]
        return self._guess(load) + weights @ np.array([self._known[i][2] for i in near])

    def state(self, Q):
        """State at Q."""
        load = abs(Q - self.base.Q)
        for known, state, *_ in self._known:
            if abs(known - load) < 1e-12 * self.span:
                return state
        return self._solved(load)[0]

    @property
    def solves(self):
        """Number of linear systems solved so far."""
        return self._solver.solves

    def check(self, state):
        """Raises ContactNotConverged where a state does not fulfil the conditions that its edges do not ensure."""
        x_l, x_r = state.contact
        c_l, c_r = state.stick
        if c_l < self.base.contact[0] or c_r > self.base.contact[1]:
            raise ContactNotConverged(f"Q = {state.Q:g} P: points come into contact in stick")
        x, weight = smooth_rule(x_l, x_r, state.breaks)
        p, q = state.tractions(x)
        if (tension := weight @ np.maximum(-p, 0)) > CONDITIONS:
            raise ContactNotConverged(f"Q = {state.Q:g} P: the pressure is negative, its integral {tension:.1e} P")
        if (over := weight @ np.maximum(np.abs(q) - self.problem.mu * p, 0)) > CONDITIONS:
            raise ContactNotConverged(f"Q = {state.Q:g} P: q exceeds its limit where it sticks, by {over:.1e} P in all")

    def _crossings(self):
        """Loads at which an edge of stick passes a place where it turned before."""
        result = []
        for end, inwards in ((0, 1), (1, -1)):
            for x in self.base.breaks:
                passed = [inwards * (known[1].stick[end] - x) > 0 for known in self._known]
                if passed[-1] and not passed[0]:
                    i = passed.index(True)
                    result.append(self._crossing(x, end, self.loads[i - 1], self.loads[i]))
        return sorted(load for load in result if FIRST < load / self.span < 1 - FIRST)

    def _crossing(self, x, end, low, high):
        """Load between low and high at which a stick edge is at x, by interpolation."""

        def distance(load):
            return edges_of(self.guessed(load), load, self.base.contact)[1 + end] - x

        if distance(low) * distance(high) > 0:
            return high
        load = brentq(distance, low, high)
        if load < (1 - FIRST) * self.span:  # once more, from a state close by
            self._solve_at(np.array([load]))
            if distance(low) * distance(high) < 0:
                return brentq(distance, low, high)
        return load

    @cached_property
    def _motion(self):
        """(delta_x since the turn) / load over _progress^(1/POWER), a function for each of the ``parts``."""
        functions = []
        for low, high, nodes in zip(self.parts, self.parts[1:], self._nodes, strict=False):
            known = [k for k in self._known if np.abs(nodes - k[0]).min() < 1e-12 * self.span]
            t = np.array([k[0] for k in known])
            values = np.array([k[1].delta_x for k in known]) - self.base.delta_x
            v = self._progress(t) ** (1 / POWER)
            functions.append(Chebyshev.fit(v, values / t, len(t) - 1, domain=[low and v[0], v[-1]]))
        return functions

    def _motion_integral(self, load):
        """∫ (delta_x since the turn) over the load, from the turn."""
        g, w = gauss(WORK_NODES)
        total = 0.0
        for low, high, motion in zip(self.parts, self.parts[1:], self._motion, strict=False):
            high = min(high, load)
            if high > low:
                v = (1 + g) / 2
                t = low + (high - low) * v**2
                total += (high - low) * (w * v) @ (t * motion(self._progress(t) ** (1 / POWER)))
        return total

    def dissipated(self, state):
        """Work of friction since the turn, from the balance of energy.

        Work of Q, less that stored: half of (tractions at the turn + tractions now) times the displacements since then.
        Where the contact sticks these are the indenter's; elsewhere slip and gap are left.
        """
        base, Q = self.base, state.Q - self.base.Q
        work = Q * (state.delta_x - base.delta_x) / 2 - self.direction * self._motion_integral(abs(Q))
        sides = (
            (min(base.contact[0], state.contact[0]), state.stick[0]),
            (state.stick[1], max(base.contact[1], state.contact[1])),
        )
        for low, high in sides:
            x, weight = smooth_rule(low, high, [*base.breaks, *base.contact, *state.contact])
            moved = state.displacements(self.problem, x) - base.displacements(self.problem, x)
            touching = (x > state.contact[0]) & (x < state.contact[1])
            if (back := (moved[0] * self.direction)[touching].max()) > CONDITIONS:
                raise ContactNotConverged(f"Q = {state.Q:g} P: a point slips backwards, by {back:.1e}")
            p, q = state.tractions(x) + base.tractions(x)
            work -= weight @ (q * moved[0] + p * moved[1]) / 2
        return float(work)


def smooth_rule(low, high, breaks):
    """Nodes and weights between low and high for functions with weak singularities at the ``breaks``."""
    g, w = gauss(WORK_NODES)
    t = (1 + g) / 2
    points = np.unique([low, *[x for x in breaks if low < x < high], high])
    a, length = points[:-1, None], np.diff(points)[:, None]
    return (a + length * t**3 * (10 - 15 * t + 6 * t**2)).ravel(), (length * w / 2 * 30 * t**2 * (1 - t) ** 2).ravel()


def uncoupled_guess(k, limit):
    """Variables of the edges at a distance from a state of full stick, without coupling, (48)."""

    def guess(load):
        c = max(1 - load / limit, 1e-3) ** (1 / (2 + k))
        return variables_of(np.array([-1.0, -c, c, 1.0]), load, (-1.0, 1.0))

    return guess


def turned_guess(branch):
    """Variables after a turn, from a branch of the other direction: as after half the load from there, (36), [X5]."""

    def guess(load):
        half = np.clip(load / 2, branch.loads[0], branch.span)
        left, inner_left, inner_right, right = branch.guessed(half)
        log_2 = np.log(load / half)
        return np.array([-right, inner_right - log_2, inner_left - log_2, -left])

    return guess
