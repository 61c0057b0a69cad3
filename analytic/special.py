"""Displacement functions of a flat punch, (8) and (10), and of a parabolic contact, [X2].

All depend on s/x, half-width over distance. The printed forms subtract two terms of size 1/k, which
leaves nothing for small k or for x -> s. Here each function is a power series in y = 1 - s²/x²
where y <= 1/2, and in z = s²/x² elsewhere, with the pole in k cancelled analytically; the terms
that remain do not cancel for any -1 < k < 1, but in parabolic_displacement, which vanishes like
1-k towards k = 1. In the code h = k/2 and w = (1-k)/2.

The functions take x and s of any shape (broadcast), and some distance = x - s, where the caller
knows it better than the subtraction gives it.
"""

from functools import partial
from math import exp, expm1, gamma, inf, lgamma, log, pi, sqrt

import numpy as np
from scipy.special import beta as euler_beta
from scipy.special import betainc, zeta

LEAST_RATIO = 1e-300  # of s/x, where only its logarithm still matters
TERMS = 56  # arguments do not exceed 1/2, and 2^-56 is below the resolution of binary64


def punch_relative_displacement(x, s, k, distance=None):
    """H = 1/2 ∫_z^1 t^(k/2-1) (1-t)^(-(1+k)/2) dt with z = s²/x², and 0 for x <= s.

    It is 1/k times the bracket of (8), (14), (21), (35):
    Γ((2+k)/2)Γ((1-k)/2)/√π - (s/x)^k F(k/2,(1+k)/2;(2+k)/2;s²/x²).
    """
    h, w = k / 2, (1 - k) / 2

    def near(y):
        return y**w * _series(_binomial(1 - h) / (np.arange(TERMS) + w), y) / 2

    far_away = punch_rigid_displacement(k) if k > 0 else inf
    return _by_zone(x, s, distance, near, partial(_beta_beyond, k=k), at_edge=0.0, far_away=far_away)


def punch_displacement(x, s, k):
    """U = 1/2 ∫_0^z t^(k/2-1) (1-t)^(-(1+k)/2) dt with z = s²/x², constant for x <= s; 0 < k < 1.

    It is 1/k times (s/x)^k F(k/2,(1+k)/2;(2+k)/2;s²/x²) of (10), (13), (20).
    """
    h, w, whole = k / 2, (1 - k) / 2, punch_rigid_displacement(k)

    def near(y):
        if k > 0.5:  # U is H of the other distance and 1-k, whose pole is that of whole
            return _beta_beyond(np.sqrt(y), 1 - k)
        return whole - y**w * _series(_binomial(1 - h) / (np.arange(TERMS) + w), y) / 2

    def far(ratio):
        return ratio**k * _series(_binomial(1 - w) / (np.arange(TERMS) + h), ratio**2) / 2

    return _by_zone(x, s, None, near, far, at_edge=whole, far_away=0.0)


def punch_rigid_displacement(k):
    """Γ((2+k)/2)Γ((1-k)/2)/(√π k) = H + U for 0 < k < 1, as in (11) and (13)."""
    return punch_rigid_factor(k) / k


def punch_rigid_factor(k):
    """Γ((2+k)/2)Γ((1-k)/2)/√π, which is 1 for k = 0."""
    return gamma(1 + k / 2) * gamma((1 - k) / 2) / sqrt(pi)


def punch_gradient(x, s, k, distance=None):
    """dH/dx = (s/x)^k (1 - s²/x²)^(-(1+k)/2) / x for 0 < s < x."""
    distance = x - s if distance is None else distance
    return (s / x) ** k * (distance / x * ((x + s) / x)) ** (-(1 + k) / 2) / x


def parabolic_gap(x, s, k, distance=None):
    """Phi(1 - s²/x²) of [X2], 0 for x <= s: the gap beside a parabolic contact over x²/(2R)."""

    def far(ratio):
        return 1 - _phi_complement(ratio, k)

    return _by_zone(x, s, distance, partial(_phi, k=k), far, at_edge=0.0, far_away=1.0)


def parabolic_gap_slope(x, s, k, distance=None):
    """I_y((1-k)/2, 1+k/2), y = 1 - s²/x², of [X3], 0 for x <= s: the slope of that gap over x/R."""
    p, q = (1 - k) / 2, 1 + k / 2

    def far(ratio):
        return 1 - betainc(q, p, ratio**2)

    return _by_zone(x, s, distance, partial(betainc, p, q), far, at_edge=0.0, far_away=1.0)


def parabolic_relative_displacement(x, s, k):
    """1 - Phi(1 - s²/x²) of [X2], 1 for x <= s, accurate where small: h_y of (45) over x²/(2R)."""

    def near(y):
        return 1 - _phi(y, k)

    return _by_zone(x, s, None, near, partial(_phi_complement, k=k), at_edge=1.0, far_away=0.0)


