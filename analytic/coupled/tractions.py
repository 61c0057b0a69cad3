"""Tractions of a state as functions of x, and the surface displacements that they cause."""

from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander

from .panels import GAUSS, NODES, TO_LEGENDRE, Panels, divided, graded
from .problem import Problem

RATIO = 0.3  # of panels that shrink towards the breaks of a state
SMALLEST_PANEL, SMALLEST_PANEL_STEEP = 3e-6, 3e-8  # of them, and for k < 0, where tractions end more steeply
MERGED = 0.6  # length that panels at a break are merged to, over the distance of the nearest other point
CLOSE = 1e-7  # breaks closer than that are one


class Interpolated:
    """Functions with the values (fields, nodes) at the nodes of panels."""

    def __init__(self, panels, values):
        self.panels = panels
        values = values.reshape(len(values), -1, NODES) @ TO_LEGENDRE.T
        self._coefficients = np.ascontiguousarray(values.transpose(1, 2, 0))

    def __call__(self, x):
        """All of them at x, shape (fields, n)."""
        panels = self.panels
        j = np.clip(np.searchsorted(panels.low, x, side="right") - 1, 0, len(panels.low) - 1)
        P = legvander((x - panels.middle[j]) / panels.half[j], NODES - 1)
        return np.einsum("nl,nlf->fn", P, self._coefficients[j])


def shrinking(points, k, longest=np.inf, at_ends=True):
    """Panels between points, which shrink towards each of them, or all but the first and the last; see ``divided``."""
    pieces, last, smallest = [], len(points) - 2, SMALLEST_PANEL if k >= 0 else SMALLEST_PANEL_STEEP
    for i, (a, b) in enumerate(zip(points, points[1:], strict=False)):
        levels = max(int(np.ceil(np.log(2 * smallest / (b - a)) / np.log(RATIO))), 0)
        pieces.append(graded(a, b, levels * (at_ends or i > 0), levels * (at_ends or i < last), RATIO))
    return Panels.between(divided(np.unique(np.concatenate(pieces)), longest))


def _merged(fine, values, breaks, x):
    """Panels and values (n, NODES) at their nodes, those close to the breaks but not to any x made one on each side.

    There the values become those of polynomials, which have the same integrals with all polynomials of that degree.
    """
    keep = np.ones(len(fine.low), dtype=bool)  # panels whose lower point is kept
    for point in breaks:
        reach = MERGED * np.abs(x - point).min()
        keep &= ~((fine.low > point) & (fine.high <= point + reach)) | (fine.low == point)
        keep[1:] &= ~((fine.low[1:] < point) & (fine.low[:-1] >= point - reach))
    panels = Panels.between(np.append(fine.low[keep], fine.high[-1]))
    j = np.repeat(np.cumsum(keep) - 1, NODES)
    P = legvander((fine.nodes - panels.middle[j]) / panels.half[j], NODES - 1).T
    moments = np.add.reduceat(P * (fine.weights * values.ravel()), NODES * np.flatnonzero(keep), axis=1)
    coefficients = moments / panels.half * (np.arange(NODES)[:, None] + 0.5)
    return panels, (coefficients.T @ legvander(GAUSS, NODES - 1).T).ravel()


class StateOnContact:
    """Surface displacements that tractions on a contact cause.

    contact: its edges; breaks: where tractions are not smooth; delta_x, delta_y: displacements of the indenter.
    """

    problem: Problem
    contact: tuple[float, float]
    breaks: np.ndarray
    delta_x: float
    delta_y: float

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        raise NotImplementedError

    @cached_property
    def _panels(self):
        """They shrink towards the edges of contact too."""
        points = [self.contact[0], *self.breaks, self.contact[1]]
        return shrinking(points, self.problem.k, self.problem.longest)

    @cached_property
    def _sampled(self):
        """p and q at the nodes of ``_panels``, shape (2, panels, NODES)."""
        return self.tractions(self._panels.nodes).reshape(2, -1, NODES)

    def limit_between(self, friction, low, high, x):
        """Panels between two points, and friction p - q at their nodes, for integrals with kernels that end at x."""
        sampled, values = self._panels, self._sampled
        first, last = np.searchsorted(sampled.low, low, side="right"), np.searchsorted(sampled.low, high)
        panels = Panels.between(np.array([low, *sampled.low[first:last], high]))
        p, q = values[:, first - 1 : last].copy()
        for i, panel in ((0, slice(NODES)), (-1, slice(-NODES, None))):  # cut off
            p[i], q[i] = self.tractions(panels.nodes[panel])
        return _merged(panels, friction * p - q, self.breaks[(self.breaks > low) & (self.breaks < high)], x)

    @cached_property
    def _sources(self):
        """Panels over the contact, with p and q at their nodes."""
        return self._panels, *self._sampled.reshape(2, -1)

    def _integrals(self, x):
        panels, p, q = self._sources
        even, odd = panels.matrices(x, self.problem.k)
        result = np.stack(self.problem.displacements(even @ p, odd @ p, even @ q, odd @ q))
        if not self.problem.regular:
            return result
        if self.problem.kinks is not None:  # |z| = z O and z ln|z| = -z R
            n, t, d = self.problem.kinks
            z_even, z_odd = ([m @ f * x - m @ (panels.nodes * f) for f in (p, q)] for m in (even, odd))
            result += np.stack([t * z_odd[1] - d * z_even[0], n * z_odd[0] + d * z_even[1]])
        few = Panels.between(divided(np.array([x.min(), x.max()]), self.problem.longest))
        if len(x) <= len(few.nodes):
            return result + self._of_layers(x)
        return result + Interpolated(few, self._of_layers(few.nodes))(x)

    def _of_layers(self, x):
        panels, p, q = self._sources
        N, T, D = self.problem.of_layers(x, panels.nodes) * panels.weights @ np.stack([p, q], axis=1)
        return np.stack([T[:, 1] + D[:, 0], N[:, 0] - D[:, 1]])

    @cached_property
    def _moved(self):
        return Interpolated(self._panels, self._integrals(self._panels.nodes)[:1])

    def moved(self, x):
        """u_x at x in the contact, interpolated."""
        return self._moved(x)[0]

    def displacements(self, x):
        """u_x - delta_x and u_y - delta_y at x, shape (2, n)."""
        return self._integrals(x) - np.array([self.delta_x, self.delta_y])[:, None]


