"""States between two turns of the tangential load."""

from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from ..checks import ContactNotConverged
from .conditions import check
from .edges import ITERATIONS, EdgeSolver, edges_of
from .tractions import SlipState

SAME = 1e-12  # of P: tangential loads this close are one, and there is no turn between them
FIRST = 0.02  # least load over the span of the branch, where there is a solution,
FIRST_BORNE = 0.5  # and from which on the energy needs one,
STRIDE, HALVINGS = 3.0, 4  # factor between loads on the way there, halvings of its logarithm where there is none,
LEAST_OVER_LIKE = 1.5  # and how much larger the least load is if the loop is ``like`` another
POWER = 2.0  # of the variable in which the loads are spread, see ``Branch.variable``
EXTRA, LATER = 4, 6  # number of loads in the first part more than the order is, and in each of the others
SHORTEST, CLOSER = 1e-3, 3  # part of a branch over its span, and states on the way to where it begins
FEWEST = 3  # known states in such a part
SPARSE = 3  # so many loads are solved before it is known where a stick edge passes an earlier turn
LEAST_WIDTH = 0.02  # of slip inside the contact at the turn, over the load, where a solution is still sought
MOST_ITERATIONS = 12  # iterations at loads that need no solution
SLIPPED_AGAIN = 1.5  # times the largest load without a state: from there on all points that came in stick have slipped


