"""Fretting while the body is stretched along the surface, as in fretting fatigue: [X7].

The body carries the uniform strain eps beside the contact: u_x = eps x, tension positive. Normal
contact does not feel it. A parabola moved aside differs from itself by a straight line, so that the
stick zone keeps its width and moves by e = eps R/(mu alpha). Exact where normal and tangential
problem are uncoupled.
"""

from dataclasses import dataclass

import numpy as np

from .checks import require
from .cylinder import CylinderContact
from .fretting import BEYOND_END, FrettingLoop, Loop
from .partial_slip import PartialSlip
from .point_force import point_force_stress
from .quadrature import nodes_for, plain_rule
from .special import parabolic_gap


@dataclass(frozen=True)
class StretchedPartialSlip:
    """Partial slip (25), (26) of the cylinder when Q and the strain have grown together from zero.

    state: the same without strain; strain: eps [1], of any shape that broadcasts with state.Q. The
    range of validity is that of ``StretchedLoop``, which checks it.
    """

    state: PartialSlip
    strain: float

    @property
    def contact(self) -> CylinderContact:
        """Normal contact; StretchedLoop refuses others."""
        return self.state.contact

    @property
    def c(self):
        """Half-width of the stick zone [length], from Q as without strain, (48)."""
        return self.state.c

    @property
    def shift(self):
        """Centre of the stick zone e = eps R/(mu alpha) [length], for Q < 0 its negative, [X7]."""
        contact = self.contact
        return self._direction * self.strain * contact.R / (self.state.mu * contact.solid.alpha)

    def traction(self, x):
        """Tangential traction [stress], q(x) = mu (p(x, a) - p(x - e, c)), [X7]."""
        return self._direction * self.state.mu * self._difference(self.contact.pressure_difference, x)

    def slip(self, x):
        """h_x(x - e) [length] with h_x of (50), zero in the stick zone, [X7].

        For |x| > a it is the displacement of the free surface, stretched as it is, from the zone.
        """
        return self._displaced(self.contact.relative_displacement_difference, x)

    def surface_strain(self, x):
        """du_x/dx of the surface [1] by q and the strain, in contact -dh_x/dx at x - e, [X3]. Tension positive.

        It is 0 in the stick zone and largest at the trailing edge x = -a, for k = 0 mu/R times the root of
        (a + e)² - c². Off the Holl ratio p strains the surface too; that is not in it.
        """
        return -self._displaced(self.contact.gradient_difference, x)

    def stress_xx(self, x, y, nodes=800):
        """sigma_xx [stress] at x, depth y > 0 (broadcast) under p(x, a), this q(x) and the strain, tension positive.

        By superposition of line forces, ``nodes`` on each of the zones of slip and stick: good for depths y above
        some a/nodes.
        """
        contact, solid = self.contact, self.contact.solid
        a, e, c = contact.a, float(self.shift), float(self.c)
        ends = np.array([-a, e - c, e + c, a])
        angle = np.pi * ((np.arange(nodes) + 0.5) / nodes - 0.5)  # in which powers at the ends do little harm
        half = np.diff(ends)[:, None] / 2
        s = (ends[:-1, None] + half * (1 + np.sin(angle))).ravel()
        weight = (half * np.pi / nodes * np.cos(angle)).ravel()
        P, Q = weight * contact.pressure(s), weight * self.traction(s)
        x, y = np.broadcast_arrays(np.asarray(x, float)[..., None], np.asarray(y, float)[..., None])
        of_forces = point_force_stress(solid, x - s, y, P, Q)[0].sum(axis=-1)
        return of_forces + solid.modulus(y[..., 0]) * self.strain / ((1 - solid.nu) * (1 + solid.nu))

    @property
    def work(self):
        """∫ mu p(x, a) |h_x(x - e)| dx [stress x length²], lost where points slid all along."""
        contact, k = self.contact, self.contact.solid.k
        e, c = float(self.shift), float(self.c)
        width, total = contact.lost_width(self.state.log_ratio), 0.0
        for side in (1, -1):  # over ln |x - e|, from the edge of stick to the edge of contact
            reach, span = contact.a - side * e, np.log1p(max(width - side * e, 0.0) / c)
            t, rest, weight = plain_rule((3 - k) / 2, (1 + k) / 2, nodes_for(span))
            distance, to_edge = c * np.exp(span * t), -reach * np.expm1(-span * rest)
            depth = to_edge / contact.a * ((2 * contact.a - to_edge) / contact.a)
            gap = distance**2 / (2 * contact.R)
            gap *= parabolic_gap(distance, c, k, c * np.expm1(span * t))
            total += span * np.sum(weight * distance * depth ** ((1 + k) / 2) * gap)
        return self.state.mu**2 * contact.solid.alpha * contact.peak_pressure * total

    @property
    def _direction(self):
        return np.copysign(1.0, self.state.Q)

    def _difference(self, field, x):
        return field(x, self.state.log_ratio, self.shift)

    def _displaced(self, field, x):
        return self._direction * self.state.mu * self.contact.solid.alpha * self._difference(field, x)


