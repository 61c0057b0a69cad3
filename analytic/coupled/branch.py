"""States between two turns of the tangential load."""

from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from ..half_plane.linear import ContactNotConverged
from .edges import ITERATIONS, EdgeSolver, edges_of
from .problem import NormalStage
from .rule import smooth_rule

FIRST = 0.02  # least load over the span of the branch, where there is a solution,
FIRST_BORNE = 0.5  # and from which on there must be one,
STRIDE, HALVINGS = 3.0, 2  # factor between loads on the way there, halvings of its logarithm where there is none,
LEAST_OVER_LIKE = 1.5  # and how much larger the least load is if the loop is ``like`` another
POWER = 2.0  # of the variable in which the loads are spread, see ``Branch.variable``
EXTRA, LATER = 4, 6  # number of loads in the first part more than the order is, and in each of the others
MIDDLE = 0.3  # span at which the first of them is sought
SHORTEST, CLOSER = 1e-3, 3  # part at the end of a branch over its span, and states on the way to where it begins
SPARSE = 3  # so many loads are solved before it is known where a stick edge passes an earlier turn
LEAST_WIDTH = 0.02  # of slip inside the contact at the turn, over the load, where a solution is still sought
MOST_ITERATIONS = 12  # iterations at loads that need no solution
CONDITIONS = 1e-5  # violation of the conditions of friction that is borne, in units of the problem


