"""Numbers of nodes and cells by column and layer of the tensor-product mesh, the same on any number of ranks."""

import numpy as np
from dolfinx import fem

from .body import ElasticBody
from .edge_place import LOBATTO


class Numbering:
    """Places of the nodes on the tensor-product mesh of columns ``x`` (c,) and layers ``s`` (l,).

    Degree d: node (row, column) of the (d (l - 1) + 1, d (c - 1) + 1) vertices and nodes between them. In the mixed
    form the mean stress follows with its own, of degree d - 1.
    """

    def __init__(self, body: ElasticBody, x: np.ndarray, s: np.ndarray):
        self.body, self.comm = body, body.mesh.comm
        self._degree = body.degree
        self._x, self._s = (_with_nodes_between(nodes, self._degree) for nodes in (x, s))
        self.shape = len(self._s), len(self._x)
        self._places: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []  # index in ``state``, place, is owned
        size = body.space.dofmap.index_map.size_local * body.space.dofmap.index_map_bs
        node = _number(body.displacements.tabulate_dof_coordinates(), self._x, self._s)
        dofs = body.dofs.ravel()
        self._add(dofs, (2 * node[:, None] + np.arange(2)).ravel(), size)
        self.size = 2 * len(self._s) * len(self._x)
        if body.mixed:
            space, inside = body.space.sub(1).collapse()
            grid = [_with_nodes_between(nodes, self._degree - 1) for nodes in (x, s)]
            self._add(np.asarray(inside), self.size + _number(space.tabulate_dof_coordinates(), *grid), size)
            self.size += len(grid[0]) * len(grid[1])
        self._make_points()

    def gather(self, local: np.ndarray) -> np.ndarray | None:
        """The whole ``state``-like array (size,), on rank 0, from the ranks' local ones."""
        index, place = (np.concatenate(parts) for parts in zip(*((i[m], p[m]) for i, p, m in self._places)))
        return self._collect(place, local[index], self.size)

    def scatter(self, whole: np.ndarray, local: np.ndarray):
        """Fill the local ``state``-like array, ghosts included, from the whole one."""
        for index, place, _ in self._places:
            local[index] = whole[place]

    def gather_field(self, field: fem.Function) -> np.ndarray | None:
        """``gather`` of the unknowns; (columns, d + 1, d + 1) of a field of the surface points, nan off the strip."""
        return (self._gather_points if self._is_of_points(field) else self.gather)(field.x.array)

    def scatter_field(self, whole: np.ndarray, field: fem.Function):
        """The inverse of ``gather_field``, on every rank."""
        (self._scatter_points if self._is_of_points(field) else self.scatter)(whole, field.x.array)

    def _is_of_points(self, field):
        return field.function_space == self.body.point_space

    @property
    def vertices(self) -> tuple[np.ndarray, np.ndarray]:
        """Columns (c,) and layers (l,) of the mesh."""
        return self._x[:: self._degree], self._s[:: self._degree]

    @property
    def cells(self) -> int:
        """Number of cells."""
        x, s = self.vertices
        return (len(s) - 1) * (len(x) - 1)

    def displacement(self, whole: np.ndarray) -> np.ndarray:
        """Displacement (rows, columns, 2) at the nodes, from a whole ``state``."""
        return whole[: 2 * self._s.size * self._x.size].reshape(*self.shape, 2)

    def gather_cells(self, local: np.ndarray) -> np.ndarray | None:
        """Rows (m, ...) of a value a cell, layer by layer, on rank 0."""
        topology = self.body.mesh.topology
        count, geometry = topology.index_map(topology.dim).size_local, self.body.mesh.geometry
        x, s, _ = geometry.x[geometry.dofmap[:count]].mean(axis=1).T
        columns, layers = self.vertices
        column, row = np.searchsorted(columns, x) - 1, np.searchsorted(layers, s) - 1
        return self._collect(row * (len(columns) - 1) + column, local[:count], self.cells)

    def _add(self, index, place, owned):
        self._places.append((index, place, index < owned))

    def _gather_points(self, local: np.ndarray) -> np.ndarray | None:
        """Values at the points of the cells along the surface, (columns, d + 1, d + 1) on rank 0; nan off the strip."""
        count = ((len(self._x) - 1) // self._degree) * (self._degree + 1) ** 2
        owned = self._point_owned
        whole = self._collect(self._point_place[owned], local[self._point_index[owned]], count)
        return None if whole is None else whole.reshape(-1, self._degree + 1, self._degree + 1)

    def _scatter_points(self, whole: np.ndarray, local: np.ndarray):
        """The inverse of ``_gather_points``, on every rank."""
        local[self._point_index] = whole.ravel()[self._point_place]

    def _make_points(self):
        body, space = self.body, self.body.point_space
        cells, geometry = body.strip_cells, body.mesh.geometry
        middle = geometry.x[geometry.dofmap[cells], 0].mean(axis=1)
        column = np.searchsorted(self._x[:: self._degree], middle) - 1
        index = space.dofmap.list[cells]
        points = space.tabulate_dof_coordinates()[index]  # (cells, (d + 1)², 3)
        across = nearest(self._x, points[..., 0]) - self._degree * column[:, None]
        nodes = self._degree + 1
        self._point_place = ((column[:, None] * nodes + across) * nodes + nearest(self._s, points[..., 1])).ravel()
        self._point_index = index.ravel()
        self._point_owned = self._point_index < space.dofmap.index_map.size_local

    def _collect(self, place, values, size):
        parts = self.comm.gather((place, values))
        if parts is None:
            return None
        whole = np.full((size, *values.shape[1:]), np.nan)
        for where, what in parts:
            whole[where] = what
        return whole


def _with_nodes_between(vertices, degree):
    shares, _ = LOBATTO[degree]  # where dolfinx has its nodes
    nodes = vertices[:-1, None] + np.array(shares) * np.diff(vertices)[:, None]
    return np.append(nodes.ravel(), vertices[-1])


def _number(points, x, s):
    """Places of points (n, 3) among the nodes of columns x and layers s."""
    return nearest(s, points[:, 1]) * len(x) + nearest(x, points[:, 0])


def nearest(grid, values):
    """Index in the increasing ``grid`` of the entry nearest to each of the ``values``."""
    after = np.clip(np.searchsorted(grid, values), 1, len(grid) - 1)
    return after - (values - grid[after - 1] < grid[after] - values)
