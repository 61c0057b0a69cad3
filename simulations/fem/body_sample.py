"""Displacement and stress inside the whole body on rank 0, at any point; dimensionless."""

from dataclasses import dataclass

import basix
import basix.ufl
import numpy as np
import ufl
from dolfinx import fem

from forms.depth_map import DepthMap

from .body import ElasticBody
from .lagrange import LOBATTO, gauss, lagrange
from .numbering import Numbering


@dataclass(frozen=True)
class BodySample:
    """One state on the tensor-product mesh of columns ``x`` (c,) and layers ``s`` (l,), mesh depth.

    displacement (d (l-1) + 1, d (c-1) + 1, 2): at the nodes of degree d. stress (l-1, c-1, d, d, 4): xx, yy, xy, zz at
    the Gauss points of each cell, where the stress of a finite element is most accurate; first index depth. It is the
    stress that carries the loads: its mean over a cell is that of the virtual work (F1), with the exact mean of E where
    E is infinite on the surface. is_half: the mesh is the half x > 0 of a symmetric body, and what is asked for at
    x < 0 is the mirror image.
    """

    x: np.ndarray
    s: np.ndarray
    depth: DepthMap
    degree: int
    displacement: np.ndarray
    stress: np.ndarray
    is_half: bool

    def displacement_at(self, x, y) -> np.ndarray:
        """Displacement (n, 2) at x, depth y (n,)."""
        nodes = np.array([*LOBATTO[self.degree][0], 1.0])
        column, along, row, down = self._places(x, y)
        steps = np.arange(self.degree + 1)
        around = self.displacement[
            (self.degree * row[:, None] + steps)[:, :, None], (self.degree * column[:, None] + steps)[:, None, :]
        ]
        values = np.einsum("ni,nj,nijk->nk", lagrange(nodes, down), lagrange(nodes, along), around)
        return values * self._parity(x, (-1, 1))

    def stress_at(self, x, y) -> np.ndarray:
        """Stress xx, yy, xy, zz (n, 4) at x, depth y (n,): in each cell the polynomial through its Gauss points."""
        nodes = gauss(self.degree)[0]
        column, along, row, down = self._places(x, y)
        inside = self.stress[row, column]
        values = np.einsum("ni,nj,nijk->nk", lagrange(nodes, down), lagrange(nodes, along), inside)
        return values * self._parity(x, (1, 1, -1, 1))

    def mean_stress(self) -> np.ndarray:
        """Stress xx, yy, xy, zz (l-1, c-1, 4): the mean over the Gauss points of each cell."""
        weights = gauss(self.degree)[1]
        return np.einsum("i,j,rcijk->rck", weights, weights, self.stress)

    def _places(self, x, y):
        """Column, share of its width, layer, share of its height in s, for each point."""
        x = np.abs(x) if self.is_half else np.asarray(x)
        s = self.depth.s(np.asarray(y, float))
        column = np.clip(np.searchsorted(self.x, x, "right") - 1, 0, len(self.x) - 2)
        row = np.clip(np.searchsorted(self.s, s, "right") - 1, 0, len(self.s) - 2)
        along = (x - self.x[column]) / (self.x[column + 1] - self.x[column])
        return column, along, row, (s - self.s[row]) / (self.s[row + 1] - self.s[row])

    def _parity(self, x, mirrored):
        """Signs (n, m) that the components have at x, for half a body those of the mirror image where x < 0."""
        left = self.is_half & (np.asarray(x) < 0)
        return np.where(left[:, None], mirrored, 1)


class BodySampler:
    """Takes a BodySample of the present state of a body."""

    def __init__(self, numbering: Numbering):
        self.body, self.numbering = numbering.body, numbering
        variant, cell = basix.LagrangeVariant.gl_warped, self.body.mesh.basix_cell()  # nodes: Gauss points of (F1)
        element = basix.ufl.element("Lagrange", cell, self.body.degree, variant, shape=(4,), discontinuous=True)
        space = fem.functionspace(self.body.mesh, element)
        self._stress = fem.Function(space)
        self._expression = fem.Expression(_stresses(self.body), space.element.interpolation_points())
        dofs = space.dofmap.list
        points = space.tabulate_dof_coordinates()[dofs]  # (cells, (d + 1)², 3)
        self._dofs = np.take_along_axis(dofs, _by_layers(points), axis=1)

    def sample(self) -> BodySample | None:
        """The present state on rank 0, None elsewhere; every rank calls it."""
        body, numbering = self.body, self.numbering
        body.complete()
        self._stress.interpolate(self._expression)
        whole = numbering.gather(body.displaced())
        stress = numbering.gather_cells(self._stress.x.array.reshape(-1, 4)[self._dofs])
        if whole is None or stress is None:
            return None
        x, s = numbering.vertices
        points, fit = body.degree + 1, _fit(body.degree)
        given = stress.reshape(len(s) - 1, len(x) - 1, points, points, 4)
        fitted = np.einsum("ai,bj,rcijk->rcabk", fit, fit, given, optimize=True)
        u = numbering.displacement(whole)
        return BodySample(x, s, body.depth, body.degree, u, fitted, body.is_half)


def _fit(count):
    """Matrix (count, count + 1): values at ``count`` Gauss points of the polynomial of that many coefficients that is
    nearest, in L2, to values at ``count + 1``.
    """
    (nodes, _), (given, weights) = gauss(count), gauss(count + 1)
    legendre = np.polynomial.legendre.legvander
    norms = 2 * np.arange(count) + 1
    return legendre(2 * nodes - 1, count - 1) @ (legendre(2 * given - 1, count - 1) * weights[:, None] * norms).T


def _by_layers(points):
    """Order (cells, m) of the points (cells, m, 3) of each cell: layer by layer, along x."""
    low, high = points.min(axis=1, keepdims=True), points.max(axis=1, keepdims=True)
    share = (points - low) / np.where(high > low, high - low, 1.0)
    return np.argsort(np.round(100 * share[..., 1]) + share[..., 0] / 10, axis=1)


def _stresses(body: ElasticBody):
    sigma = body.stress()
    return ufl.as_vector([sigma[0, 0], sigma[1, 1], sigma[0, 1], body.nu * ufl.tr(sigma)])
