"""Displacement and stress inside the body as XDMF, for ParaView and other readers."""

from contextlib import chdir
from pathlib import Path

import meshio
import numpy as np
import ufl
from dolfinx import fem

from forms import elasticity

from .body import HalfPlane
from .scaling import Scales


class FieldWriter:
    """fields.xdmf (and fields.h5) in SI units on the physical mesh: x along the surface, y the depth.

    Displacement at the vertices; stress (xx, yy, xy) and von Mises stress of plane strain at cell centres. All
    fields of a state lie in one grid of one time series, which every reader understands; rank 0 writes it.
    """

    def __init__(self, path: Path, body: HalfPlane, scales: Scales):
        self.body, self.scales, self.comm = body, scales, body.mesh.comm
        self._vertices = fem.functionspace(body.mesh, ("Lagrange", 1, (2,)))
        self._cells = fem.functionspace(body.mesh, ("DG", 0, (4,)))
        self._displacement, self._stress = fem.Function(self._vertices), fem.Function(self._cells)
        self._stress_expression = fem.Expression(self._stresses(), self._cells.element.interpolation_points())
        mesh = self._gather_mesh()
        if self.comm.rank == 0:
            self._writer = meshio.xdmf.TimeSeriesWriter(path.name)
            self._folder = path.parent.resolve()
            with chdir(self._folder):  # meshio puts its HDF5 file into the current folder
                self._writer.__enter__()
                self._writer.write_points_cells(*mesh)

    def write(self, time: float):
        """Append the present state at ``time`` (the number of the increment)."""
        self._displacement.interpolate(self.body.displacement())
        self._stress.interpolate(self._stress_expression)
        u = self._gather_owned(self._displacement) * self.scales.displacement
        stress = self._gather_owned(self._stress) * self.scales.stress
        if self.comm.rank == 0:
            at_cells = {"stress xx, yy, xy [Pa]": [stress[:, :3]], "von Mises stress [Pa]": [stress[:, 3]]}
            u = np.column_stack([u, np.zeros(len(u))])  # a vector to ParaView has three components
            self._writer.write_data(time, {"displacement [m]": u}, at_cells)

    def close(self):
        """Finish the file."""
        if self.comm.rank == 0:
            with chdir(self._folder):
                self._writer.__exit__()

    def _stresses(self):
        body, sigma = self.body, self.body.stress()
        return ufl.as_vector([sigma[0, 0], sigma[1, 1], sigma[0, 1], elasticity.von_mises(sigma, body.nu)])

    def _gather_owned(self, field):
        """Values of the owned dofs of all ranks in global order, on rank 0."""
        space = field.function_space
        owned = field.x.array[: space.dofmap.index_map.size_local * space.dofmap.bs]
        blocks = self.comm.gather(owned.reshape(-1, space.dofmap.bs))
        return np.concatenate(blocks) if self.comm.rank == 0 else np.zeros((0, 1))

    def _gather_mesh(self):
        """Points and cells in SI units, numbered like the gathered fields, on rank 0."""
        dofmap = self._vertices.dofmap
        points = self._vertices.tabulate_dof_coordinates()[: dofmap.index_map.size_local, :2].copy()
        points[:, 1] = self.body.depth.y(np.maximum(points[:, 1], 0.0))
        count = self.body.mesh.topology.index_map(2).size_local
        corners = dofmap.list[:count][:, [0, 1, 3, 2]]  # tensor order to round the cell
        cells = dofmap.index_map.local_to_global(corners.ravel().astype(np.int32)).reshape(-1, 4)
        points, cells = self.comm.gather(points), self.comm.gather(cells)
        if self.comm.rank == 0:
            return np.concatenate(points) * self.scales.length, [("quad", np.concatenate(cells))]