@dataclass(frozen=True)
class StretchedLoop(Loop):
    """Fretting loop of the cylinder with strain: 0 -> Q_A together with 0 -> strain, then the cycle.

    loop: the same without strain; strain: its value at +Q_A [1], tension positive, eps = strain Q/Q_A throughout.
    Fields take x of any shape and Q of any shape (broadcast with x).

    Raises ValueError for another profile, and where one edge of the stick zone does not recede
    while Q grows: |strain| > ``largest_strain``. Below it the stick zone stays in the contact.
    """

    loop: FrettingLoop
    strain: float

    def __post_init__(self):
        if not isinstance(self.loop.contact, CylinderContact):
            raise ValueError(
                "the closed form with bulk strain is for the parabola: another profile that is "
                "moved aside does not differ from itself by a straight line"
            )
        require("strain", self.strain, -np.inf)
        if abs(self.strain) > self.largest_strain * (1 + BEYOND_END):
            raise ValueError(
                f"strain = {self.strain!r} is outside the range of the closed form, |strain| <= "
                f"alpha a Q_A/((2+k) P R) = {self.largest_strain!r}: beyond it one edge of the "
                "stick zone does not recede as Q grows"
            )

    @property
    def largest_strain(self):
        """alpha a Q_A/((2+k) P R) [1]: up to it both edges of stick recede from Q = 0 on, [X7]."""
        contact = self.loop.contact
        alpha, k = contact.solid.alpha, contact.solid.k
        return alpha * contact.a / contact.R * (self.loop.Q_A / contact.P) / (2 + k)

    @property
    def amplitude(self):
        """The state at +Q_A, a StretchedPartialSlip."""
        return StretchedPartialSlip(self.loop.amplitude, self.strain)

    @property
    def shift(self):
        """Centre e of the stick zone at +Q_A [length], [X7]."""
        return self.amplitude.shift

    def zone(self, Q, branch):
        """Centre and half-width [length] of the zone that has stuck since the last turn of Q."""
        step = self.step(Q, branch)
        return step.shift, step.c

    @property
    def dissipated_energy(self):
        """Energy per cycle and thickness, the integral of the density [stress x length²], [X7]."""
        return self.loop.dissipated_energy if self.strain == 0 else 4 * self.amplitude.work

    def dissipated(self, Q, branch):
        """Energy per thickness lost on a branch up to the load Q, a number [stress x length²]."""
        step = self.step(Q, branch)
        if step.state.Q == 0:
            return 0.0
        return (1 if branch == "initial" else 2) * step.work

    def step(self, Q, branch):
        """StretchedPartialSlip under Q on the initial branch, else under half the step since the turn."""
        state = self.loop.step(Q, branch)
        share = state.Q / self.loop.Q_A if self.loop.Q_A else 0.0
        return StretchedPartialSlip(state, self.strain * share)
