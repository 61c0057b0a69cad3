"""Exact fields of a contact after any history of the loads P and Q, without coupling (or at the Holl ratio).

The method of dimensionality reduction: independent springs on the axis, stuck or at mu times their normal force. What
they remember is the polyline of `load_memory`, so that there are no load steps: lines in the plane of P and Q are
followed exactly, for every -1 < k < 1 and every convex profile. At constant P it is [X5].
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import log

import numpy as np

from .checks import require, require_positive_k
from .cylinder import CylinderContact
from .load_memory import LoadMemory
from .normal import ProfileContact
from .profile import load_of
from .quadrature import nodes_for, one_sided_rule
from .special import punch_rigid_factor


@dataclass(frozen=True)
class SpringState:
    """Contact after a history of the loads; fields take x of any shape and return that shape.

    path: the SpringPath. memory: its LoadMemory. dissipated_energy: since first contact, per thickness
    [stress x length²].
    """

    path: "SpringPath"
    memory: LoadMemory
    dissipated_energy: float

    @property
    def P(self):
        """Normal line load [stress x length]."""
        return float(self.memory.P[-1])

    @property
    def Q(self):
        """Tangential line load [stress x length]."""
        return float(self.memory.Q[-1])

    @cached_property
    def contact(self):
        """Normal contact under P."""
        return self.path.contact_under(self.P)

    @property
    def contact_half_width(self):
        """a [length]."""
        return self.contact.a

    @property
    def stick_half_width(self):
        """Half-width of the zone that stuck during the last change of the loads [length]: c, d of [X5], or a."""
        return self.path.contact_under(self.memory.stick).a

    @property
    def half_width_below_limit(self):
        """Half-width of the zone where |q| < mu p [length]; more than that sticks where loads go back as they came."""
        load = self.memory.below_limit
        return self.path.contact_under(load).a if load else 0.0

    def pressure(self, x):
        """p(x) [stress], (7)."""
        return self.contact.pressure(x)

    def traction(self, x):
        """q(x) [stress], (18), on the half-plane along +x for Q > 0."""
        return self._sum(x, "pressure", "pressure_difference")

    def traction_within(self, x):
        """∫_{-x}^{x} q dx [stress x length]; odd in x, ±Q beyond ±a."""
        return self._sum(x, "pressure_within", "pressure_difference_within")

    def slip(self, x):
        """Relative displacement h_x = delta_x - u_x(x) since tangential loading began [length], (21).

        Its sign is that of `FrettingLoop.slip`: positive where the surface stays behind under Q > 0. A point that
        came into contact while Q acted has the h_x with which it came, even if it has stuck ever since. For
        |x| > a it is the displacement of the free surface behind the stick zone.
        """
        shift = self._sum(x, "relative_displacement", "relative_displacement_difference")
        return self.path.contact.solid.alpha * shift

    @property
    def rigid_shift(self):
        """Displacement delta_x of the indenter [length], (39), (40). k > 0 only."""
        require_positive_k(self.path.contact.solid.k, "the displacement delta_x")
        depths = np.array([self.path.contact_under(P).indentation if P else 0.0 for P in self.memory.P])
        return self.path.contact.solid.alpha * float(self._ratios @ np.diff(depths))

    @property
    def _ratios(self):
        return np.diff(self.memory.Q) / np.diff(self.memory.P)

    def _sum(self, x, field, difference):
        """Σ r [field(x; P_i) - field(x; P_{i-1})], each of them by the method ``difference``."""
        total, loads = np.zeros(np.shape(x)), self.memory.P
        for r, low, high in zip(self._ratios, loads[:-1], loads[1:], strict=True):
            contact = self.path.contact_under(high)
            if not r:  # 0 times an infinite pressure is none
                continue
            if low == 0:
                total = total + r * getattr(contact, field)(x)
            else:
                total = total + r * getattr(contact, difference)(x, log(low / high))
        return total[()]


@dataclass(frozen=True)
class SpringPath:
    """Histories of the loads of one contact.

    contact: a CylinderContact or ProfileContact, of which solid and profile count, and not the load; ValueError where
    its profile ends before it carries a load. mu: friction coefficient, positive, else ValueError.
    """

    contact: CylinderContact | ProfileContact
    mu: float

    def __post_init__(self):
        require("mu", self.mu)

    def run(self, loads: Iterable[tuple[float, float]]) -> list[SpringState]:
        """State after every load (P, Q) [stress x length], reached along straight lines from (0, 0), no contact.

        Raises ValueError for P <= 0 and |Q| >= mu P, gross slip.
        """
        memory, energy, states = LoadMemory.unloaded(self.mu), 0.0, []
        for P, Q in loads:
            before, memory = memory, memory.advanced(float(P), float(Q))
            energy += self._dissipated(before, memory)
            states.append(SpringState(self, memory, energy))
        return states

    def contact_under(self, P):
        """The contact under the load P [stress x length]."""
        return _under(self.contact, P)

    def _dissipated(self, before, after):
        """∫ p |dh_x| dx between two memories [stress x length²], over the half-widths of the punches that slip."""
        breaks, solid, profile = before.breaks(after), self.contact.solid, self.contact.profile
        flat, total = profile.flat, 0.0
        for low, high in zip(breaks[:-1], breaks[1:], strict=True):
            ends = [self.contact_under(load).a - flat for load in (low, high)]
            span = np.log(ends[1] / ends[0])
            t, weight = one_sided_rule(0.0, nodes_for(span))
            width = ends[0] * np.exp(span * t)
            s = flat + width
            work = before.slip_work(load_of(solid, profile, s), after.P[-1], after.Q[-1])
            total += span * np.sum(weight * width * s ** (-1 - solid.k) * work)
        return solid.tangential_compliance * punch_rigid_factor(solid.k) * total


@lru_cache(maxsize=1024)
def _under(contact, P):
    return contact.under(P)
