"""Tractions like a power of 1 - x²/a², and their line load between -x and x: of (12), (44) and (47)."""

from math import sqrt

import numpy as np
from scipy.special import beta as euler_beta
from scipy.special import betainc

from .special import log_remainder

TERMS = 80  # arguments do not exceed 0.6, and 0.6^80 is below the resolution of binary64
NARROW = 0.9  # from this ratio of the half-widths on, the two loads are not subtracted


def beta_density(x, a, half):
    """(1 - x²/a²)^(half-1)/(a B(1/2, half)) [1/length], of integral 1; zero for |x| > a; any shape."""
    x = np.abs(np.asarray(x, dtype=float))
    depth = np.maximum(a - x, 0) / a * ((a + x) / a)
    with np.errstate(divide="ignore"):
        density = depth ** (half - 1) / (a * euler_beta(0.5, half))
    return np.where(x > a, 0.0, density)[()]


def beta_fraction(x, a, half):
    """I_{x²/a²}(1/2, half), the integral of beta_density from -x to x, odd in x, ±1 for |x| >= a; any shape."""
    x = np.asarray(x, dtype=float)
    ratio = np.minimum(np.abs(x) / a, 1)
    small = 2 * ratio / euler_beta(0.5, half)  # its square would underflow before x does
    return (np.sign(x) * np.where(ratio < 1e-9, small, betainc(0.5, half, ratio**2)))[()]


def load_fraction_difference(x, a, log_ratio, k):
    """∫_{-x}^{x} [p(x; P) - p(x; zP)] dx / P, z = e^log_ratio; odd in x, ±(1-z) beyond ±a.

    Outside the smaller half-width s = e^log_gamma a it is 1-z minus the tail. Inside, where the two
    loads nearly cancel for z -> 1, series with positive terms are summed: over (x/s)² in the
    middle, over 1 - x²/a² for the tail near s. x and log_ratio of any shape.
    """
    x, log_ratio = np.broadcast_arrays(np.asarray(x, dtype=float), log_ratio)
    sign, x = np.sign(x), np.minimum(np.abs(x), a)
    log_gamma = log_ratio / (2 + k)
    half, to_edge = (3 + k) / 2, (a - x) / a
    x, gamma = x / a, np.exp(log_gamma)
    y = to_edge * (1 + x)
    to_s = np.where(gamma > 0.5, to_edge + np.expm1(log_gamma), gamma - x)

    inner = x <= gamma / sqrt(2)
    outer = (to_s <= 0) & (x > 0.7)
    narrow = ~(inner | outer) & (gamma > NARROW)
    wide = ~(inner | outer | narrow)

    result = np.array(-np.expm1(log_ratio))
    result[inner] = _middle(x[inner], log_gamma[inner], k)
    result[outer] -= betainc(half, 0.5, y[outer])
    result[narrow] -= _narrow_tail(x[narrow], y[narrow], to_s[narrow], log_gamma[narrow], k)
    smaller = np.exp(log_ratio[wide]) * beta_fraction(x[wide], gamma[wide], half)
    result[wide] = beta_fraction(x[wide], 1.0, half) - smaller
    return (sign * result)[()]


def _middle(x, log_gamma, k):
    """I_{x²}(1/2,b) - gamma^(2+k) I_{x²/gamma²}(1/2,b), b = (3+k)/2, by powers of (x/gamma)²."""
    t = (x * np.exp(-log_gamma)) ** 2
    power, coefficient, total = np.ones_like(t), 1.0, np.zeros_like(t)
    for n in range(1, TERMS):
        coefficient *= (n - 1 - (1 + k) / 2) / n
        power = power * t
        total += coefficient / (n + 0.5) * power * np.expm1((2 * n - 1 - k) * log_gamma)
    leading = -2 * np.expm1((1 + k) * log_gamma)
    return x * (leading + np.exp((1 + k) * log_gamma) * total) / euler_beta(0.5, (3 + k) / 2)


def _narrow_tail(x, y, to_s, log_gamma, k):
    """I_y(b,1/2) - gamma^(2+k) I_y'(b,1/2), b = (3+k)/2, y' = 1 - x²/gamma², by powers of y."""
    half = (3 + k) / 2
    gamma = np.exp(log_gamma)
    log_depth = log_remainder(-np.expm1(2 * log_gamma) / y, np.log(to_s * (gamma + x) / y))
    power, coefficient, total = y**half, 1.0, np.zeros_like(y)
    for n in range(TERMS):
        if n:
            coefficient *= (n - 0.5) / n
            power = power * y
        exponent = (2 + k) * log_gamma + (half + n) * (log_depth - 2 * log_gamma)
        total -= coefficient / (half + n) * power * np.expm1(exponent)
    return total / euler_beta(half, 0.5)
