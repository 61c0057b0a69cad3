"""Gauss rules for integrands with known powers at the ends of the interval, used by the Abel integrals of any profile."""

from functools import lru_cache

import numpy as np

SMALLEST = 1e-60  # nodes closer to an end than this carry no weight of their own; keeps powers of them finite


@lru_cache(maxsize=256)
def one_sided_rule(power, n):
    """Nodes t and weights for ∫_0^1 t^power F(t) dt, power > -1, with the factor t^power in the weights.

    The substitution t = v^(m/(power+1)) with a whole m turns t^power dt into a multiple of v^(m-1) dv and flattens F, which
    may therefore have further powers of t at 0. Gauss-Jacobi weights would lose four to eight digits for power -> -1.
    """
    if power < -0.9:  # the substitution is steep there
        n *= 3
    v, weight = np.polynomial.legendre.leggauss(n)
    v, weight = (1 + v) / 2, weight / 2
    m = max(1, round(8 * (power + 1)))
    exponent = m / (power + 1)
    with np.errstate(under="ignore"):
        return np.maximum(v**exponent, SMALLEST), weight * exponent * v ** (m - 1)


@lru_cache(maxsize=256)
def two_sided_rule(left, right, n):
    """Nodes t, 1-t and weights for ∫_0^1 t^left (1-t)^right F(t) dt, both factors in the weights; 2n nodes."""
    low, low_weight = one_sided_rule(left, n)
    high, high_weight = one_sided_rule(right, n)
    t = np.concatenate([low / 2, 1 - high / 2])
    rest = np.concatenate([1 - low / 2, high / 2])
    weight = np.concatenate(
        [
            low_weight / 2 ** (left + 1) * (1 - low / 2) ** right,
            high_weight / 2 ** (right + 1) * (1 - high / 2) ** left,
        ]
    )
    return t, rest, weight


def nodes_for(log_span):
    """Number of nodes for an integrand spread over e^log_span; a multiple of 16, so that few rules are built."""
    return 16 * int(np.ceil((48 + 3 * float(np.max(log_span, initial=0.0))) / 16))
