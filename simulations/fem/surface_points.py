"""The points of the surface where contact is looked for: every node of every surface cell, seen from that cell."""

from functools import cached_property

import numpy as np
from dolfinx import fem

from forms.contact import X, Y

from .body import ElasticBody
from .parallel import gathered

SIDES = -1, 1  # left and right of the contact
SAME_NODE = 1e-12  # of the contact half-width: points this close are one node's


class SurfacePoints:
    """Surface points of the cells that this rank owns, m of them; two cells that share a node have a point each.

    dofs (m,): where their values are in a ``field``; x (m,): abscissae; middle (m,): of their cells.
    """

    def __init__(self, body: ElasticBody):
        self.body, self.space = body, body.point_space
        cells = body.strip_cells[body.strip_cells < body.mesh.topology.index_map(2).size_local]
        dofs = self.space.dofmap.list[cells]
        place = self.space.tabulate_dof_coordinates()[dofs]
        height = body.cell_height.x.array[body.cell_height.function_space.dofmap.list[cells]]
        on_surface = place[..., Y] < height / 4
        x = place[..., X]
        self.dofs, self.x = dofs[on_surface], x[on_surface]
        self.middle = np.broadcast_to(x.mean(axis=1)[:, None], x.shape)[on_surface]
        self.scratch = self.field("scratch")

    def field(self, name: str) -> fem.Function:
        """A field with a value of its own at every point."""
        return fem.Function(self.space, name=name)


class AllPoints:
    """The points of all ranks, sorted by x, at a node the left cell's first: x (n,), one a node, on every rank."""

    def __init__(self, points: SurfacePoints):
        self._comm = points.body.mesh.comm
        x, middle = gathered(self._comm, points.x), gathered(self._comm, points.middle)
        self._order = np.lexsort((x, middle))  # not x first: that of a node differs in its last digits
        x = x[self._order]
        self.x = np.where(np.diff(x, prepend=-np.inf) > SAME_NODE, x, np.roll(x, 1))
        start = sum(self._comm.allgather(len(points.x))[: self._comm.rank])
        self._mine = np.argsort(self._order)[start : start + len(points.x)]

    def gathered(self, local: np.ndarray) -> np.ndarray:
        """Values (n,) of all points from those of this rank's (m,)."""
        return gathered(self._comm, local)[self._order]

    def mine(self, values: np.ndarray) -> np.ndarray:
        """Of values (n,) those of this rank's points (m,)."""
        return values[self._mine]


class PointExpression:
    """A UFL expression at the surface points, compiled when first asked for: most runs do not want all of them."""

    def __init__(self, points: SurfacePoints, value):
        self._points, self._value = points, value

    def into(self, field: fem.Function):
        """Evaluate it into a ``field`` of the points."""
        field.interpolate(self._compiled, self._points.body.strip_cells)
        field.x.scatter_forward()

    def values(self) -> np.ndarray:
        """Its values (m,)."""
        self.into(self._points.scratch)
        return self._points.scratch.x.array[self._points.dofs]

    @cached_property
    def _compiled(self):
        return fem.Expression(self._value, self._points.space.element.interpolation_points())
