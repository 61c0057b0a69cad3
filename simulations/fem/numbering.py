"""Numbers of nodes and cells by column and layer of the tensor-product mesh, the same on any number of ranks."""

import numpy as np
from dolfinx import fem

from .body import ElasticBody
from .lagrange import LOBATTO


class Numbering:
    """Places of the nodes on the tensor-product mesh of columns ``x`` (c,) and layers ``s`` (l,), its ``vertices``.

    Degree d: node (row, column) of the (d (l - 1) + 1, d (c - 1) + 1) vertices and nodes between them. In the mixed
    form the mean stress follows with its own, of degree d - 1.
    """

    def __init__(self, body: ElasticBody, x: np.ndarray, s: np.ndarray):
        self.body, self.comm, self.vertices = body, body.mesh.comm, (x, s)
        self.cells = (len(s) - 1) * (len(x) - 1)
        # LOBATTO has the nodes where dolfinx has them
        self._x, self._s = (with_nodes_between(nodes, LOBATTO[body.degree][0]) for nodes in (x, s))
        self.shape = len(self._s), len(self._x)
        node = _number(body.displacements.tabulate_dof_coordinates(), self._x, self._s)
        index, place = body.dofs.ravel(), (2 * node[:, None] + np.arange(2)).ravel()
        self.size = 2 * len(self._s) * len(self._x)
        if body.mixed:
            space, inside = body.space.sub(1).collapse()
            grid = [with_nodes_between(nodes, LOBATTO[body.degree - 1][0]) for nodes in (x, s)]
            index = np.append(index, inside)
            place = np.append(place, self.size + _number(space.tabulate_dof_coordinates(), *grid))
            self.size += len(grid[0]) * len(grid[1])
        owned = index < body.space.dofmap.index_map.size_local * body.space.dofmap.index_map_bs
        self._of_state, self._of_points = (index, place, owned), self._points()

    def gather(self, local: np.ndarray) -> np.ndarray | None:
        """The whole ``state``-like array (size,), on rank 0, from the ranks' local ones."""
        return self._gather(self._of_state, local, self.size)

    def scatter(self, whole: np.ndarray, local: np.ndarray):
        """Fill the local ``state``-like array, ghosts included, from the whole one."""
        index, place, _ = self._of_state
        local[index] = whole[place]

    def gather_field(self, field: fem.Function) -> np.ndarray | None:
        """``gather`` of the unknowns; (c - 1, d + 1, d + 1) of a field of the surface points, nan off the strip."""
        if not self._is_of_points(field):
            return self.gather(field.x.array)
        nodes = self.body.degree + 1
        whole = self._gather(self._of_points, field.x.array, (len(self.vertices[0]) - 1) * nodes**2)
        return None if whole is None else whole.reshape(-1, nodes, nodes)

    def scatter_field(self, whole: np.ndarray, field: fem.Function):
        """The inverse of ``gather_field``, on every rank."""
        index, place, _ = self._of_points if self._is_of_points(field) else self._of_state
        field.x.array[index] = whole.ravel()[place]

    def _is_of_points(self, field):
        return field.function_space == self.body.point_space

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

    def _points(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of the surface points: index in a field of them, place among those of all columns, and which are owned."""
        body, space = self.body, self.body.point_space
        cells, geometry = body.strip_cells, body.mesh.geometry
        middle = geometry.x[geometry.dofmap[cells], 0].mean(axis=1)
        column = np.searchsorted(self.vertices[0], middle) - 1
        index = space.dofmap.list[cells]
        points = space.tabulate_dof_coordinates()[index]  # (cells, (d + 1)², 3)
        across = nearest(self._x, points[..., 0]) - body.degree * column[:, None]
        nodes = body.degree + 1
        place = (column[:, None] * nodes + across) * nodes + nearest(self._s, points[..., 1])
        return index.ravel(), place.ravel(), index.ravel() < space.dofmap.index_map.size_local

    def _gather(self, numbers, local, size):
        index, place, owned = numbers
        return self._collect(place[owned], local[index[owned]], size)

    def _collect(self, place, values, size):
        parts = self.comm.gather((place, values))
        if parts is None:
            return None
        whole = np.full((size, *values.shape[1:]), np.nan)
        for where, what in parts:
            whole[where] = what
        return whole


def with_nodes_between(vertices, shares) -> np.ndarray:
    """Nodes at these shares of the way from each of the vertices to the next, and the last vertex."""
    nodes = vertices[:-1, None] + np.array(shares) * np.diff(vertices)[:, None]
    return np.append(nodes.ravel(), vertices[-1])


def _number(points, x, s):
    """Places of points (n, 3) among the nodes of columns x and layers s."""
    return nearest(s, points[:, 1]) * len(x) + nearest(x, points[:, 0])


def nearest(grid, values):
    """Index in the increasing ``grid`` of the entry nearest to each of the ``values``."""
    after = np.clip(np.searchsorted(grid, values), 1, len(grid) - 1)
    return after - (values - grid[after - 1] < grid[after] - values)
