"""The displacement nodes on the surface where contact is looked for, of all ranks."""

import numpy as np
from dolfinx import fem

from .parallel import gathered


class SurfaceNodes:
    """Nodes of ``facets``, n of all ranks, of which this rank owns m.

    touched: owned and ghost nodes, to which this rank's facets contribute; owned (m,): among them; x (n,): abscissae of
    all, sorted, on every rank.
    """

    def __init__(self, displacements: fem.FunctionSpace, facets: np.ndarray):
        self._comm = displacements.mesh.comm
        self.touched = fem.locate_dofs_topological(displacements, 1, facets)
        self.owned = self.touched[self.touched < displacements.dofmap.index_map.size_local]
        x = gathered(self._comm, displacements.tabulate_dof_coordinates()[self.owned, 0])
        self.order = np.argsort(x)
        self.x = x[self.order]

    def collect(self, owned: np.ndarray) -> np.ndarray:
        """Rows (n, ...) sorted by x, on every rank, from those (m, ...) of the owned nodes."""
        return gathered(self._comm, owned)[self.order]
