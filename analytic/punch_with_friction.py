"""Flat punch pressed on a half-plane with friction and coupling [X6]: the increment of every self-similar contact.

While an indenter is pressed on from first contact, its contact of half-width 1 grows by flat punches: between -1 and 1
the normal displacement of the increment is constant, for |x| < c nothing moves along x, and for c < |x| < 1 the
traction is mu times the pressure. The traction of the increment must be finite at c, or points would slip back before
they stick; that fixes c, which therefore depends on k, nu and mu alone (Mossakovskii, Spence).
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from math import ceil, exp, log, pi

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipkm1

from .edge_exponents import edge_exponent
from .quadrature import gauss_rule
from .singular_panels import SingularPanels

TERMS, COARSE = 10, 8  # of the polynomial on a panel; for the first guess
RATIO = 0.25  # of the widths of neighbouring panels
PANEL_AT_C = 1e-5  # width of the panels at c over that of the zone of stick or slip
OVERSAMPLING = 4  # collocation points per panel beyond TERMS
ROOT = 1e-10  # of ln(c/(1-c))
EXTREME = 40.0  # largest |ln(c/(1-c))|: beyond it everything slips, or everything sticks
LOAD_MET = 1e-3  # error of the load beyond which c is a chance zero: it is 3e-5 at most at others, 4e-3 or more there


@dataclass(frozen=True)
class Medium:
    """k, (bk), (gk), d of [X6] and mu. d <= 0, pressure drags the surface inwards; the rest is its mirror image."""

    k: float
    bk: float
    gk: float
    d: float
    mu: float

    def edge_power(self, sign):
        """Power of the distance from an edge in a singular solution, in (-1, 0); in (0, 1) for sign 1 and k > 0, or
        sign -1 and k < 0, where friction is so strong that mu |d k| > (bk): there it is not singular.

        One less than ``edge_exponent``. sign 1: of p at the edge of the contact, where q = mu p; sign -1: of mu p - q
        at the edge of stick. Without coupling it is (k-1)/2.
        """
        power = edge_exponent(self, sign * self.mu) - 1
        return power if power > -1 else power + 2  # a solution too: both turn the same way


@dataclass(frozen=True)
class PunchWithFriction:
    """Increment of half-width 1 and load 1 in units of E0 = y0 = 1 with stick for |x| < c = 1/(1 + e^-logit).

    The pressure p is even, the traction q = mu p - r odd, r = 0 in the zone of slip; x > 0 in what follows.
    sticks: False if r = 0 everywhere; c then only tells how finely p is resolved at x = 0.
    """

    medium: Medium
    logit: float
    terms: int = TERMS
    sticks: bool = True

    @cached_property
    def c(self):
        """Stick half-width."""
        return 1 / (1 + exp(-self.logit))

    @cached_property
    def slip_width(self):
        """1 - c."""
        return 1 / (1 + exp(self.logit))

    @cached_property
    def pressure_panels(self):
        """Panels of p on (0, 1)."""
        c, w = self.c, self.slip_width
        inner, outer = _graded(c, PANEL_AT_C * min(c, w)), _graded(w / 2, PANEL_AT_C * min(c, w))[::-1]
        lo, hi = np.concatenate([-inner, [0.0], outer]), np.concatenate([-inner[1:], [0.0], outer, [w]])
        return SingularPanels(c, lo, hi, self.medium.edge_power(1), self.terms, self.medium.k)

    @cached_property
    def reserve_panels(self):
        """Panels of r = mu p - q on (0, c)."""
        p = self.pressure_panels
        inner = p.hi <= 0
        return replace(p, lo=p.lo[inner], hi=p.hi[inner], power=self.medium.edge_power(-1))

    def displacement_gradients(self, y, owner):
        """u_y' and u_x' at x = c + y as matrices on the coefficients of p and r, each (len(y), unknowns)."""
        m = self.medium
        odd, even, mirror = self.pressure_panels.moments(y, owner)
        friction = self.reserve_panels.moments(y, owner)
        normal = np.hstack([-m.bk * (odd + mirror) + m.mu * m.d * (even - m.k * mirror),
                            -m.d * (friction[1] - m.k * friction[2])])
        tangential = np.hstack([-m.mu * m.gk * (odd - mirror) - m.d * (even + m.k * mirror),
                                m.gk * (friction[0] - friction[2])])
        return normal, tangential

    @cached_property
    def _solution(self):
        """Coefficients of p and r by least squares: u_y' = 0 in contact, u_x' = 0 in stick, ∫ p dx = 1.

        An equation at a panel of width h counts like h^((1-k)/2), a little less, for tractions ~ h^((k-1)/2).
        """
        panels, k = self.pressure_panels, self.medium.k
        t, weight = gauss_rule(self.terms + OVERSAMPLING)
        owner = np.repeat(np.arange(len(panels.lo)), len(t))
        width = panels.width[owner]
        y = panels.lo[owner] + width * np.tile(t, len(panels.lo))
        normal, tangential = self.displacement_gradients(y, owner)
        importance = (width ** (k + (1 - k) / 2 + 0.15) * np.tile(np.sqrt(weight), len(panels.lo)))[:, None]
        stick = y < 0
        load = np.zeros(normal.shape[1])
        for j in range(len(panels.lo)):
            from_lo, to_hi, weight = panels.nodes(j)
            load[j * self.terms : (j + 1) * self.terms] = 2 * weight @ panels.basis(j, from_lo, to_hi)
        A = np.vstack([importance * normal, importance[stick] * tangential[stick], load])
        if not self.sticks:
            A[:, panels.lo.size * self.terms :] = 0
            A[len(y) : -1] = 0
        size = np.linalg.norm(A, axis=0)
        used = size > 0
        Q, triangle = np.linalg.qr(A[:, used] / size[used])
        solution = np.zeros(size.shape)
        solution[used] = np.linalg.solve(triangle, Q[-1]) / size[used]
        return solution

    @property
    def load(self):
        """∫ p dx, 1 where all equations are met."""
        panels = self.pressure_panels
        parts = ((j, *panels.nodes(j)) for j in range(len(panels.lo)))
        return sum(2 * weight @ self.pressure(j, from_lo, to_hi) for j, from_lo, to_hi, weight in parts)

    @cached_property
    def pressure_terms(self):
        """Coefficients of p, shape (panels, terms)."""
        return self._solution[: len(self.pressure_panels.lo) * self.terms].reshape(-1, self.terms)

    @cached_property
    def reserve_terms(self):
        """Coefficients of r, shape (panels, terms)."""
        return self._solution[len(self.pressure_panels.lo) * self.terms :].reshape(-1, self.terms)

    def pressure(self, j, from_lo, to_hi):
        """p in panel j at the distances from its ends."""
        return self.pressure_panels.basis(j, from_lo, to_hi) @ self.pressure_terms[j]

    def traction(self, j, from_lo, to_hi):
        """q in panel j at the distances from its ends."""
        q = self.medium.mu * self.pressure(j, from_lo, to_hi)
        if j < len(self.reserve_panels.lo):
            q = q - self.reserve_panels.basis(j, from_lo, to_hi) @ self.reserve_terms[j]
        return q

    def tangential_gradient(self, y, owner):
        """u_x' at x = c + y in the panels ``owner``."""
        return self.displacement_gradients(y, owner)[1] @ self._solution

    @cached_property
    def singularity(self):
        """Strength of the singular r at c over that of its zone: positive where c is too small."""
        panels = self.reserve_panels
        last = panels.width[-1] / 2
        return self.reserve_terms[-1].sum() * (min(self.c, self.slip_width) / last) ** panels.power


