"""Surface points in order of x: contact states, where each stands over the indenter, and the edges of contact."""

from dataclasses import dataclass

import numpy as np

from forms.contact import OPEN

NEXT, FURTHER = 1, 3  # open nodes, from 0, through which the edge is sought; the facet that it cuts moves node 0
BESIDE = 8  # points beside the edge, whose displacement has the error of the facet that it cuts


@dataclass(frozen=True, eq=False)
class Surface:
    """Of the surface points sorted by x (n,): contact states, anchors (s where a point is open), clearances."""

    states: np.ndarray
    s: np.ndarray
    clearance: np.ndarray

    def at(self, which) -> "Surface":
        """The same for some of the points."""
        return Surface(self.states[which], self.s[which], self.clearance[which])


def edge_of_contact(x, states, side: int) -> float:
    """Half way from the last node in contact on a side to the next, of points (n,) at x."""
    contact = np.flatnonzero(states != OPEN)
    last = x[contact[-1] if side > 0 else contact[0]]
    beyond = np.searchsorted(x, last, "right") if side > 0 else np.searchsorted(x, last) - 1
    return float(last + x[np.clip(beyond, 0, len(x) - 1)]) / 2


def edge_by_clearance(x, surface: Surface, side: int, power: float) -> float:
    """The edge of contact within its facet: where the clearance of points beyond, like distance^power, goes to zero.

    Half way from node to node where there are too few of these, or where it does not grow.
    """
    beyond = open_points(surface.states, side)[: 2 * (FURTHER + 1)]  # two at a node, at most
    distance, first = np.unique(side * x[beyond], return_index=True)
    root = surface.clearance[beyond[first]] ** (1 / power)
    if len(first) <= FURTHER or not root[FURTHER] > root[NEXT]:
        return edge_of_contact(x, surface.states, side)
    (near, far), (low, high) = distance[[NEXT, FURTHER]], root[[NEXT, FURTHER]]
    edge = near - low * (far - near) / (high - low)
    return float(side * np.clip(edge, side * x[beyond[0] - side], distance[0]))


def open_points(states: np.ndarray, side: int) -> np.ndarray:
    """Indices of the open points beyond the contact's edge on one side, from there outwards; all without contact."""
    contact = np.flatnonzero(states != OPEN)
    middle = len(states) // 2
    left, right = (contact[0], contact[-1] + 1) if len(contact) else (middle, middle)
    return np.arange(right, len(states)) if side > 0 else np.arange(left)[::-1]


def leading(mask) -> int:
    """Number of True before the first False."""
    return len(mask) if np.all(mask) else int(np.argmin(mask))
