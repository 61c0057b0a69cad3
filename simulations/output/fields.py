"""Displacement and stress inside the body as XDMF, for ParaView and other readers."""

from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem

from forms import elasticity

from ..fem.numbering import Numbering
from ..scene.scaling import Scales
from .files import hdf5, write_text

INDEX, FOLDER = "fields.xdmf", "fields"
DISPLACEMENT, STRESS, VON_MISES = "displacement [m]", "stress xx, yy, xy [Pa]", "von Mises stress [Pa]"


class FieldWriter:
    """fields.xdmf and fields/*.h5 in SI units on the physical mesh: x along the surface, y the depth.

    Displacement at the vertices; stress (xx, yy, xy) and von Mises stress of plane strain at cell centres. A file a
    state, and an index of the states that are whole; the numbering is that of the columns and layers, whatever the
    ranks. Every rank calls ``write``; rank 0 writes.
    """

    def __init__(self, folder: Path, numbering: Numbering, scales: Scales):
        self.folder, self.numbering, self.scales = folder, numbering, scales
        self.body, self.comm = numbering.body, numbering.comm
        self._cells = fem.functionspace(self.body.mesh, ("DG", 0, (4,)))
        self._stress = fem.Function(self._cells)
        self._stress_expression = fem.Expression(self._stresses(), self._cells.element.interpolation_points())
        self._size = numbering.vertices, numbering.cells

    def write(self, number: int, numbers: list[int]):
        """Keep the present state as that of increment ``number``; ``numbers`` are all increments in the index."""
        self.body.complete()
        self._stress.interpolate(self._stress_expression)
        u = self.numbering.gather(self.body.state.x.array)
        stress = self.numbering.gather_cells(self._stress.x.array.reshape(-1, 4))
        if u is not None and stress is not None:
            (self.folder / FOLDER).mkdir(exist_ok=True)
            mesh = self._path("mesh")
            if not mesh.exists():
                points, cells = self.numbering.mesh()
                self._keep(mesh, {"points": points * self.scales.length, "cells": cells})
            u = self.numbering.at_vertices(u)
            if self.body.strain is not None:
                u = u + self.body.stretching(*self.numbering.mesh()[0][:, :2].T)
            u = u * self.scales.displacement
            u = np.column_stack([u, np.zeros(len(u))])  # a vector to ParaView has three components
            stress *= self.scales.stress
            state = {"displacement": u, "stress": stress[:, :3], "von_mises": stress[:, 3]}
            self._keep(self._path(_name(number)), state)
            write_text(self.folder / INDEX, self._index(numbers))

    def _path(self, name):
        return self.folder / FOLDER / f"{name}.h5"

    @staticmethod
    def _keep(path, data):
        with hdf5(path) as file:
            for name, values in data.items():
                file[name] = values

    def _index(self, numbers):
        points, cells = self._size
        mesh = (
            f'<Topology TopologyType="Quadrilateral" NumberOfElements="{cells}">'
            f"{_item('mesh', 'cells', (cells, 4), 'Int')}</Topology>"
            f'<Geometry GeometryType="XY">{_item("mesh", "points", (points, 2))}</Geometry>'
        )
        grids = []
        for number in numbers:
            name = _name(number)
            grids.append(
                f'<Grid Name="{name}" GridType="Uniform"><Time Value="{number}"/>{mesh}'
                + _attribute(DISPLACEMENT, "Vector", "Node", _item(name, "displacement", (points, 3)))
                + _attribute(STRESS, "Vector", "Cell", _item(name, "stress", (cells, 3)))
                + _attribute(VON_MISES, "Scalar", "Cell", _item(name, "von_mises", (cells,)))
                + "</Grid>"
            )
        series = '<Grid Name="states" GridType="Collection" CollectionType="Temporal">'
        return "\n".join(['<Xdmf Version="3.0"><Domain>', series, *grids, "</Grid>", "</Domain></Xdmf>", ""])

    def _stresses(self):
        body, sigma = self.body, self.body.stress()
        return ufl.as_vector([sigma[0, 0], sigma[1, 1], sigma[0, 1], elasticity.von_mises(sigma, body.nu)])


def _name(number):
    return f"{number:06d}"


def _attribute(name, kind, centre, item):
    return f'<Attribute Name="{name}" AttributeType="{kind}" Center="{centre}">{item}</Attribute>'


def _item(file, data, shape, kind="Float"):
    size = " ".join(map(str, shape))
    place = f"{FOLDER}/{file}.h5:/{data}"
    return f'<DataItem DataType="{kind}" Precision="8" Dimensions="{size}" Format="HDF">{place}</DataItem>'
