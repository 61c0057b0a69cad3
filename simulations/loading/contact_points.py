"""Surface points in order of x: contact states, where each stands over the indenter, and the edges of contact."""

from dataclasses import dataclass

import numpy as np

from forms.contact import OPEN

BESIDE = 8  # points beside the edge, whose displacement has the error of the facet that it cuts


@dataclass(frozen=True)
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


def open_points(states: np.ndarray, side: int) -> np.ndarray:
    """Indices of the open points beyond the contact's edge on one side, from there outwards; all without contact."""
    contact = np.flatnonzero(states != OPEN)
    middle = len(states) // 2
    left, right = (contact[0], contact[-1] + 1) if len(contact) else (middle, middle)
    return np.arange(right, len(states)) if side > 0 else np.arange(left)[::-1]


def leading(mask) -> int:
    """Number of True before the first False."""
    return len(mask) if np.all(mask) else int(np.argmin(mask))
