"""Tractions of a state as functions of x, and the surface displacements that they cause."""

from functools import cached_property

import numpy as np

from .panels import NODES, TO_LEGENDRE, Panels, graded, legendre
from .zone import RATIO

KINK = 1e-4  # smallest panel at a weak singularity of the tractions, over the half-width of the contact
FINEST, TABLE_RATIO = 1e-7, 0.35  # smallest panel of a table, and the ratio of neighbours
TIP = 1e-3  # smallest panel at an edge of stick, over the half-width of the narrowest zone
FEATURE = 1e-4  # distance of an edge from another point of interest, over the width of the zone, taken for zero
LEVELS = 6  # at most, of panels at an edge


class Zones:
    """Zones of slip, stick and slip between the edges x_l < c_l < c_r < x_r, each an image of a reference zone."""

    def __init__(self, edges, references):
        self.edges, self.references = edges, references
        self.half = np.diff(edges) / 2
        self.points = [a + h * z.points for a, h, z in zip(edges, self.half, references, strict=False)]
        self._elsewhere = [
            z.elsewhere.panels(a, h) for a, h, z in zip(edges, self.half, references, strict=False)
        ]

    def values(self, zone, x):
        """Basis of a zone at points x in it, shape (len(x), size)."""
        low, high, half = self.edges[zone], self.edges[zone + 1], self.half[zone]
        return self.references[zone].values((x - low) / half, (high - x) / half)

    def moments(self, zone):
        """∫ of the basis of a zone."""
        return self.half[zone] * self.references[zone].moments

    def matrices(self, zone, x, within=False):
        """∫ R and ∫ O over the basis of a zone at points x elsewhere, or also ``within`` it."""
        reference = self.references[zone]
        if within:
            panels, values = reference.within.panels(self.edges[zone], self.half[zone]), reference.within.values
        else:
            panels, values = self._elsewhere[zone], reference.elsewhere.values
        even, odd = panels.matrices(x, reference.k)
        return even @ values, odd @ values

    def own_matrices(self, zone):
        """The same at the zone's own collocation points, from those of the reference zone."""
        reference, h = self.references[zone], self.half[zone]
        k = reference.k
        at_h = np.expm1(-k * np.log(h)) / k if k else -np.log(h)
        even, odd = reference.own
        power = 1 + k * at_h
        return h * (power * even + at_h * reference.moments), h * power * odd


def references(problem, friction, edges, base):
    """Reference zones whose panels at the edges of stick are as small as the distances to other edges ask for."""
    features = np.concatenate([edges, base.breaks, base.contact])
    half = np.diff(edges) / 2
    result = []
    for zone in range(3):
        levels = []
        for end in (zone, zone + 1):
            if end in (0, 3):
                levels.append(0)
                continue
            distance = np.abs(features - edges[end])
            nearest = distance[distance > FEATURE * half[zone]].min()
            levels.append(int(np.clip(np.ceil(np.log(nearest / half[zone]) / np.log(RATIO)), 0, LEVELS)))
        result.append(problem.zone(zone, friction, levels))
    return result


class Table:
    """Tractions of a state interpolated on panels that shrink towards its breaks, for evaluation at many points."""

    def __init__(self, state):
        points = np.array([state.contact[0], *state.breaks, state.contact[1]])
        pieces = [graded(a, b, FINEST, FINEST, TABLE_RATIO) for a, b in zip(points, points[1:], strict=False)]
        self.panels = Panels.between(np.unique(np.concatenate(pieces)))
        values = state.tractions(self.panels.nodes).reshape(2, -1, NODES)
        self.coefficients = np.ascontiguousarray((values @ TO_LEGENDRE.T).transpose(1, 2, 0))

    def __call__(self, x):
        """p and q at x in the contact, shape (2, n)."""
        panels = self.panels
        j = np.clip(np.searchsorted(panels.low, x, side="right") - 1, 0, len(panels.low) - 1)
        P = legendre((x - panels.middle[j]) / panels.half[j], NODES)
        return np.einsum("ln,nlf->fn", P, self.coefficients[j])


class Source:
    """Tractions of a state between two points, at Gauss nodes gathered at their weak singularities and both ends."""

    def __init__(self, state, low, high, tip, ratio=0.15):
        points = np.array([low, *[x for x in state.breaks if low < x < high], high])
        smallest = np.full(len(points), KINK)
        smallest[[0, -1]] = [KINK if end in state.contact else tip for end in (low, high)]
        pieces = [
            graded(*ends, *sizes, ratio)
            for ends, sizes in zip(zip(points, points[1:]), zip(smallest, smallest[1:]))
        ]
        self.panels = Panels.between(np.unique(np.concatenate(pieces)))
        self.p, self.q = state.table(self.panels.nodes)

    def displacements(self, problem, x):
        """u_x and u_y at x, shape (2, n)."""
        even, odd = self.panels.matrices(x, problem.k)
        return np.stack(problem.displacements(even, odd, self.p, self.q))

    @property
    def loads(self):
        """∫ p and ∫ q."""
        return self.panels.weights @ self.p, self.panels.weights @ self.q


class SlipState:
    """Equilibrium at the load Q since the turn ``base``: slip with q = friction p, and stick between c_l and c_r.

    In the zones of slip p is expanded itself, in that of stick the difference to the tractions at the turn, which is
    smooth where these are not. coefficients: of p on the left, p and q in stick, p on the right.
    """

    def __init__(self, base, friction, Q, zones, coefficients, delta_x, delta_y):
        self.base, self.friction, self.Q = base, friction, Q
        self.zones, self.coefficients = zones, coefficients
        self.delta_x, self.delta_y = delta_x, delta_y
        x_l, c_l, c_r, x_r = zones.edges
        self.contact, self.stick = (x_l, x_r), (c_l, c_r)
        self.breaks = np.array([c_l, *[x for x in base.breaks if c_l < x < c_r], c_r])

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        result = np.zeros((2, len(x)))
        left, p, q, right = self.coefficients
        zone = np.searchsorted(self.zones.edges, x) - 1
        for i, c in ((0, left), (2, right)):
            here = zone == i
            result[0, here] = self.zones.values(i, x[here]) @ c
        result[1] = self.friction * result[0]
        here = zone == 1
        values = self.zones.values(1, x[here])
        result[:, here] = self.base.tractions(x[here]) + np.stack([values @ p, values @ q])
        return result

    @cached_property
    def table(self):
        """Tractions tabulated for the states that start from this one."""
        return Table(self)

    @cached_property
    def _stuck(self):
        return Source(self.base, *self.stick, TIP * self.zones.half.min(), 0.3)

    def displacements(self, problem, x):
        """u_x - delta_x and u_y - delta_y at x, shape (2, n)."""
        left, p, q, right = self.coefficients
        result = self._stuck.displacements(problem, x) - np.array([[self.delta_x], [self.delta_y]])
        for zone, c, s in ((0, left, self.friction * left), (1, p, q), (2, right, self.friction * right)):
            result += problem.displacements(*self.zones.matrices(zone, x, within=True), c, s)
        return result