class Branch:
    """States while Q moves from the turn ``base`` in one direction, +1 or -1, up to the distance ``span``.

    guess: variables of the edges (see ``guess``) as a function of the distance from the turn; like: this branch with
    another order of the basis. loads: distances from the turn at which states are known; first: the least of them that
    the energy needs.
    """

    def __init__(self, problem, base, direction, span, guess, like=None):
        self.problem, self.base, self.direction, self.span = problem, base, direction, span
        self._limit = problem.mu * (1 if isinstance(base, NormalStage) else 2)
        self._solver = EdgeSolver(problem, base, direction * problem.mu)
        self._guess = like.guessed if like else guess
        self.loads, self._known = np.empty(0), []
        self.solve_at(self._spread(FIRST_BORNE * span, span, SPARSE))
        self._reach(min(LEAST_OVER_LIKE * like.first, FIRST_BORNE * span) if like else FIRST * span)
        self.first = self.loads[0]

    @cached_property
    def parts(self):
        """Loads where a stick edge passes a place where it turned before, between which delta_x is smooth; 0, span."""
        return np.array([0.0, *self._crossings(), self.span])

    @cached_property
    def nodes(self):
        """Loads in each of the ``parts`` that the energy needs; they are solved."""
        lows, count = [self.first, *self.parts[1:-1]], self.problem.order + EXTRA
        counts = [count, *[LATER] * (len(lows) - 1)]
        nodes = [self._spread(*part) for part in zip(lows, self.parts[1:], counts, strict=True)]
        for loads in nodes:
            self.solve_at(loads)
        return nodes

    def variable(self, load):
        """(1 - c/a)^(1/POWER) as it is without coupling, (48): in it delta_x is smooth up to full slip."""
        return (-np.expm1(np.log1p(-load / self._limit) / (2 + self.problem.k))) ** (1 / POWER)

    def _spread(self, low, high, count):
        """Loads from low to high, Chebyshev points in ``variable``."""
        first, last = self.variable(low), self.variable(high)
        v = first + (last - first) * (1 - np.cos(np.pi * np.arange(count) / (count - 1))) / 2
        loads = -self._limit * np.expm1(np.log1p(-(v**POWER)) * (2 + self.problem.k))
        loads[[0, -1]] = low, high
        return loads

    def solve_at(self, loads):
        """Adds the states at ``loads``, one after the other from the middle up, and then down.

        Just after the turn points may come into contact in stick; loads without a solution there are left out.
        """
        start = int(np.searchsorted(loads, MIDDLE * self.span)) % len(loads)
        for load in (*loads[start:], *loads[:start][::-1]):
            if np.any(np.abs(self.loads - load) < 1e-12 * self.span):
                continue
            if load > FIRST_BORNE * self.span or not len(self.loads):
                self._add(load, *self._solved(load))
            elif not self._tried(load):
                break

    def _tried(self, load):
        """True if there is a solution at a load, which is added."""
        if self._hopeless(load):
            return False
        try:
            self._add(load, *self._solved(load, MOST_ITERATIONS))
        except ContactNotConverged:
            return False
        return True

    def _reach(self, first):
        """Adds states at smaller loads, as far as ``first`` or as there are solutions."""
        stride, halvings = STRIDE, 0
        while self.loads[0] > first and halvings <= HALVINGS:
            if not self._tried(max(self.loads[0] / stride, first)):
                stride, halvings = np.sqrt(stride), halvings + 1

    def _hopeless(self, load):
        """True where slip, continued over the logarithm of the load, has left the contact at the turn or has closed."""
        if len(self.loads) < 2 or load > self.loads[0]:
            return False
        t, next_t = np.log(self.loads[:2]), np.log(load)
        states = [known[1] for known in self._known[:2]]
        x_l, x_r = self.base.contact
        widths = np.array([
            (min(c - x_l, c - s.contact[0]), min(x_r - d, s.contact[1] - d)) for s in states for c, d in (s.stick,)
        ])
        widths /= self.loads[:2, None]
        expected = widths[0] + (widths[1] - widths[0]) * (next_t - t[0]) / (t[1] - t[0])
        return bool((expected < LEAST_WIDTH).any())

    def _add(self, load, state, variables):
        self._known.append((load, state, variables - self._guess(load)))
        self._known.sort(key=lambda known: known[0])
        self.loads = np.array([known[0] for known in self._known])

    def _solved(self, load, iterations=ITERATIONS):
        return self._solver.state(self.base.Q + self.direction * load, self.guessed(load), iterations)

    def guessed(self, load):
        """Variables of the edges at a distance from the turn: what the guess lacks at known states is interpolated over
        the logarithm of the load."""
        variables = self._guess(load)
        if not len(self.loads):
            return variables
        i = int(np.searchsorted(self.loads, load))
        reach = 3 if 0 < i < len(self.loads) else 2
        near = np.arange(max(i - reach, 0), min(i + reach, len(self.loads)))
        t, at = np.log(self.loads[near]), np.log(load)
        weights = [np.prod((at - np.delete(t, i)) / (t[i] - np.delete(t, i))) for i in range(len(t))]
        return variables + weights @ np.array([self._known[i][2] for i in near])

    def between(self, low, high):
        """Known loads from low to high (n,), and delta_x at them (n,)."""
        known = [(load, state.delta_x) for load, state, _ in self._known if low <= load <= high]
        loads, delta_x = zip(*known, strict=True)
        return np.array(loads), np.array(delta_x)

    def state(self, Q):
        """State at Q."""
        load = abs(Q - self.base.Q)
        for known, state, _ in self._known:
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
        for x, _, moved in self.moved(state):
            touching = (x > x_l) & (x < x_r)
            if (back := (moved[0] * self.direction)[touching].max()) > CONDITIONS:
                raise ContactNotConverged(f"Q = {state.Q:g} P: a point slips backwards, by {back:.1e}")

    def moved(self, state):
        """Beside the stick zone of a state, left and right: points x, their weights, and u_x - delta_x and
        u_y - delta_y there since the turn, (2, n)."""
        base, problem = self.base, self.problem
        sides = (
            (min(base.contact[0], state.contact[0]), state.stick[0]),
            (state.stick[1], max(base.contact[1], state.contact[1])),
        )
        for low, high in sides:
            x, weight = smooth_rule(low, high, [*base.breaks, *base.contact, *state.contact])
            yield x, weight, state.displacements(problem, x) - base.displacements(problem, x)

    def _crossings(self):
        """Loads at which an edge of stick passes a place where it turned before."""
        result = []
        for end, inwards in ((0, 1), (1, -1)):
            for x in self.base.breaks:
                passed = [inwards * (known[1].stick[end] - x) > 0 for known in self._known]
                if passed[-1] and not passed[0]:
                    i = passed.index(True)
                    result.append(self._crossing(x, end, self.loads[i - 1], self.loads[i]))
        return sorted(load for load in result if FIRST < load / self.span < 1 - SHORTEST)

    def _crossing(self, x, end, low, high):
        """Load between low and high at which a stick edge is at x, by interpolation."""

        def distance(load):
            return edges_of(self.guessed(load), load, self.base.contact)[1 + end] - x

        if distance(low) * distance(high) > 0:
            return high
        for _ in range(CLOSER):
            load = brentq(distance, low, high)
            if min(load - low, high - load) < SHORTEST * self.span:
                break
            self.solve_at(np.array([load]))
            low, high = (low, load) if distance(low) * distance(load) < 0 else (load, high)
        return load
