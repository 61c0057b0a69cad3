"""States between two turns of the tangential load, and the work that friction takes since the first of them."""

from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss

from .edges import EdgeSolver, edges_of, variables_of

LOADS = 10  # at which a branch is solved to begin with; the states at other loads start from these
FIRST = 0.02  # the least of them over the span of the branch
POWER = 1.5  # they are spaced evenly, like Chebyshev points, in load^(1/POWER)
MIDDLE = 0.3  # span at which the first of them is sought
WORK_NODES = 24  # of the integral over the loads, and of that over each part of a zone of slip


class Branch:
    """States while Q moves from the turn ``base`` in one direction, +1 or -1, up to the distance ``span``.

    guess: variables of the edges (see ``edges_of``) as a function of the distance from the turn.
    """

    def __init__(self, problem, base, direction, span, guess, loads=LOADS):
        self.problem, self.base, self.direction, self.span = problem, base, direction, span
        self._solver = EdgeSolver(problem, base, direction * problem.mu)
        self._guess = guess
        first = FIRST ** (1 / POWER)
        v = first + (1 - first) * (1 - np.cos(np.pi * np.arange(loads) / (loads - 1))) / 2
        self.loads = span * v**POWER
        self.states, self.variables, self._jacobians = self._solve_all()

    def _solve_all(self):
        """States at ``loads``, one after the other from the middle up, and then down."""
        n, solver = len(self.loads), self._solver
        states, variables, jacobians = [None] * n, np.zeros((n, 4)), [None] * n
        start = int(np.searchsorted(self.loads, MIDDLE * self.span))
        for direction, indices in ((1, range(start, n)), (-1, range(start - 1, -1, -1))):
            solver.jacobian = jacobians[start]
            for i in indices:
                known = [j for j in range(n) if states[j] is not None]
                near = sorted(known, key=lambda j: abs(j - i))[:3]
                y = self._between(self.loads[i], near, variables) if near else self._guess(self.loads[i])
                states[i], variables[i] = solver.state(self.base.Q + self.direction * self.loads[i], y)
                jacobians[i] = solver.jacobian
        return states, variables, jacobians

    def _between(self, load, near, variables):
        """Variables at a load from those at the loads ``near``, polynomials in the logarithm of the load."""
        t, at = np.log(self.loads[near]), np.log(load)
        others = [np.delete(t, i) for i in range(len(t))]
        return sum(y * np.prod((at - o) / (s - o)) for y, s, o in zip(variables[near], t, others, strict=True))

    def guessed(self, load):
        """Variables of the edges at a distance from the turn, interpolated."""
        near = np.sort(np.argsort(np.abs(np.log(self.loads / load)))[:4])
        return self._between(load, near, self.variables)

    def state(self, Q):
        """State at Q."""
        load = abs(Q - self.base.Q)
        i = int(np.abs(self.loads - load).argmin())
        if abs(self.loads[i] - load) < 1e-13 * self.span:
            return self.states[i]
        self._solver.jacobian = self._jacobians[i]
        return self._solver.state(Q, self.guessed(load))[0]

    @cached_property
    def _compliance(self):
        """Coefficients of (delta_x - delta_x at the turn)/(Q - Q at the turn) as a polynomial in load^(1/POWER)."""
        v = (self.loads / self.span) ** (1 / POWER)
        values = [(s.delta_x - self.base.delta_x) / (s.Q - self.base.Q) for s in self.states]
        return np.polynomial.chebyshev.Chebyshev.fit(v, values, len(v) - 1, domain=[0, 1])

    def dissipated(self, state):
        """Work of friction since the turn, from the balance of energy.

        Work of Q, less that stored: half of (tractions at the turn + tractions now) times the displacements since then.
        Where the contact sticks these are the indenter's; elsewhere slip and gap are left.
        """
        base, Q = self.base, state.Q - self.base.Q
        g, w = leggauss(WORK_NODES)
        v = (1 + g) / 2 * (abs(Q) / self.span) ** (1 / POWER)
        load = np.sign(Q) * self.span * v**POWER
        delta_x = self._compliance(v) * load
        integral = (w / 2 * POWER * load / ((1 + g) / 2)) @ delta_x  # ∫ delta_x dQ since the turn
        work = Q * (state.delta_x - base.delta_x) / 2 - integral
        for low, high in ((min(base.contact[0], state.contact[0]), state.stick[0]),
                          (state.stick[1], max(base.contact[1], state.contact[1]))):
            x, weight = smooth_rule(low, high, [*base.breaks, *base.contact, *state.contact])
            moved = state.displacements(self.problem, x) - base.displacements(self.problem, x)
            p, q = state.tractions(x) + base.tractions(x)
            work -= weight @ (q * moved[0] + p * moved[1]) / 2
        return work


def smooth_rule(low, high, breaks):
    """Nodes and weights between low and high for functions with weak singularities at the ``breaks``."""
    g, w = leggauss(WORK_NODES)
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
        half = min(load / 2, branch.span)
        left, inner_left, inner_right, right = branch.guessed(half)
        log_2 = np.log(load / half)
        return np.array([-right, inner_right - log_2, inner_left - log_2, -left])

    return guess
