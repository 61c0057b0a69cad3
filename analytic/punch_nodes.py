"""Quadrature over the half-widths s of a superposition of punches, accurate beside every edge.

Each function takes the superposition and, where it depends on x, a column of points 0 <= x. It
returns Nodes, rows of s with their weights ds. The variable of integration is chosen such that the
integrand is smooth however close x, start and a are to each other.
"""

from typing import NamedTuple

import numpy as np

from .quadrature import nodes_for, plain_rule
from .special import log_remainder


class Nodes(NamedTuple):
    """s, a - s, and weight, which contains ds; beyond = |x - s| where that is needed."""

    s: np.ndarray
    edge: np.ndarray
    weight: np.ndarray
    beyond: np.ndarray | None = None

    def integrate(self, punches, kernel=1.0):
        """∫ n kernel ds."""
        return np.sum(self.weight * punches.density(self.s, self.edge) * kernel, axis=-1)


def beyond_start(p, x):
    """x - start, by way of the width where start is only known to its own rounding error."""
    return p.width - (p.a - x) if p.width < p.a / 2 else x - p.start


def left_power(p, kernel_power):
    """Power of s - start in n kernel, where the kernel has its own power at s = 0."""
    return p.power + (kernel_power if p.start == 0 else 0.0)


def all_punches(p, kernel_power):
    """start < s < a, for a kernel of order s^kernel_power."""
    if p.start > 0:  # over ln s, as a wide range of it may count
        return wider_than(p, 0.0)
    t, rest, weight = plain_rule(left_power(p, kernel_power), p.edge_power, nodes_for())
    return Nodes(p.start + p.width * t, p.width * rest, p.width * weight)


def wider_than(p, x):
    """max(x, start) < s < a over ln s, for a kernel regular at s = x; beyond = s - x."""
    width = np.minimum(p.width, p.a - x)
    span = -log_remainder(width / p.a, np.log(np.maximum(x, p.start) / p.a))
    t, rest, weight = plain_rule(p.power if p.start > 0 else 0.0, p.edge_power, nodes_for(span))
    s = p.a * np.exp(-span * rest)
    edge = -p.a * np.expm1(-span * rest)
    beyond = np.where(edge < p.a / 2, (p.a - x) - edge, s - x)
    return Nodes(s, edge, span * s * weight, np.maximum(beyond, 0))


def abel_from_x(p, x):
    """x < s < a with (s²-x²)^((k-1)/2) in the weights; s = x cosh(theta) makes that theta^k."""
    span = 2 * np.arcsinh(np.sqrt((p.a - x) / (2 * x)))
    t, rest, weight = plain_rule(p.k, p.edge_power, nodes_for(span))
    edge = 2 * x * np.sinh(span * (1 + t) / 2) * np.sinh(span * rest / 2)
    return Nodes(x * np.cosh(span * t), edge, span * (x * np.sinh(span * t)) ** p.k * weight)


def abel_from_start(p, x):
    """start < s < a with (s²-x²)^((k-1)/2) in the weights, x < start; s²-x² = (a²-x²) e^-phi."""
    whole = (p.a - x) * (p.a + x)
    lost = p.width * (2 * p.a - p.width) / whole
    span = -log_remainder(lost, np.log(-beyond_start(p, x) * (p.start + x) / whole))
    t, rest, weight = plain_rule(p.power, p.edge_power, nodes_for(span))
    u = whole * np.exp(-span * rest)
    s = np.sqrt(x**2 + u)
    edge = -whole * np.expm1(-span * rest) / (p.a + s)
    return Nodes(s, edge, span * u ** ((1 + p.k) / 2) / (2 * s) * weight)


def narrower_than(p, x, kernel_power, end_power):
    """start < s < x <= a, for a kernel ~ s^kernel_power at 0 and ~ (x-s)^end_power; beyond = x - s.

    x is a column of points all below a, or all equal to a, if n is singular there.
    """
    span, left = beyond_start(p, x), left_power(p, kernel_power)
    if p.edge_power and np.all(x < p.a):  # n is singular just beyond x: a - s = (a-x) e^phi
        span = np.log1p(span / (p.a - x))
        t, rest, weight = plain_rule(left, end_power, nodes_for(span))
        s, beyond = p.start - p.width * np.expm1(-span * t), (p.a - x) * np.expm1(span * rest)
        weight = span * (p.a - x + beyond) * weight
    elif p.start == 0:
        t, rest, weight = plain_rule(left, end_power + p.edge_power, nodes_for())
        s, beyond, weight = x * t, x * rest, x * weight
    else:  # s = x e^-theta
        span = -log_remainder(span / x, np.log(p.start / x))
        t, rest, weight = plain_rule(left, end_power + p.edge_power, nodes_for(span))
        s, beyond = x * np.exp(-span * rest), -x * np.expm1(-span * rest)
        weight = span * s * weight
    return Nodes(s, p.a - x + beyond, weight, beyond)


def seen_from_outside(p, x, kernel_power):
    """start < s < a for x > a, in two parts: over s below a/2, over y = 1 - s²/x² = y_a e^theta."""
    middle = max(p.start, p.a / 2)
    beside = (x - p.a) * (x + p.a)
    width, left = (p.width, p.power) if middle == p.start else (p.a / 2, 0.0)
    span = np.log1p(width * (2 * p.a - width) / beside)
    t, rest, weight = plain_rule(p.edge_power, left, nodes_for(span))
    edge_square = beside * np.expm1(span * t)  # a² - s²
    s = np.sqrt(p.a**2 - np.minimum(edge_square, p.a**2 - middle**2))
    weight = span * beside * np.exp(span * t) / (2 * s) * weight
    parts = [Nodes(s, edge_square / (p.a + s), weight)]
    if middle > p.start > 0:  # over ln s, as in all_punches
        span = np.log(middle / p.start)
        t, rest, weight = plain_rule(p.power, 0.0, nodes_for(span))
        s = middle * np.exp(-span * rest)
        parts.append(Nodes(s, p.a - s, span * s * weight))
    elif middle > p.start:
        t, _, weight = plain_rule(left_power(p, kernel_power), 0.0, nodes_for())
        s = middle * t
        parts.append(Nodes(s, p.a - s, middle * weight))
    return parts