class Branch:
    """States while Q moves from the turn ``base`` in one direction, +1 or -1, up to the distance ``span``.

    guess: variables of the edges (see ``guess``) as a function of the distance from the turn; like: this branch with
    another order of the basis. loads: distances from the turn at which states are known; first: the least of them that
    the energy needs.
    """

    def __init__(self, base, direction, span, guess, like=None):
        self.problem, self.base, self.direction, self.span = base.problem, base, direction, span
        self._limit = base.problem.mu * (2 if isinstance(base, SlipState) else 1)
        self._solver = EdgeSolver(base, direction * base.problem.mu)
        self._guess = like.guessed if like else guess
        # at the loads: the states, and what the guess lacks of the variables of their edges
        self.loads, self._states, self._lacking, self._failure = np.empty(0), [], [], ""
        for load in self._spread(FIRST_BORNE * span, span, SPARSE):
            self._tried(load)
        if not len(self.loads) or self.loads[-1] < span:
            self._add(span, *self._solved(span))
        least = min(LEAST_OVER_LIKE * like.first, FIRST_BORNE * span) if like else FIRST * span
        self._reach(least)
        self.first = self.loads[0]
        self._like, self._has_all = like, self.first <= least * (1 + 1e-12)

    @cached_property
    def parts(self):
        """Loads where a stick edge passes a place where it turned before, between which delta_x is smooth; 0, span."""
        return np.array([0.0, *self._crossings(), self.span])

    @cached_property
    def nodes(self):
        """Loads in each of the ``parts`` that the energy needs; they are solved. Raises ContactNotConverged."""
        if self.first > FIRST_BORNE * self.span * (1 + 1e-12):
            raise ContactNotConverged(f"the energy is not known: just after the turn {self._failure}")
        lows, count = [self.first, *self.parts[1:-1]], self.problem.order + EXTRA
        counts = [count, *[LATER] * (len(lows) - 1)]
        nodes = [self._spread(*part) for part in zip(lows, self.parts[1:], counts, strict=True)]
        self.solve_at(nodes[0])
        for loads in nodes[1:]:
            solved = sum(self._tried(load) for load in loads[::-1])
            if solved < FEWEST:
                why = f"where stick passes a place at which it turned before, {self._failure}"
                raise ContactNotConverged(f"the energy is not known: {why}")
        return nodes

    def variable(self, load):
        """(1 - c/a)^(1/POWER) as it is without coupling, (48): in it delta_x is smooth up to full slip."""
        return (-np.expm1(np.log1p(-load / self._limit) / (2 + self.problem.k))) ** (1 / POWER)

    def is_undone(self, Q):
        """True where Q has come back past the turn at which this branch began."""
        return self.direction * (self.base.Q - Q) > SAME

    def _spread(self, low, high, count):
        """Loads from low to high, Chebyshev points in ``variable``."""
        first, last = self.variable(low), self.variable(high)
        v = first + (last - first) * (1 - np.cos(np.pi * np.arange(count) / (count - 1))) / 2
        loads = -self._limit * np.expm1(np.log1p(-(v**POWER)) * (2 + self.problem.k))
        loads[[0, -1]] = low, high
        return loads

    def solve_at(self, loads):
        """Adds the states at ``loads``, which increase, one after the other from the largest down.

        Just after the turn points may come into contact in stick; loads without a solution there are left out.
        """
        for load in loads[::-1]:
            if not self._tried(load):
                break

    def _tried(self, load):
        """True if there is a solution at a load, which is added."""
        if np.any(np.abs(self.loads - load) < 1e-12 * self.span):
            return True
        if self._hopeless(load):
            return False
        try:
            self._add(load, *self._solved(load, ITERATIONS if load > FIRST_BORNE * self.span else MOST_ITERATIONS))
        except ContactNotConverged as failure:
            self._failure = failure
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
        states, (x_l, x_r) = self._states[:2], self.base.contact
        widths = np.array([
            (min(c - x_l, c - s.contact[0]), min(x_r - d, s.contact[1] - d)) for s in states for c, d in (s.stick,)
        ])
        widths /= self.loads[:2, None]
        expected = widths[0] + (widths[1] - widths[0]) * (next_t - t[0]) / (t[1] - t[0])
        return bool((expected < LEAST_WIDTH).any())

    def _add(self, load, state, variables):
        i = int(np.searchsorted(self.loads, load))
        self.loads = np.insert(self.loads, i, load)
        self._states.insert(i, state)
        self._lacking.insert(i, variables - self._guess(load))

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
        near = slice(max(i - reach, 0), i + reach)
        t, at = np.log(self.loads[near]), np.log(load)
        weights = [np.prod((at - np.delete(t, j)) / (t[j] - np.delete(t, j))) for j in range(len(t))]
        lacking = np.array(self._lacking[near])
        found = weights @ lacking
        if reach == 3:  # edges jump where they pass earlier turns: polynomials across such a place swing
            found = np.clip(found, lacking.min(axis=0), lacking.max(axis=0))
        return variables + found

    def between(self, low, high):
        """Known loads from low to high (n,), and delta_x at them (n,)."""
        known = np.flatnonzero((low <= self.loads) & (self.loads <= high))
        return self.loads[known], np.array([self._states[i].delta_x for i in known])

    def state(self, Q):
        """State at Q."""
        load = abs(Q - self.base.Q)
        for known, state in zip(self.loads, self._states, strict=True):
            if abs(known - load) < 1e-12 * self.span:
                return state
        return self._solved(load)[0]

    def checked(self, Q):
        """State at Q that also fulfils the conditions which its edges do not ensure. Raises ContactNotConverged."""
        try:
            state = self.state(Q)
            self._check(state)
        except ContactNotConverged as failure:
            raise ContactNotConverged(f"Q = {Q:g} P: {failure}") from None
        return state

    def is_certain(self, Q):
        """False where points that came into contact in stick may stick still: the state at Q is as if they slipped."""
        return abs(Q - self.base.Q) >= SLIPPED_AGAIN * self._last_without

    @cached_property
    def _last_without(self):
        """Largest distance from the turn at which there is no state, as far as the known ones tell; 0 for none."""
        if self._like:  # which begins nearer to the turn
            return self._like._last_without
        last = 0.0 if self._has_all else self.first
        for load, state in zip(self.loads, self._states, strict=True):
            try:
                self._check(state)
            except ContactNotConverged:
                last = load
            else:
                break
        return last

    def _check(self, state):
        i = int(np.searchsorted(self.loads, abs(state.Q - self.base.Q) * (1 - 1e-12)))
        check(state, self._states[i - 1] if i else self.base, self.base, self.direction)

    def _crossings(self):
        """Loads at which an edge of stick passes a place where it turned before."""
        result = []
        for end, inwards in ((0, 1), (1, -1)):
            for x in self.base.breaks:
                passed = [inwards * (state.stick[end] - x) > 0 for state in self._states]
                if passed[-1] and not passed[0]:
                    i = passed.index(True)
                    result.append(self._crossing(x, end, self.loads[i - 1], self.loads[i]))
        apart, kept = SHORTEST * self.span, [max(FIRST * self.span, self.first)]
        for load in sorted(result):
            if load > kept[-1] + apart and load < self.span - apart:
                kept.append(load)
        return kept[1:]

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
