"""Edges of contact and stick between two nodes: tractions vanish there like distance^((1+k)/2)."""

import numpy as np

from .interpolation import Edges


def contact_zone(solution, k):
    """Left and right edge of the contact [length]."""
    x, closed = solution.x, np.flatnonzero(solution.sets.closed)
    first, last = closed[0], closed[-1]
    return _edge(x, solution.pressure, first, -1, k), _edge(x, solution.pressure, last, 1, k)


def stuck_runs(solution, mu):
    """First and last node (n, 2) of every zone of stick, as indices."""
    if mu == 0:
        return np.empty((0, 2), dtype=int)
    changes = np.flatnonzero(np.diff(np.concatenate([[False], solution.sets.stuck, [False]]).astype(int)))
    return changes.reshape(-1, 2) - [0, 1]


def stick_zones(solution, mu, k):
    """Left and right edges [length] of every zone of stick, shape (n, 2), from the reserve mu p - |q|."""
    x, reserve = solution.x, mu * solution.pressure - np.abs(solution.traction)
    runs = stuck_runs(solution, mu)
    zones = [(_edge(x, reserve, first, -1, k), _edge(x, reserve, last, 1, k)) for first, last in runs]
    return np.array(zones).reshape(-1, 2)


def edges_inside(edges: Edges, zones, distance):
    """Those of ``edges`` farther than ``distance`` inside one of ``zones``: where slip once ended, q keeps a root."""
    inside = [any(a + distance < e < b - distance for a, b in zones) for e in edges.position]
    return edges.only(np.array(inside, dtype=bool))


def _edge(x, value, last, step, k):
    """Zero between the node ``last`` and its neighbour at ``step``: value^(2/(1+k)) is nearly linear there."""
    beyond, inner = last + step, last - step
    if not (0 <= beyond < len(x) and 0 <= inner < len(x)):
        return x[last]
    here, before = (max(value[i], 0.0) ** (2 / (1 + k)) for i in (last, inner))
    if here >= before:
        return (x[last] + x[beyond]) / 2
    zero = x[last] + (x[last] - x[inner]) * here / (before - here)
    return float(zero if abs(zero - x[last]) < abs(x[beyond] - x[last]) else x[beyond])