def parabolic_displacement(x, s, k):
    """u_y of (10) over x²/(2R) beside a parabolic contact of half-width s, x >= s, 0 < k < 1."""
    h, w, n = k / 2, (1 - k) / 2, np.arange(TERMS)

    def near(y):
        return (1 - y) / k - (1 - _phi(y, k))

    def far(ratio):
        series = _series(_binomial(1 - w) / ((n + h) * (n + 1 + h)), ratio**2)
        return ratio ** (2 + k) * series / euler_beta(w, 1 + h)

    return _by_zone(x, s, None, near, far, at_edge=1 / k - 1, far_away=0.0)


def log_remainder(lost, log_left):
    """ln(1 - lost) from lost where that is small, elsewhere from log_left, the same logarithm."""
    return np.where(lost < 0.5, np.log1p(-np.minimum(lost, 0.5)), log_left)[()]


def _beta_beyond(ratio, k):
    """1/2 ∫_z^1 t^(k/2-1) (1-t)^(-(1+k)/2) dt for z = ratio² <= 1/2, without the pole in k."""
    h, w, n = k / 2, (1 - k) / 2, np.arange(1, TERMS)
    z, power = ratio**2, _regularised_power(ratio, k)
    tail = z * _series(_binomial(1 - w)[1:] / (n + h), z)
    return (_beta_without_pole(k) - power - (1 + h * power) * tail) / 2


def _phi(y, k):
    """Phi for y <= 1/2 by its hypergeometric series, all of whose terms are positive."""
    n = np.arange(1, TERMS)
    p, q, r = (1 - k) / 2, (2 - k) / 2, (5 - k) / 2
    factors = (p + n - 1) * (q + n - 1) / ((r + n - 1) * n)
    series = _series(np.concatenate([[1.0], np.cumprod(factors)]), y)
    return sqrt(pi) / (2 * gamma(r) * gamma(1 + k / 2)) * y ** ((3 - k) / 2) * series


def _phi_complement(ratio, k):
    """1 - Phi for z = ratio² < 1/2: [X2] by beta functions, term by term, without the pole in k."""
    h, w, n = k / 2, (1 - k) / 2, np.arange(1, TERMS)
    z, power = ratio**2, _regularised_power(ratio, k)
    tail = 1 / (1 + h) - z * _series(_binomial(1 - w)[1:] / ((n + h) * (n + 1 + h)), z)
    return z * (_beta_without_pole(k) - power + (1 + h * power) * tail) / euler_beta(w, 1 + h)


def _by_zone(x, s, distance, near, far, at_edge, far_away):
    """near(y) for y <= 1/2, far(s/x) for z < 1/2; at_edge for x <= s, far_away for s = 0."""
    x, s = np.asarray(x, dtype=float), np.asarray(s, dtype=float)
    x, s, distance = np.broadcast_arrays(x, s, x - s if distance is None else distance)
    result = np.where((s == 0) & (distance > 0), far_away, at_edge)
    result[np.isnan(x)] = np.nan
    outside = (s > 0) & (distance > 0)
    x, s, distance = x[outside], s[outside], distance[outside]
    y = distance / x * ((x + s) / x)
    close = y <= 0.5
    value = np.empty_like(y)
    value[close] = near(y[close])
    value[~close] = far(np.maximum(s[~close] / x[~close], LEAST_RATIO))
    result[outside] = value
    return result[()]


def _series(coefficients, t):
    """Σ coefficients[n] t^n by Horner's rule, in place."""
    result = np.full_like(t, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        result *= t
        result += coefficient
    return result


def _binomial(q):
    """(q)_n/n!, the Taylor coefficients of (1-t)^(-q)."""
    n = np.arange(1, TERMS)
    return np.concatenate([[1.0], np.cumprod((q + n - 1) / n)])


def _regularised_power(ratio, k):
    """(z^h - 1)/h with z = ratio², which is ln z for k = 0."""
    log_ratio = np.log(ratio)
    return 2 * np.expm1(k * log_ratio) / k if k else 2 * log_ratio


def _beta_without_pole(k):
    """B(k/2, (1-k)/2) - 2/k, which is 2 ln 2 for k = 0."""
    h = k / 2
    if abs(k) > 0.25:
        return (exp(lgamma(1 + h) + lgamma(0.5 - h)) / sqrt(pi) - 1) / h
    # Taylor series of ln[Γ(1+h)Γ(1/2-h)/Γ(1/2)]/h; ratio of successive terms 2h <= 1/4
    n = np.arange(2, 32)
    slope = 2 * log(2) + float(np.sum(zeta(n) * ((2.0**n - 1) + (-1.0) ** n) * h ** (n - 1) / n))
    return expm1(h * slope) / h if h else slope
