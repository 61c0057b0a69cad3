"""States after pressing by P alone, from which Q starts, in the units of ``Problem``."""

from dataclasses import replace
from functools import cached_property, lru_cache
from math import exp, log

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebpts1, chebvander

from ..checks import ContactNotConverged
from ..half_plane.layered_kernel import require_reach
from ..normal import half_width_where, normal_contact
from ..pressing_with_friction import PressingWithFriction
from .panels import Panels, divided, graded
from .problem import problem_of, surface_of
from .tractions import Interpolated, StateOnContact, shrinking
from .weight import ContactInterval

LEVELS, RATIO = 15, 0.4  # of the panels on which the pressure without friction is integrated
STEP = 0.5  # of the logarithm of a half-width that is sought
NARROW = 1e-6  # width of slip over a below which all sticks; next to the Holl ratio it is exponentially narrow


class WithoutFriction(StateOnContact):
    """Frictionless contact for -half < x < half, under the load that this takes.

    problem: the tangential problem that follows; contact: edges; breaks: where tractions are not smooth, nowhere; Q,
    delta_x, delta_y: load and displacements; dissipated_energy: until now [stress x length²].
    """

    breaks = np.empty(0)
    Q = delta_x = dissipated_energy = 0.0

    def __init__(self, problem, half=1.0):
        self.problem, self.contact = problem, (-half, half)
        self._interval = ContactInterval(problem, 0.0, *self.contact)

    @cached_property
    def _smooth(self):
        """p/w, a Chebyshev series: what layers add to u_y acts like a height of the profile."""
        (D, _), problem = self._interval.of_profile(), self.problem
        if problem.terms:
            t, panels, interval = chebpts1(problem.terms), self._panels, self._interval
            x = panels.nodes
            of_p = problem.of_layers(interval.half * t, x)[0] * panels.weights
            if problem.kinks is not None:
                of_p += problem.kinks[0] * (interval.half * t[:, None] - x) * panels.matrices(interval.half * t, 0.0)[1]
            of_p *= interval.weight(x)
            D_layers, _ = interval.of_heights(problem.terms)
            s = interval.local(x)[0]
            A = chebvander(t, problem.terms - 1) - of_p @ chebvander(s, len(D_layers) - 1) @ D_layers
            D = D + Chebyshev(D_layers @ np.linalg.solve(A, of_p @ D(s)))
        return D

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        p = self._interval.weight(x) * self._smooth(self._interval.local(x)[0])
        return np.stack([p, np.zeros_like(p)])

    @cached_property
    def load(self):
        """∫ p, over the load of the problem."""
        return float(self._panels.weights @ self.tractions(self._panels.nodes)[0])

    @cached_property
    def _panels(self):
        return Panels.between(divided(graded(*self.contact, LEVELS, LEVELS, RATIO), self.problem.longest))

    @cached_property
    def delta_y(self):
        """Displacement of the profile's tip."""
        return float(self._integrals(np.zeros(1))[1, 0])


class NormalStage(WithoutFriction):
    """Frictionless contact under P, for a cylinder or power profile on a GradedHalfPlane or LayeredKernel."""

    def __init__(self, solid, profile, P, mu, coupling, order):
        def problem(a):
            return problem_of(solid, profile, P, mu, coupling, order, a)

        self.solid, self.P = surface_of(solid), P
        self.a = normal_contact(self.solid, profile, P).a
        if self.solid is not solid:

            def excess(log_a):
                return log(WithoutFriction(problem(exp(log_a))).load)

            self.a = half_width_where(excess, log(self.a), STEP, xtol=1e-13)
            require_reach(solid, 2 * self.a)
        super().__init__(problem(self.a))


class PressedWithFriction(StateOnContact):
    """Contact with friction from first contact, exact: slip of both signs beside ``stick``. See ``NormalStage``.

    Raises ContactNotConverged where every point slips.
    """

    contact = (-1.0, 1.0)
    Q = delta_x = 0.0

    def __init__(self, solid, profile, P, mu, order):
        self.solid, self.P = solid, P
        exact = PressingWithFriction(solid, profile, mu, P)
        c = exact.stick_ratio
        if not c:
            raise ContactNotConverged("every point slips while P grows")
        self.a, self.dissipated_energy = exact.contact_half_width, exact.dissipated_energy
        self.problem = problem_of(solid, profile, P, mu, True, order, self.a)
        self.stick, self.breaks = (-c, c), _breaks(c)
        self._alike = replace(exact, P=1.0)

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        return np.where(np.abs(x) < 1, _self_similar(self._alike)(np.clip(x, -1.0, 1.0)), 0.0)

    delta_y = WithoutFriction.delta_y

    @property
    def goes_on(self):
        """Direction of Q in which the points of the right zone of slip go on; 0 at the Holl ratio, where none slip."""
        return -np.sign(self.problem.d)


def _breaks(c):
    """Where tractions are not smooth: p is like |x|^(m+k-1) in the middle."""
    return np.array([-c, 0.0, c] if c < 1 - NARROW else [0.0])


@lru_cache(maxsize=4)
def _self_similar(exact):
    """p and q as functions of x in the units of ``Problem``, in which they are the same under every load.

    Interpolated, as each exact value takes as long as a hundred of these.
    """
    panels, a = shrinking([-1.0, *_breaks(exact.stick_ratio), 1.0], exact.solid.k), exact.contact_half_width
    x = a * panels.nodes
    return Interpolated(panels, np.stack([exact.pressure(x), exact.traction(x)]) * a / exact.P)
