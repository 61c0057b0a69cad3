"""Integrals of the flat punch with friction over its half-width, of which self-similar contacts are made."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial.legendre import legfit, legval

from .punch_with_friction import PunchWithFriction
from .quadrature import gauss_rule, nodes_for, one_sided_rule, plain_rule

NODES = 12  # per panel of the zone of slip
LEVELS = 20  # of panels towards the edge of the contact, where u_x' is singular, each half as wide as the last


@dataclass(frozen=True)
class PunchFields:
    """Integrals of the fields of a PunchWithFriction; x is the distance from the centre over the half-width."""

    punch: PunchWithFriction

    def grown(self, x, power, density):
        """x^-1 ∫_x^1 density(τ) (x/τ)^power dτ for x >= 0 of any shape, zero for x >= 1.

        density(j, from_lo, to_hi): p or q of the punch in panel j at the distances from its ends.
        """
        x = np.asarray(x, dtype=float)
        flat = x.ravel()
        result = np.where(np.isnan(flat), np.nan, 0.0)
        inside = (flat > 0) & (flat < 1)
        result[inside] = self._beyond(flat[inside], 1 - flat[inside], power, density) / flat[inside]
        if (flat == 0).any():
            centre = density(0, np.zeros(1), self.punch.pressure_panels.width[:1])[0]
            result[flat == 0] = centre / (power - 1) if power > 1 and self.punch.sticks else np.inf
        return result.reshape(x.shape)[()]

    def _beyond(self, x, rest, power, density):
        """∫_x^1 density(τ) (x/τ)^power dτ for 0 < x < 1, rest = 1 - x, shape (n,)."""
        panels = self.punch.pressure_panels
        y = np.where(x < 0.5, x - panels.centre, panels.hi[-1] - rest)
        owner = np.clip(np.searchsorted(panels.lo, y, side="right") - 1, 0, len(panels.lo) - 1)
        result = np.zeros(len(x))
        for j in range(len(panels.lo)):
            own = owner == j
            if own.any():
                left, right = (y[own] - panels.lo[j])[:, None], np.maximum(panels.hi[j] - y[own], 0)[:, None]
                if j == len(panels.lo) - 1:
                    t, rest, weight = plain_rule(0.0, panels.power, nodes_for())
                    step, to_hi, weight = right * t, right * rest, right * weight
                else:  # over ln τ
                    span = np.log1p(right / x[own, None])
                    t, weight = one_sided_rule(0.0, nodes_for(span))
                    step = x[own, None] * np.expm1(span * t)
                    to_hi, weight = np.maximum(right - step, 0), span * weight * (x[own, None] + step)
                values = density(j, left + step, to_hi) * (1 + step / x[own, None]) ** -power
                result[own] += np.sum(weight * values, axis=1)
            before = owner < j
            if before.any():
                from_lo, to_hi, weight = panels.nodes(j)
                position = panels.centre + (panels.lo[j] + from_lo)
                result[before] += x[before] ** power * np.sum(weight * density(j, from_lo, to_hi) * position**-power)
        return result

    def height_slope(self, m):
        """-∫_1^∞ u_y'(x) x^-m dx of the punch: A m/K over C for the profile A|x|^m and dP = C s^(m+k-1) ds."""
        return _slopes_outside(self.punch, m)[1]

    def stick_slope(self, m):
        """∫_c^∞ u_x'(x) x^-m dx of the punch: u_x/(x|x|^(m-1)) in stick over K C/m."""
        over_slip = self._over_slip(lambda x, rest: x**-m)
        towards_edge = 1 + self.punch.pressure_panels.power - self.punch.medium.k  # one more than u_x' has
        over_slip[-1] = over_slip[-2] / np.expm1(np.log(2) * towards_edge)
        return -_slopes_outside(self.punch, m)[0] - np.sum(over_slip)

    # -- the zone of slip --------------------------------------------------------------------------

    @cached_property
    def _slip_panels(self):
        """Left ends and widths of panels on (c, 1), Gauss points in them, all as distances from c, and -u_x' there."""
        panels = self.punch.pressure_panels
        outer, w = panels.lo >= 0, panels.hi[-1]
        towards_edge = w - w / 2 * 0.5 ** np.arange(1, LEVELS + 1)
        lo = np.concatenate([panels.lo[outer], towards_edge])
        width = np.diff(lo, append=w)
        owner = np.minimum(np.flatnonzero(outer)[0] + np.arange(len(lo)), len(panels.lo) - 1)
        t, _ = gauss_rule(NODES)
        y = lo[:, None] + width[:, None] * t
        slope = -self.punch.tangential_gradient(y.ravel(), np.repeat(owner, NODES)).reshape(y.shape)
        return lo, width, y, slope

    def _over_slip(self, function):
        """∫ -u_x' function(x, 1 - x) dx over each panel of slip."""
        _, width, y, slope = self._slip_panels
        values = slope * function(self.punch.c + y, self.punch.slip_width - y)
        return width * (values @ gauss_rule(NODES)[1])

    def slip(self, x, m):
        """-m x^m ∫ u_x(t) t^(-m-1) dt over max(x, c) < t < 1: by parts, x^m times an integral over u_x'."""
        x = np.asarray(x, dtype=float)
        lo, width, _, slope = self._slip_panels
        c = self.punch.c
        t, weight = gauss_rule(NODES)
        plain = np.cumsum(np.append(0.0, self._over_slip(lambda x, rest: np.ones_like(x))))
        falling = self._over_slip(lambda x, rest: np.expm1(-m * np.log(x)))
        falling = np.append(np.cumsum(falling[::-1])[::-1], 0.0)
        inside = np.minimum(x, 1.0).ravel()
        y = np.maximum(inside - c, 0.0)
        j = np.clip(np.searchsorted(lo, y, side="right") - 1, 0, len(lo) - 1)
        series = legfit(2 * t - 1, slope.T, NODES - 1)[:, j, None]
        width = width[j]
        share = ((y - lo[j]) / width)[:, None]
        below, above = share * t, share + (1 - share) * t
        inner = width * share[:, 0] * (legval(2 * below - 1, series, tensor=False) @ weight)
        outer = np.expm1(-m * np.log(c + (lo[j][:, None] + width[:, None] * above)))
        outer = width * (1 - share[:, 0]) * ((legval(2 * above - 1, series, tensor=False) * outer) @ weight)
        stuck = np.maximum(inside, c)
        result = (plain[j] + inner) * -np.expm1(m * np.log(stuck)) + stuck**m * (falling[j + 1] + outer)
        return ((inside / stuck) ** m * np.where(inside < 1, result, 0.0)).reshape(x.shape)[()]

    def slip_work(self, power):
        """-∫ p(t) u_x(t) dt over (c, 1) for p = ``grown`` of the pressure; by parts, over the load beyond t."""

        def load_beyond(x, rest):
            flat = x.ravel(), rest.ravel()
            whole, weighted = (self._beyond(*flat, exponent, self.punch.pressure) for exponent in (0.0, power))
            return ((whole - weighted) / power).reshape(x.shape)

        return float(np.sum(self._over_slip(load_beyond)))


