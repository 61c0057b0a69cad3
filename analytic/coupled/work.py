"""Work that friction takes between two turns of the tangential load, from the balance of energy."""

from functools import cached_property

import numpy as np
from numpy.polynomial import Chebyshev

from .branch import Branch
from .full_stick import stick_compliance
from .panels import gauss

BEYOND = 0.3  # logarithm of the load over which the motion is continued to the turn
LOAD_NODES = 24  # of the integral over the loads


class FrictionalWork:
    """Work of friction on a branch, in the units of ``Problem``."""

    def __init__(self, branch: Branch):
        self._branch = branch
        left, right = branch.base.contact
        self._stuck = stick_compliance(branch.problem, (right - left) / 2)

    @cached_property
    def _softening(self):
        """(delta_x since the turn / load - that in full stick) / load, a function of ``Branch.variable`` for each of
        the ``parts``; it changes like the logarithm of the load just after the turn."""
        branch, functions = self._branch, []
        for nodes in branch.nodes:
            t, delta_x = branch.between(nodes[0], nodes[-1])
            moved = branch.direction * (delta_x - branch.base.delta_x)
            v = branch.variable(t)
            values = (moved / t - self._stuck) / t
            functions.append(Chebyshev.fit(v, values, min(len(t), len(nodes)) - 1, domain=[v[0], v[-1]]))
        return functions

    def _motion_integral(self, load):
        """∫ (distance of the indenter since the turn) over the load, from the turn."""
        branch, (g, w) = self._branch, gauss(LOAD_NODES)
        total = self._stuck * load**2 / 2
        for low, high, function in zip(branch.parts, branch.parts[1:], self._softening, strict=False):
            high = min(high, load)
            if low == 0:  # up to the first known state as a parabola over the logarithm of the load
                low = min(branch.first, load)
                u = np.array([0.0, BEYOND / 2, BEYOND])
                parabola = np.polyfit(u, function(branch.variable(branch.first * np.exp(u))), 2)
                u = np.log(low / branch.first)
                total += low**3 / 3 * (parabola @ [u**2 - 2 * u / 3 + 2 / 9, u - 1 / 3, 1])
            if high > low:
                t = low + (high - low) * (1 + g) / 2
                total += (high - low) / 2 * (w @ (t**2 * function(branch.variable(t))))
        return total

    def at(self, state):
        """Work of friction from the turn to a ``state`` of the branch.

        Work of Q, less that stored: half of (tractions at the turn + tractions now) times the displacements since then.
        Where the contact sticks these are the indenter's; elsewhere slip and gap are left.
        """
        base = self._branch.base
        Q = state.Q - base.Q
        work = Q * (state.delta_x - base.delta_x) / 2 - self._motion_integral(abs(Q))
        for x, weight, moved in self._branch.moved(state):
            p, q = state.tractions(x) + base.tractions(x)
            work -= weight @ (q * moved[0] + p * moved[1]) / 2
        return float(work)