class SlipState(StateOnContact):
    """Equilibrium at the load Q since the turn ``base``: slip with q = friction p, and stick between c_l and c_r.

    area: the ``ContactInterval``; zone: the ``StickBasis``; coefficients: of r = friction p - q in it; factors: alpha
    and beta of ``linear.solve``; full_slip: p/w without r, a Chebyshev series; differs: the coefficients of polynomials
    are those of the difference to the base.
    """

    def __init__(self, base, Q, area, zone, coefficients, factors, full_slip, differs):
        self.problem, self.base, self.friction, self.Q = base.problem, base, area.friction, Q
        self.area, self.zone, self.coefficients = area, zone, coefficients
        self.factors, self.full_slip, self._differs = factors, full_slip, differs
        self.contact = area.x_l, area.x_r
        c_l, c_r = self.stick = zone.breaks[0], zone.breaks[-1]
        tolerance = CLOSE * (c_r - c_l)
        self.breaks = np.array([c_l, *[x for x in base.breaks if c_l + tolerance < x < c_r - tolerance], c_r])

    def limit(self, x):
        """r at x in the zone of stick."""
        result = self.zone.values(x, self.coefficients)
        if self._differs:
            within = (x >= self.zone.inner[0]) & (x < self.zone.inner[-1])
            p, q = self.base.tractions(x[within])
            result[within] += self.friction * p - q
        return result

    @cached_property
    def table(self):
        """p/w without what r adds to it, and r, on panels that shrink towards the breaks."""
        points, (c_l, c_r) = [self.contact[0], *self.breaks, self.contact[1]], self.stick
        panels = shrinking(points, self.problem.k, self.problem.longest, at_ends=False)
        x, r = panels.nodes, np.zeros(len(panels.nodes))
        inside = (panels.middle > c_l) & (panels.middle < c_r)
        stuck, at_nodes = Panels(panels.low[inside], panels.high[inside]), np.repeat(inside, NODES)
        r[at_nodes] = self.limit(stuck.nodes)
        H = stuck.cauchy(x) @ (r[at_nodes] / self.area.weight(stuck.nodes))
        return Interpolated(panels, np.stack([self.factors[1] * H + self.full_slip(self.area.local(x)[0]), r]))

    def tractions(self, x):
        """p and q at x in the contact, shape (2, n)."""
        smooth, r = self.table(x)
        p = self.factors[0] * r + self.area.weight(x) * smooth
        return np.stack([p, self.friction * p - r])

    @cached_property
    def _sources(self):
        """Panels over the contact that shrink towards its edges too, with p and q at their nodes."""
        edges = self.area.panels(self.stick)
        points = np.concatenate([edges.low, edges.high[-1:], self.table.panels.low])
        panels = Panels.between(np.unique(points))
        return panels, *self.tractions(panels.nodes)

    @cached_property
    def _rigid(self):
        """delta_x and delta_y, from the displacement of a point in stick."""
        x = np.array([(self.stick[0] + self.stick[1]) / 2])
        u_x, u_y = self._integrals(x)[:, 0]
        return u_x - self.base.displacements(x)[0, 0], u_y + self.problem.height(x)[0]

    delta_x = property(lambda self: self._rigid[0])
    delta_y = property(lambda self: self._rigid[1])
