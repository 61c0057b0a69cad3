"""Nodes and interpolations for assumed edges of contact and stick, and how far a solution moves these edges."""

from dataclasses import dataclass, replace

import numpy as np

from .edges import contact_zone, edges_inside, stick_zones
from .interpolation import Edges, adapted, linear
from .operator import SurfaceOperator

SPACING_AT_EDGE = 1e-7  # spacing at the edges over the width of the contact
# spacing^(1-k) at edges of stick: the compliance of an element over the whole's, which rounding must not reach
SOFTEST = 3e-11
STICK_DENSITY = 2.0  # of nodes at edges of stick, which move, over that at other edges
BISECTIONS = 60  # of the place of a node
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
    """Assumed contact (left, right), stick zones, shape (n, 2), edges of stick that loads have turned at, as long as
    nothing slips there, and places where the profile is not smooth [length]."""

    contact: tuple[float, float]
    zones: np.ndarray
    old_edges: Edges
    corners: Edges

    @classmethod
    def first(cls, half_width, corners=()):
        """Contact of the given half-width around the origin."""
        corners = Edges(np.array(corners, dtype=float), np.ones(len(corners)))
        return cls((-half_width, half_width), np.empty((0, 2)), Edges.of_zones([]), corners)

    @property
    def width(self):
        """Width of the contact."""
        return self.contact[1] - self.contact[0]

    @property
    def kinks(self):
        """Old edges far from the present ones; beside them the present ones are as good."""
        return edges_inside(self.old_edges, self.zones, NEIGHBOUR * self.width)

    @property
    def stick_edges(self):
        """Edges of stick, present and past."""
        return self.kinks + Edges.of_zones(self.zones)

    def nodes(self, count, margin, k):
        """``count`` nodes over the contact and ``margin`` [length] beside it."""
        low, high = self.contact[0] - margin, self.contact[1] + margin
        position = np.concatenate([self.contact, self.corners.position, self.kinks.position, self.zones.ravel()])
        density = np.ones(len(position))
        density[len(position) - self.zones.size :] = STICK_DENSITY
        at_stick = max(SPACING_AT_EDGE, SOFTEST ** (1 / (1 - k)))
        smallest = np.where(np.arange(len(position)) < 2, SPACING_AT_EDGE, at_stick) * self.width
        return graded_nodes(low, high, position, density, count, smallest, grading_order(k))

    def operator(self, kernel, nodes, settled, coupled):
        """Operator on ``nodes``, with interpolations that trust the edges if they are ``settled``."""
        if not settled:
            return SurfaceOperator.on(kernel, nodes, linear(nodes), linear(nodes), coupled)
        contact = Edges.of_zones([self.contact])
        exponent = (1 + kernel.k) / 2
        of_pressure = adapted(nodes, contact, self.stick_edges + self.corners, exponent, self.width)
        of_traction = adapted(nodes, contact + self.stick_edges, self.corners, exponent, self.width)
        return SurfaceOperator.on(kernel, nodes, of_pressure, of_traction, coupled)

    def of(self, solution, mu, k, old_edges):
        """Layout that a solution shows."""
        contact, zones = contact_zone(solution, k), stick_zones(solution, mu, k)
        old_edges = edges_inside(old_edges, zones, -NEIGHBOUR * (contact[1] - contact[0]))
        return replace(self, contact=contact, zones=zones, old_edges=old_edges)

    @property
    def stick(self):
        """Left and right end of all stick zones; nan without stick."""
        return (self.zones[0, 0], self.zones[-1, 1]) if len(self.zones) else (np.nan, np.nan)

    def distance_of_contact(self, other):
        """Largest motion of the ends of contact over the width."""
        return np.abs(np.subtract(self.contact, other.contact)).max() / self.width

    def distance(self, other):
        """Largest motion of the ends of contact and stick over the width; infinite if stick comes or goes."""
        if (len(self.zones) == 0) != (len(other.zones) == 0):
            return np.inf
        stick = np.abs(np.subtract(self.stick, other.stick)) / self.width
        return max(self.distance_of_contact(other), np.nan_to_num(stick).max())

    def halfway(self, new):
        """Edges between these and the ``new`` ones, where there are as many."""
        contact = tuple((np.array(self.contact) + new.contact) / 2)
        zones = (self.zones + new.zones) / 2 if len(self.zones) == len(new.zones) else new.zones
        return replace(new, contact=contact, zones=zones)

    def with_edges_of(self, new):
        """The ``new`` layout, with more nodes at the edges of stick of this one."""
        return replace(new, old_edges=new.old_edges + Edges.of_zones(self.zones))


def graded_nodes(left, right, edges, density, count, smallest, order):
    """``count`` nodes from ``left`` to ``right``, gathered at ``edges`` down to about ``smallest`` [length],
    a number, or one for each edge.

    The spacing grows like distance^(1-1/order). Linear interpolation of distance^p has its best rate, the
    square of the spacing in the mean, for order > 2/(p + 1/2).

    Each edge e contributes its ``density`` times (|x - e| + smallest)^(1/order - 1), whose sum is integrated in
    closed form and inverted by bisection.
    """
    edges = np.asarray(edges, dtype=float)

    def nodes_below(x):
        distance = x[:, None] - edges
        reach = (np.abs(distance) + smallest) ** (1 / order) - smallest ** (1 / order)
        return (np.sign(distance) * reach) @ density

    first, last = nodes_below(np.array([left, right]))
    target = np.linspace(first, last, count)[1:-1]
    low, high = np.full(count - 2, left), np.full(count - 2, right)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        below = nodes_below(middle) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.concatenate([[left], (low + high) / 2, [right]])
