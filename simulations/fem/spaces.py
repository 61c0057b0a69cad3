"""Function space of the body's unknowns, and its nodes on the surface where contact is looked for, of all ranks."""

import basix.ufl
import numpy as np
from dolfinx import fem

from .parallel import gathered


def create_space(mesh, degree: int, mixed: bool) -> tuple[fem.FunctionSpace, fem.FunctionSpace, np.ndarray]:
    """Lagrange elements of ``degree``, 1 to 3; mixed: with a mean stress of one degree less (Taylor and Hood).

    The space of all unknowns, that of the displacements alone, and dofs (n, 2): where in the first the displacements of
    node n are.
    """
    cell = mesh.basix_cell()
    element = basix.ufl.element("Lagrange", cell, degree, shape=(2,))
    if mixed:
        pair = basix.ufl.mixed_element([element, basix.ufl.element("Lagrange", cell, degree - 1)])
        space = fem.functionspace(mesh, pair)
        displacements, dofs = space.sub(0).collapse()
    else:
        space = displacements = fem.functionspace(mesh, element)
        dofs = np.arange(2 * len(space.tabulate_dof_coordinates()))
    return space, displacements, np.asarray(dofs, dtype=np.int32).reshape(-1, 2)


class SurfaceNodes:
    """Displacement nodes of ``facets``, n of all ranks, of which this rank owns m.

    touched: owned and ghost nodes on the facets of any rank; owned (m,): among them; x (n,): abscissae of all, sorted,
    on every rank.
    """

    def __init__(self, displacements: fem.FunctionSpace, facets: np.ndarray):
        self._comm = displacements.mesh.comm
        self.touched = fem.locate_dofs_topological(displacements, 1, facets)
        self.owned = self.touched[self.touched < displacements.dofmap.index_map.size_local]
        x = gathered(self._comm, displacements.tabulate_dof_coordinates()[self.owned, 0])
        self._order = np.argsort(x)
        self.x = x[self._order]

    def collect(self, owned: np.ndarray) -> np.ndarray:
        """Rows (n, ...) sorted by x, on every rank, from those (m, ...) of the owned nodes."""
        return gathered(self._comm, owned)[self._order]
