"""Work that friction takes between two turns of the tangential load, from the balance of energy."""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.special import digamma, loggamma

from ..edge_exponents import oscillation
from ..quadrature import gauss_rule
from . import guess
from .branch import Branch
from .edges import EdgeSolver
from .pressed import PressedWithFriction, WithoutFriction
from .rule import smooth_rule

BEYOND = 0.3  # logarithm of the load over which the motion is continued to the turn, within the first part
LOAD_NODES = 24  # of the integral over the loads
JUST_AFTER = 0.01, 0.02, 0.04, 0.08  # loads over mu P from which the motion is continued to 0
SMALL_K, NODES = 0.5, 24  # |k| below which ln Γ(z - k) - ln Γ(z) is integrated, as it would cancel; nodes for that


class FrictionalWork:
    """Work of friction on a branch, in the units of ``Problem``."""

    def __init__(self, branch: Branch):
        self._branch = branch

    @cached_property
    def _compliance(self):
        """d delta_x / dQ just after the turn: of full stick; where slip goes on from pressing, continued to there."""
        branch = self._branch
        left, right = branch.base.contact
        if not isinstance(branch.base, PressedWithFriction):
            return stick_compliance(branch.problem, (right - left) / 2)
        t, delta_x = (values[:3] for values in branch.between(branch.first, branch.span))
        return branch.direction * np.linalg.solve(np.stack([np.ones(3), t, t * np.log(t)], axis=1), delta_x / t)[0]

    @cached_property
    def _softening(self):
        """(delta_x since the turn / load - ``_compliance``) / load, a function of ``Branch.variable`` for each of
        the ``parts``; it changes like the logarithm of the load just after the turn."""
        branch, functions = self._branch, []
        for nodes in branch.nodes:
            t, delta_x = branch.between(nodes[0], nodes[-1])
            moved = branch.direction * (delta_x - branch.base.delta_x)
            v = branch.variable(t)
            values = (moved / t - self._compliance) / t
            functions.append(Chebyshev.fit(v, values, min(len(t), len(nodes)) - 1, domain=[v[0], v[-1]]))
        return functions

    def _motion_integral(self, load):
        """∫ (distance of the indenter since the turn) over the load, from the turn."""
        branch, (g, w) = self._branch, gauss_rule(LOAD_NODES)
        total = self._compliance * load**2 / 2
        for low, high, function in zip(branch.parts, branch.parts[1:], self._softening, strict=False):
            high = min(high, load)
            if low == 0:  # up to the first known state as a parabola over the logarithm of the load
                low = min(branch.first, load)
                u = np.array([0.0, 0.5, 1.0]) * min(BEYOND, np.log(branch.parts[1] / branch.first))
                parabola = np.polyfit(u, function(branch.variable(branch.first * np.exp(u))), 2)
                u = np.log(low / branch.first)
                total += low**3 / 3 * (parabola @ [u**2 - 2 * u / 3 + 2 / 9, u - 1 / 3, 1])
            if high > low:
                t = low + (high - low) * g
                total += (high - low) * (w @ (t**2 * function(branch.variable(t))))
        return total

    def at(self, state):
        """Work of friction from the turn to a ``state`` of the branch.

        Work of Q, less that stored: half of (tractions at the turn + tractions now) times the displacements since then.
        Where the contact sticks these are the indenter's; elsewhere slip and gap are left.
        """
        base = self._branch.base
        Q = state.Q - base.Q
        work = Q * (state.delta_x - base.delta_x) / 2 - self._motion_integral(abs(Q))
        left, right = min(base.contact[0], state.contact[0]), max(base.contact[1], state.contact[1])
        for side in ((left, state.stick[0]), (state.stick[1], right)):
            x, weight = smooth_rule(*side, [*base.breaks, *base.contact, *state.contact])
            p, q = state.tractions(x) + base.tractions(x)
            u_x, u_y = state.displacements(x) - base.displacements(x)
            work -= weight @ (q * u_x + p * u_y) / 2
        return float(work)


def stick_compliance(problem, half):
    """How far the indenter moves with Q just after a turn: d delta_x / dQ at constant P, in units of ``Problem``.

    The contact of half-width ``half`` sticks everywhere then.
    With D = d/sqrt(bk gk) the rates phi = sqrt(bk/gk) dp/dQ + i dq/dQ make R*phi + i D O*phi constant. As with friction
    (``edge_exponent``), which is imaginary here, phi is i C (1+t)^(e-1) (1-t)^(conj(e)-1), with e = (1+k)/2 + i epsilon
    (``oscillation``); C from the integral of phi. delta_x is u_x at the right edge, where the integrals are beta
    functions: with s = e^(kG) = (2 half)^-k Γ(1+k) Γ(conj(e)-k)/Γ(conj(e)) it is gk [(Re s - 1)/k - D Im s].
    """
    if problem.regular:
        return _compliance_of_layers(problem, half)
    k = problem.k
    D = problem.d / np.sqrt(problem.bk * problem.gk)
    conjugate = (1 + k) / 2 - 1j * oscillation(problem)
    if abs(k) < SMALL_K:
        t, weight = gauss_rule(NODES)
        G = weight @ (digamma(1 + k * t) - digamma(conjugate - k * t))
    else:
        G = (loggamma(1 + k) + loggamma(conjugate - k) - loggamma(conjugate)) / k
    G -= np.log(2 * half)
    even = np.expm1(k * G).real / k if k else G.real
    return float(problem.gk * (even - D * np.exp(k * G).imag))


def _compliance_of_layers(problem, half):
    """The same with layers: just after pressing to this half-width without friction, continued to Q = 0."""
    height, slope, P = problem.height, problem.slope, WithoutFriction(problem, half).load
    problem = replace(problem, height=lambda x: height(x) / P, slope=lambda x: slope(x) / P)
    solver, t = EdgeSolver(WithoutFriction(problem, half), problem.mu), problem.mu * np.array(JUST_AFTER)
    moved, edges = [], guess.uncoupled(problem.k, problem.mu, t[0], half)
    for load in t:
        state, edges = solver.state(load, edges)  # these variables change little with the load
        moved.append(state.delta_x)
    return float(np.linalg.solve(np.stack([np.ones_like(t), t, t * np.log(t), t**2], axis=1), moved / t)[0])
