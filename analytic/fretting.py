"""Fretting between Q_A and -Q_A at constant normal load: equations (51), (52) and [X4], [X5]."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from .partial_slip import PartialSlip
from .special import log_remainder

BEYOND_END = 1e-14  # a load beyond the end of a branch by this share of Q_A is taken as the end


class Loop(ABC):
    """Fields on the branches of a loop: those of the last turn plus twice those of half the step since, [X5], [X7].

    amplitude: the state at Q_A. branch is 'initial', 'unloading' or 'reloading'.
    """

    amplitude: Any

    @abstractmethod
    def step(self, Q, branch):
        """State under Q on the initial branch, else under half the step since the turn."""

    @property
    def c(self):
        """Half-width of the zone that sticks throughout the cycle [length], (34), (48)."""
        return self.amplitude.c

    def traction(self, x, Q, branch):
        """Tangential traction [stress] at the load Q on a branch."""
        return self._since_turn(Q, branch, lambda state: state.traction(x))

    def slip(self, x, Q, branch):
        """Slip from the unloaded state [length] at the load Q on a branch."""
        return self._since_turn(Q, branch, lambda state: state.slip(x))

    def energy_density(self, x):
        """Energy dissipated per cycle and area, w(x) = 4 q h_x at Q_A [stress x length], (51)."""
        return 4 * self.amplitude.traction(x) * self.amplitude.slip(x)

    def _since_turn(self, Q, branch, field):
        step = self.step(Q, branch)
        if branch == "initial":
            return field(step)
        turn = 1 if branch == "unloading" else -1
        return turn * field(self.amplitude) + 2 * field(step)


@dataclass(frozen=True)
class FrettingLoop(Loop):
    """Initial loading 0 -> Q_A, unloading Q_A -> -Q_A, reloading -Q_A -> Q_A at constant P.

    The fields take x of any shape and, for a CylinderContact, Q of any shape as well (broadcast with
    x). A load outside the branch raises ValueError.
    """

    amplitude: PartialSlip

    @classmethod
    def from_load(cls, contact, mu, Q_A=None, z=None):
        """Loop of amplitude Q_A, 0 <= Q_A < mu P, or by z = 1 - Q_A/(mu P), 0 < z <= 1."""
        if Q_A is not None and not Q_A >= 0:
            raise ValueError(f"Q_A = {Q_A!r} is outside the admissible range 0 <= Q_A < mu P")
        return cls(PartialSlip.from_load(contact, mu, Q_A, z))

    @property
    def contact(self):
        """Normal contact that carries the loop."""
        return self.amplitude.contact

    @property
    def mu(self):
        """Coefficient of friction."""
        return self.amplitude.mu

    @property
    def Q_A(self):
        """Amplitude of the tangential line load [stress x length]."""
        return self.amplitude.Q

    @property
    def a(self):
        """Contact half-width [length]."""
        return self.amplitude.a

    @property
    def dissipated_energy(self):
        """Energy per cycle and thickness, 8 ∫_c^a q h_x dx [stress x length²], (52), [X4]."""
        work = self.contact.slip_work(self.amplitude.log_ratio)
        return self.mu**2 * self.contact.solid.alpha * work

    def active_half_width(self, Q, branch):
        """Half-width d of the zone that has stuck since the last turn [length], [X5]."""
        return self.step(Q, branch).c

    def traction_within(self, x, Q, branch):
        """∫_{-x}^{x} of the traction [stress x length]; odd in x, ±Q beyond ±a."""
        return self._since_turn(Q, branch, lambda state: state.traction_within(x))

    def rigid_shift(self, Q, branch):
        """Displacement delta_x of |x| < c [length] at Q on a branch, (40), [X5]. k > 0 only."""
        return self._since_turn(Q, branch, lambda state: state.rigid_shift)

    def step(self, Q, branch):
        """Partial slip under Q on the initial branch, else under half the step since the turn."""
        Q_A = self.Q_A
        branches = {"initial": (0.0, Q_A), "unloading": (Q_A, -Q_A), "reloading": (-Q_A, Q_A)}
        if branch not in branches:
            raise ValueError(f"branch = {branch!r} is not one of {tuple(branches)}")
        start, end = branches[branch]
        low, high = min(start, end), max(start, end)
        Q, margin = np.asarray(Q, dtype=float)[()], BEYOND_END * Q_A
        if not np.all((Q >= low - margin) & (Q <= high + margin)):
            raise ValueError(f"Q = {Q!r} is outside the {branch} branch, {low!r} <= Q <= {high!r}")
        Q = np.clip(Q, low, high)
        share = 1 if branch == "initial" else 0.5
        limit, step = self.mu * self.contact.P, share * (Q - start)
        # where the loop nearly slides, z and the load still to come give 1 - ratio more accurately
        ratio, rest = np.abs(step) / limit, self.amplitude.z + share * np.abs(end - Q) / limit
        log_ratio = log_remainder(ratio, np.log(rest))
        return PartialSlip(self.contact, self.mu, step, log_ratio)


class TangentiallyLoaded:
    """What follows when Q acts on a normal contact: the base of CylinderContact and ProfileContact."""

    def partial_slip(self, mu, Q=None, z=None):
        """State under a monotone load Q [stress x length], |Q| < mu P, or by z = 1 - Q/(mu P)."""
        return PartialSlip.from_load(self, mu, Q, z)

    def fretting(self, mu, Q_A=None, z=None):
        """Loop between ±Q_A [stress x length], 0 <= Q_A < mu P, or by z = 1 - Q_A/(mu P)."""
        return FrettingLoop.from_load(self, mu, Q_A, z)
