"""Nodes and interpolations for assumed edges of contact and stick, and how far a solution moves these edges."""

from dataclasses import dataclass

import numpy as np

from .half_plane_edges import contact_edges, inner_edges, stick_zones
from .half_plane_interpolation import Edges, adapted, linear
from .half_plane_nodes import graded_nodes
from .half_plane_operator import SurfaceOperator

SMALLEST = 1e-7  # spacing at the edges over the width of the contact
STICK_DENSITY = 2.0  # of nodes at edges of stick, which move, over that at other edges
NEIGHBOUR = 0.01  # distance over the width of the contact below which an old edge is as good as the new one


def grading_order(k):
    """Order of the grading: twice the least for roots distance^((1+k)/2); most of the error is next to the edges."""
    return 8 / (2 + k)


def first_distance(nodes, k):
    """Distance from an edge, over the width of the contact, below which nodes are spaced wider than that distance."""
    order = grading_order(k)
    return (8 * order / nodes) ** order  # about nodes/8 on each side of an edge


@dataclass(frozen=True)
class Layout:
    """Assumed contact (left, right), stick zones, shape (n, 2), and edges of earlier stick inside these [length]."""

    contact: tuple[float, float]
    zones: np.ndarray
    kinks: Edges

    @classmethod
    def first(cls, half_width):
        """Contact of the given half-width around the origin."""
        return cls((-half_width, half_width), np.empty((0, 2)), Edges.of_zones([]))

    @property
    def width(self):
        """Width of the contact."""
        return self.contact[1] - self.contact[0]

    @property
    def stick_edges(self):
        """Edges of stick, present and past."""
        return self.kinks + Edges.of_zones(self.zones)

    def nodes(self, count, margin, k):
        """``count`` nodes over the contact and ``margin`` [length] beside it."""
        low, high = self.contact[0] - margin, self.contact[1] + margin
        position = np.concatenate([self.contact, self.kinks.position, self.zones.ravel()])
        density = np.ones(len(position))
        density[len(position) - self.zones.size :] = STICK_DENSITY
        return graded_nodes(low, high, position, density, count, SMALLEST * self.width, grading_order(k))

    def operator(self, kernel, nodes, settled, coupled):
        """Operator on ``nodes``, with interpolations that trust the edges if they are ``settled``."""
        if not settled:
            return SurfaceOperator.on(kernel, nodes, linear(nodes), linear(nodes), coupled)
        contact, none = Edges.of_zones([self.contact]), Edges.of_zones([])
        exponent = (1 + kernel.k) / 2
        of_pressure = adapted(nodes, contact, self.stick_edges, exponent, self.width)
        of_traction = adapted(nodes, contact + self.stick_edges, none, exponent, self.width)
        return SurfaceOperator.on(kernel, nodes, of_pressure, of_traction, coupled)

    def of(self, solution, mu, k, old_edges):
        """Layout that a solution shows."""
        contact, zones = contact_edges(solution, k), stick_zones(solution, mu, k)
        return Layout(contact, zones, inner_edges(old_edges, zones, NEIGHBOUR * (contact[1] - contact[0])))

    @property
    def stick(self):
        """Left and right end of all stick zones; nan without stick."""
        return (self.zones[0, 0], self.zones[-1, 1]) if len(self.zones) else (np.nan, np.nan)

    def distance(self, other):
        """Largest motion of the ends of contact and stick over the width; infinite if stick comes or goes."""
        if (len(self.zones) == 0) != (len(other.zones) == 0):
            return np.inf
        here, there = (np.append(layout.contact, layout.stick) for layout in (self, other))
        return np.nanmax(np.abs(here - there)) / self.width
