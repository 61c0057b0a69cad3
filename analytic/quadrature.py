"""Gauss rules on (0, 1), for smooth integrands and for those with known powers at the ends."""

from functools import lru_cache

import numpy as np

LEAST_POWER = 1e-60  # a node closer to an end has no weight of its own; keeps its powers finite
BLOCK = 64  # points evaluated at once, which bounds the memory of points x nodes x nodes


@lru_cache(maxsize=64)
def gauss_rule(n):
    """Nodes t and weights for ∫_0^1 F(t) dt, F smooth."""
    v, weight = np.polynomial.legendre.leggauss(n)
    return (1 + v) / 2, weight / 2


@lru_cache(maxsize=256)
def one_sided_rule(power, n):
    """Nodes t and weights for ∫_0^1 t^power F(t) dt, power > -1, the factor t^power in the weights.

    With t = v^(m/(power+1)), m whole, t^power dt is a multiple of v^(m-1) dv, and F is so flat at 0
    that it may have further powers of t. Gauss-Jacobi weights lose four to eight digits for
    power -> -1.
    """
    if power < -0.9:  # the substitution is steep there
        n *= 3
    v, weight = gauss_rule(n)
    m = max(1, round(8 * (power + 1)))
    exponent = m / (power + 1)
    with np.errstate(under="ignore"):
        return np.maximum(v**exponent, LEAST_POWER), weight * exponent * v ** (m - 1)


@lru_cache(maxsize=256)
def two_sided_rule(left, right, n):
    """Nodes t, 1-t, weights for ∫_0^1 t^left (1-t)^right F(t) dt, both factors in the weights."""
    low, low_weight = one_sided_rule(left, n)
    high, high_weight = one_sided_rule(right, n)
    t = np.concatenate([low / 2, 1 - high / 2])
    rest = np.concatenate([1 - low / 2, high / 2])
    low_weight = low_weight / 2 ** (left + 1) * (1 - low / 2) ** right
    high_weight = high_weight / 2 ** (right + 1) * (1 - high / 2) ** left
    return t, rest, np.concatenate([low_weight, high_weight])


def plain_rule(left, right, n):
    """Nodes t, 1-t and weights of two_sided_rule for ∫_0^1 F dt, the powers left in F."""
    t, rest, weight = two_sided_rule(left, right, n)
    return t, rest, weight * t**-left * rest**-right


def nodes_for(log_span=0.0):
    """Number of nodes for an integrand spread over e^log_span; in steps, so that rules are few."""
    return 16 * int(np.ceil((48 + 3 * float(np.max(log_span, initial=0.0))) / 16))


def by_blocks(function, x):
    """function of a 1-d array of |x|, applied to x of any shape block by block; nan where x is nan."""
    x = np.abs(np.asarray(x, dtype=float))
    flat = x.ravel()
    parts = [function(flat[i : i + BLOCK]) for i in range(0, flat.size, BLOCK)]
    result = np.concatenate([np.empty(0), *parts]).reshape(x.shape)
    return np.where(np.isnan(x), x, result)[()]