@lru_cache(maxsize=64)
def _slopes_outside(punch, m):
    """-∫_1^∞ u'(x) x^-m dx of both displacements, u_x and u_y."""
    panels, medium = punch.pressure_panels, punch.medium
    k, total = medium.k, np.zeros(2)
    for j in range(len(panels.lo)):
        from_lo, to_hi, weight = panels.nodes(j)
        if j == len(panels.lo) - 1:
            t, rest, weight = plain_rule(0.0, panels.power - max(k, 0.0), nodes_for())
            from_lo, to_hi, weight = (panels.width[j] * v for v in (t, rest, weight))
        gap = (panels.hi[-1] - panels.hi[j]) + to_hi
        near, far = _outside(gap, m, k), _outside(2 - gap, m, k)
        p, q = punch.pressure(j, from_lo, to_hi), punch.traction(j, from_lo, to_hi)
        total[0] += np.sum(weight * (medium.gk * q * (near - far) + k * medium.d * p * (near + far)))
        total[1] += np.sum(weight * (medium.bk * p * (near + far) - k * medium.d * q * (near - far)))
    return total


def _outside(gap, m, k):
    """∫_1^∞ x^-m (x - ξ)^(-k-1) dx for 1 - ξ = gap > 0; over ln(1 + (1 - 1/x)/gap)."""
    gap = np.asarray(gap)[:, None]
    span = np.log1p(1 / gap)
    t, rest, weight = plain_rule(0.0, m + k - 1, nodes_for(span))
    s = gap * np.expm1(span * t)  # 1 - 1/x
    left = -(1 + gap) * np.expm1(-span * rest)
    return np.sum(span * weight * (s + gap) * left ** (m + k - 1) * (gap + (1 - gap) * s) ** (-k - 1), axis=1)
