"""States after pressing by P alone, from which Q starts, in the units of ``Problem``."""

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from ..checks import ContactNotConverged
from ..normal import normal_contact
from ..pressing_with_friction import PressingWithFriction
from .panels import Panels, graded
from .problem import problem_of
from .tractions import Interpolated, StateOnContact, shrinking
from .weight import ContactInterval

LEVELS, RATIO = 15, 0.4  # of the panels on which the pressure without friction is integrated
NARROW = 1e-6  # width of slip over a below which all sticks; next to the Holl ratio it is exponentially narrow


class NormalStage(StateOnContact):
    """Frictionless contact.

    problem: the tangential problem that follows; contact: edges; breaks: where tractions are not smooth, nowhere; Q,
    delta_x, delta_y: load and displacements; dissipated_energy: until now [stress x length²].
    """

    contact = (-1.0, 1.0)
    breaks = np.empty(0)
    Q = delta_x = dissipated_energy = 0.0

    def __init__(self, solid, profile, P, mu, coupling, order):
        self.solid, self.P = solid, P
        self.a = normal_contact(solid, profile, P).a
        self.problem = problem_of(solid, profile, P, mu, coupling, order, self.a)
        self._interval = ContactInterval(self.problem, 0.0, *self.contact)
        self._smooth, _ = self._interval.profile()

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        p = self._interval.weight(x) * self._smooth(x)
        return np.stack([p, np.zeros_like(p)])

    @cached_property
    def _panels(self):
        return Panels.between(graded(*self.contact, LEVELS, LEVELS, RATIO))

    @cached_property
    def delta_y(self):
        """Displacement of the profile's tip."""
        return float(self._integrals(np.zeros(1))[1, 0])


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

    delta_y = NormalStage.delta_y

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
