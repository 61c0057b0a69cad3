"""Displacement and stress inside the body as XDMF, for ParaView and other readers."""

from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.io import XDMFFile

from forms import elasticity

from .problem import HalfPlane
from .scaling import Scales


class FieldWriter:
    """fields.xdmf in SI units on the physical mesh: x along the surface, y the depth.

    Displacement at the vertices; stress (xx, yy, xy) and von Mises stress of plane strain at cell centres.
    """

    def __init__(self, path: Path, body: HalfPlane, scales: Scales):
        self.body, self.scales = body, scales
        mesh = body.mesh
        cells = fem.functionspace(mesh, ("DG", 0))
        cell_tensors = fem.functionspace(mesh, ("DG", 0, (3,)))
        self._displacement = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (2,))), name="displacement [m]")
        self._stress = fem.Function(cell_tensors, name="stress xx, yy, xy [Pa]")
        self._von_mises = fem.Function(cells, name="von Mises stress [Pa]")

        s = body.position[1]
        gradient = body.depth.gradient(body.u, s)
        sigma = elasticity.stress(body.modulus.young(body.depth.y(s)) * gradient, body.nu)
        across = body.nu * ufl.tr(sigma)  # sigma_zz of plane strain
        deviator = [sigma[0, 0] - sigma[1, 1], sigma[1, 1] - across, across - sigma[0, 0]]
        von_mises = ufl.sqrt(sum(d**2 for d in deviator) / 2 + 3 * sigma[0, 1] ** 2)
        centre = cells.element.interpolation_points()
        components = ufl.as_vector([sigma[0, 0], sigma[1, 1], sigma[0, 1]])
        self._expressions = {
            self._stress: fem.Expression(components, centre),
            self._von_mises: fem.Expression(von_mises, centre),
        }
        self._file = XDMFFile(mesh.comm, path, "w")
        self._write_physical_mesh()

    def write(self, time: float):
        """Append the present state at ``time`` (the number of the increment)."""
        self._displacement.interpolate(self.body.u)
        self._displacement.x.array[:] *= self.scales.displacement
        self._file.write_function(self._displacement, time)
        for field, expression in self._expressions.items():
            field.interpolate(expression)
            field.x.array[:] *= self.scales.stress
            self._file.write_function(field, time)

    def close(self):
        """Finish the file."""
        self._file.close()

    def _write_physical_mesh(self):
        nodes = self.body.mesh.geometry.x
        solved = nodes.copy()
        nodes[:, 1] = self.body.depth.y(np.maximum(solved[:, 1], 0.0))
        nodes *= self.scales.length
        self._file.write_mesh(self.body.mesh)
        nodes[:] = solved
