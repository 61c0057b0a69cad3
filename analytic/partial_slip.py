"""Partial slip at constant P under a monotone tangential load: (25)-(36), (40), (47)-(50).

By the Ciavarella-Jäger theorem every tangential field is mu, or mu alpha, times the difference of
two normal contacts: the actual one and the one whose half-width is the stick half-width c.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from .checks import require
from .special import log_remainder


@dataclass(frozen=True)
class PartialSlip:
    """Stick for |x| < c, slip for c < |x| < a, (25), (26), after loading from 0 to Q at constant P.

    contact: a CylinderContact or ProfileContact; its methods that end in _difference compare it with
    itself under the load e^log_ratio P. Q: tangential line load [stress x length]. log_ratio: ln(1 - |Q|/(mu P)),
    which by (34) is the logarithm of P(c)/P(a); it keeps the digits of Q near 0 and of mu P - Q near full slip.
    """

    contact: Any
    mu: float
    Q: float
    log_ratio: float

    @classmethod
    def from_load(cls, contact, mu, Q=None, z=None):
        """State under Q, |Q| < mu P, or under a positive load by z = 1 - Q/(mu P), 0 < z <= 1."""
        require("mu", mu)
        if (Q is None) == (z is None):
            raise ValueError("give exactly one of the tangential load and z = 1 - Q/(mu P)")
        limit = mu * contact.P
        if z is not None:
            require("z", z, 0, 1, closed_high=True)
            return cls(contact, mu, limit * (1 - z), np.log(z))
        if not abs(Q) < limit or (left := _exact_difference(mu, contact.P, abs(Q))) <= 0:
            raise ValueError(f"Q = {Q!r} is outside the admissible range |Q| < mu P = {limit!r}")
        ratio = abs(Q) / limit
        return cls(contact, mu, Q, log_remainder(ratio, np.log(left / limit)))

    @property
    def a(self):
        """Contact half-width [length]."""
        return self.contact.a

    @property
    def c(self):
        """Stick half-width [length], from (34); (48) for the cylinder."""
        return self.contact.half_width(self.log_ratio)

    @property
    def z(self):
        """1 - |Q|/(mu P)."""
        return np.exp(self.log_ratio)

    def traction(self, x):
        """Tangential traction [stress], q(x) = mu (p(x,a) - p(x,c)), (33), (47)."""
        return self._direction * self.mu * self.contact.pressure_difference(x, self.log_ratio)

    def traction_within(self, x):
        """∫_{-x}^{x} q dx [stress x length]; odd in x, ±Q beyond ±a."""
        difference = self.contact.pressure_difference_within(x, self.log_ratio)
        return self._direction * self.mu * difference

    def slip(self, x):
        """Slip [length], h_x(x) = mu alpha (f(x) - h_y(x,c)), zero in the stick zone, (36), (50).

        For |x| > a it is the displacement of the free surface relative to the stick zone, (21),
        with h_y(x,a) in place of f.
        """
        return self._shift(self.contact.relative_displacement_difference(x, self.log_ratio))

    def slip_gradient(self, x):
        """dh_x/dx [1], [X3]; odd in x."""
        return self._shift(self.contact.gradient_difference(x, self.log_ratio))

    @property
    def rigid_shift(self):
        """Displacement delta_x of the stick zone [length], (40), (49). k > 0 only."""
        return self._shift(self.contact.indentation_difference(self.log_ratio))

    @property
    def _direction(self):
        return np.copysign(1.0, self.Q)

    def _shift(self, normal_displacement):
        return self._direction * self.mu * self.contact.solid.alpha * normal_displacement


def _exact_difference(mu, P, Q):
    """mu P - Q with a single rounding, however close to full slip."""
    return float(Fraction(float(mu)) * Fraction(float(P)) - Fraction(float(Q)))
