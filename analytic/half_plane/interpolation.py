"""Interpolation of tractions between nodes: exact for their roots at the edges, of fourth order away from them."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ..quadrature import gauss_rule

POWERS = 4  # coefficients per element, of 1, t, t², t³ with t = 0..1 along it
REACH, GUARD = 0.05, 0.005  # over the width of the contact, see adapted


@dataclass(frozen=True)
class Edges:
    """Where tractions end like a root, at ``position`` [length], towards ``side``: +1 if the root is on its right."""

    position: np.ndarray
    side: np.ndarray

    @classmethod
    def of_zones(cls, zones):
        """Left and right edges of ``zones``, shape (n, 2), with their roots inside."""
        zones = np.asarray(zones, dtype=float).reshape(-1, 2)
        return cls(zones.ravel(), np.tile([1.0, -1.0], len(zones)))

    def __add__(self, other):
        return Edges(np.append(self.position, other.position), np.append(self.side, other.side))

    def only(self, mask):
        """The edges selected by ``mask``."""
        return Edges(self.position[mask], self.side[mask])


def linear(nodes):
    """Straight lines between the nodes: coefficients, shape (4, elements, nodes)."""
    j = np.arange(len(nodes) - 1)
    result = np.zeros((POWERS, len(j), len(nodes)))
    result[0, j, j] = 1
    result[1, j, j], result[1, j, j + 1] = -1, 1
    return result


def adapted(nodes, edges: Edges, other_edges: Edges, exponent, width):
    """Coefficients, shape (4, elements, nodes), that follow roots distance^exponent at ``edges``.

    Within REACH of the ``width`` from an edge, on the side of its root, an element takes A + B distance^exponent, which
    is monotone and as robust as a straight line; elsewhere the cubic through the four nearest nodes, but for
    the straight line within GUARD of the width from any edge, since the status of nodes changes there.
    """
    result = linear(nodes)
    length, middle = np.diff(nodes), (nodes[1:] + nodes[:-1]) / 2
    inwards = (middle[:, None] - edges.position) * edges.side
    inwards[inwards <= 0] = np.inf
    nearest, inwards = inwards.argmin(axis=1), inwards.min(axis=1)
    everywhere = np.append(edges.position, other_edges.position)
    distance = np.abs(middle[:, None] - everywhere).min(axis=1)
    cubic = (inwards > REACH * width) & (distance > GUARD * width)
    cubic[[0, -1]] = False
    _put_cubics(result, nodes, np.flatnonzero(cubic))
    root = np.flatnonzero((inwards <= REACH * width) & (inwards > 0.5 * length))
    _put_roots(result, nodes, root, edges.position[nearest[root]], exponent)
    return result


@dataclass(frozen=True)
class Interpolant:
    """Traction between ``nodes`` (n,) with these ``coefficients`` (4, n - 1), zero beyond."""

    nodes: np.ndarray
    coefficients: np.ndarray

    @classmethod
    def of(cls, nodes, interpolation, values):
        """From the ``values`` (n,) at the nodes by an ``interpolation`` (4, n - 1, n)."""
        return cls(nodes, np.einsum("ren,n->re", interpolation, values))

    def __call__(self, x):
        """Values at x."""
        nodes = self.nodes
        element = np.clip(np.searchsorted(nodes, x) - 1, 0, len(nodes) - 2)
        t = (x - nodes[element]) / (nodes[element + 1] - nodes[element])
        result = np.polynomial.polynomial.polyval(t, self.coefficients[:, element], tensor=False)
        return np.where((x >= nodes[0]) & (x <= nodes[-1]), result, 0.0)

    def integral(self, smooth) -> float:
        """∫ of it times the cubic spline through ``smooth`` (n,) at the nodes."""
        length, spline = np.diff(self.nodes), CubicSpline(self.nodes, smooth)
        t, weight = gauss_rule(POWERS)
        values = np.einsum("re,rg->eg", self.coefficients, t ** np.arange(POWERS)[:, None])
        return float(length @ (values * spline(self.nodes[:-1, None] + length[:, None] * t)) @ weight)


def _put_roots(result, nodes, j, edge, exponent):
    """A + B |ξ - edge|^exponent through both nodes of each element, as a cubic in t (error (length/distance)^4)."""
    t = np.linspace(0, 1, POWERS)
    x = nodes[j, None] + t * (nodes[j + 1] - nodes[j])[:, None]
    value = np.abs(x - edge[:, None]) ** exponent
    shape = (value - value[:, :1]) / (value[:, -1:] - value[:, :1])
    coefficients = np.linalg.solve(np.vander(t, increasing=True), shape.T)
    result[1:, j, j] = -coefficients[1:]
    result[1:, j, j + 1] = coefficients[1:]


def _put_cubics(result, nodes, j):
    """Lagrange's cubic through the nodes j-1..j+2."""
    stencil = j[:, None] + np.arange(-1, 3)
    t = (nodes[stencil] - nodes[j, None]) / (nodes[j + 1] - nodes[j])[:, None]
    coefficients = np.linalg.inv(t[..., None] ** np.arange(POWERS))
    result[:, j[:, None], stencil] = coefficients.transpose(1, 0, 2)