def _graded(length, smallest):
    """length, RATIO length, ... down to less than ``smallest``."""
    return length * RATIO ** np.arange(ceil(log(length / smallest) / -log(RATIO)) + 1)


@lru_cache(maxsize=64)
def punch_with_friction(medium, terms=TERMS):
    """The PunchWithFriction whose traction is finite at c.

    Where friction is too weak for any zone of stick (k < 0 only), and where that of slip is too narrow for binary64,
    it is that of the logit -EXTREME or EXTREME. The latter also where k is near 1 and friction so strong that a zero is
    found only where the load is not met: the zone of slip is narrower than 1e-5 there.
    """

    @cache
    def singularity(logit):
        return PunchWithFriction(medium, logit, terms).singularity

    if terms > COARSE:
        logit, step = punch_with_friction(medium, COARSE).logit, 1e-4
    else:
        logit, step = _weakly_coupled(medium), 1.0
    direction = 1 if singularity(logit) > 0 else -1
    while abs(logit) < EXTREME or logit * direction < 0:
        last, logit = logit, min(max(logit + direction * step, -EXTREME), EXTREME)
        if singularity(logit) * direction <= 0:
            found = PunchWithFriction(medium, brentq(singularity, last, logit, xtol=ROOT), terms)
            return found if abs(found.load - 1) < LOAD_MET else PunchWithFriction(medium, EXTREME, terms)
        step *= 4
    return PunchWithFriction(medium, logit, terms, sticks=direction > 0)


def _weakly_coupled(medium):
    """ln(c/(1-c)) by K(sqrt(1-c²))/K(c) = 2|d|/(pi mu sqrt(b g) k), Spence's result for k = 0 and d -> 0."""
    ratio = 2 * abs(medium.d) / (pi * medium.mu * (medium.bk * medium.gk) ** 0.5)
    if ratio == 0:
        return EXTREME

    def excess(logit):
        c, w = 1 / (1 + exp(-logit)), 1 / (1 + exp(logit))
        return log(ellipkm1(c**2) / ellipkm1(w * (1 + c)) / ratio)

    return brentq(excess, -EXTREME, EXTREME) if excess(-EXTREME) * excess(EXTREME) < 0 else 0.0
