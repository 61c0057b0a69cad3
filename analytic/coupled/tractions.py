"""Tractions of a state as functions of x, and the surface displacements that they cause."""

from functools import cached_property

import numpy as np

from .panels import NODES, TO_LEGENDRE, Panels, graded, legendre
from .zone import RATIO

KINK = 2e-6  # smallest panel at a weak singularity of the tractions over the distance to the next
TABLE_LEVELS, TABLE_RATIO = 11, 0.25  # times that the panels of a table shrink towards its breaks, and how much
TIP = 1e-3  # smallest panel at an edge of stick, over the half-width of the narrowest zone
COARSE = 0.15  # ratio of panels for points outside of them
FEATURE = 1e-4  # distance of an edge from another point of interest, over the width of the zone, taken for zero
# compliance of a panel's first collocation point, distance^(1-k), that rounding must not reach, and that distance over
# the panel's length
SOFTEST, FIRST_POINT = 1e-10, 2e-5
LEVELS = 6  # at most, of panels at an edge


ZONE = (0, 1, 2, 1)  # of the expansions: p in slip on the left, in stick, in slip on the right, and q in stick


class Zones:
    """Zones of slip, stick and slip between the edges x_l < c_l < c_r < x_r, images of the reference zones of ``ZONE``.

    points: collocation points of the zones.
    """

    def __init__(self, edges, references):
        self.edges, self.references = edges, references
        self.half = np.diff(edges) / 2
        zones = list(zip(edges[:3], self.half, references[:3], strict=True))
        self.points = [a + h * z.points for a, h, z in zones]
        self._elsewhere = [z.elsewhere.panels(a, h) for a, h, z in zones]

    def values(self, expansion, x):
        """Basis of an expansion at points x in its zone, shape (len(x), size)."""
        zone = ZONE[expansion]
        low, high, half = self.edges[zone], self.edges[zone + 1], self.half[zone]
        return self.references[expansion].values((x - low) / half, (high - x) / half)

    def moments(self, expansion):
        """∫ of the basis of an expansion."""
        return self.half[ZONE[expansion]] * self.references[expansion].moments

    def matrices(self, zone, x, within=False):
        """∫ R and ∫ O at points x outside a zone, or also ``within`` it: a pair for each of its expansions."""
        reference = self.references[zone]
        panels = reference.within.panels(self.edges[zone], self.half[zone]) if within else self._elsewhere[zone]
        even, odd = panels.matrices(x, reference.k)
        rules = [z.within if within else z.elsewhere for z, i in zip(self.references, ZONE, strict=True) if i == zone]
        return [(even @ rule.values, odd @ rule.values) for rule in rules]

    def own_matrices(self, expansion):
        """The same for one expansion at its zone's collocation points, from those of the reference zone."""
        reference, h = self.references[expansion], self.half[ZONE[expansion]]
        k = reference.k
        at_h = np.expm1(-k * np.log(h)) / k if k else -np.log(h)
        even, odd = reference.own
        power = 1 + k * at_h
        return h * (power * even + at_h * reference.moments), h * power * odd


def references(problem, friction, edges, base):
    """Reference zones whose panels at the edges of stick are as small as the distances to other edges ask for."""
    features = np.concatenate([edges, base.breaks, base.contact])
    half = np.diff(edges) / 2
    smallest = SOFTEST ** (1 / (1 - problem.k)) / FIRST_POINT
    result = []
    for expansion, zone in enumerate(ZONE):
        levels = []
        for end in (zone, zone + 1):
            if end in (0, 3):
                levels.append(0)
                continue
            distance = np.abs(features - edges[end])
            nearest = distance[distance > FEATURE * half[zone]].min()
            nearest = max(nearest, smallest)
            levels.append(int(np.clip(np.ceil(np.log(nearest / half[zone]) / np.log(RATIO)), 0, LEVELS)))
        result.append(problem.zone(expansion, friction, levels))
    return result


class Table:
    """Tractions of a state interpolated on panels that shrink towards its breaks, for evaluation at many points."""

    def __init__(self, state):
        points = np.array([state.contact[0], *state.breaks, state.contact[1]])
        levels = TABLE_LEVELS, TABLE_LEVELS
        pieces = [graded(a, b, *levels, TABLE_RATIO) for a, b in zip(points, points[1:], strict=False)]
        self.points = np.unique(np.concatenate(pieces))
        self.panels = Panels.between(self.points)
        values = state.tractions(self.panels.nodes).reshape(2, -1, NODES)
        self.coefficients = np.ascontiguousarray((values @ TO_LEGENDRE.T).transpose(1, 2, 0))

    def __call__(self, x):
        """p and q at x in the contact, shape (2, n)."""
        panels = self.panels
        j = np.clip(np.searchsorted(panels.low, x, side="right") - 1, 0, len(panels.low) - 1)
        P = legendre((x - panels.middle[j]) / panels.half[j], NODES)
        return np.einsum("ln,nlf->fn", P, self.coefficients[j])


class Source:
    """Tractions of a state between two points, at Gauss nodes gathered at their weak singularities and both ends.

    Between the points of a table they are polynomials, which the rule integrates without regard to where the ends are:
    for k < 0 noise in the displacements of 1e-10 would show in the tractions.
    """

    def __init__(self, state, low, high, tip, ratio=COARSE):
        breaks = getattr(state.table, "points", state.breaks)
        points = np.array([low, *breaks[(breaks > low) & (breaks < high)], high])
        pieces = [points]
        for a, b in zip(points, points[1:], strict=False):
            sizes = [1.0 if breaks is not state.breaks else KINK] * 2
            for i, end in enumerate((a, b)):
                if end in (low, high) and end not in state.contact:
                    sizes[i] = min(1.0, 2 * tip / (b - a))
            pieces.append(graded(a, b, *np.ceil(np.log(sizes) / np.log(ratio)).astype(int), ratio))
        self.panels = Panels.between(np.unique(np.concatenate(pieces)))
        self.p, self.q = state.table(self.panels.nodes)

    def displacements(self, problem, x):
        """u_x and u_y at x, shape (2, n)."""
        even, odd = self.panels.matrices(x, problem.k)
        return np.stack(problem.displacements(even @ self.p, odd @ self.p, even @ self.q, odd @ self.q))

    @property
    def loads(self):
        """∫ p and ∫ q."""
        return self.panels.weights @ self.p, self.panels.weights @ self.q


class SlipState:
    """Equilibrium at the load Q since the turn ``base``: slip with q = friction p, and stick between c_l and c_r.

    In the zones of slip p is expanded itself, in that of stick the difference to the tractions at the turn, which is
    smooth where these are not. coefficients: in the order of ``ZONE``.
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
        left, p, right, q = self.coefficients
        zone = np.searchsorted(self.zones.edges, x) - 1
        for i, c in ((0, left), (2, right)):
            here = zone == i
            result[0, here] = self.zones.values(i, x[here]) @ c
        result[1] = self.friction * result[0]
        here = zone == 1
        since = np.stack([self.zones.values(1, x[here]) @ p, self.zones.values(3, x[here]) @ q])
        result[:, here] = self.base.tractions(x[here]) + since
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
        left, p, right, q = self.coefficients
        result = self._stuck.displacements(problem, x) - np.array([[self.delta_x], [self.delta_y]])
        for zone, c, s in ((0, left, self.friction * left), (1, p, q), (2, right, self.friction * right)):
            pairs = self.zones.matrices(zone, x, within=True)
            (even, odd), (even_q, odd_q) = pairs[0], pairs[-1]
            result += problem.displacements(even @ c, odd @ c, even_q @ s, odd_q @ s)
        return result
