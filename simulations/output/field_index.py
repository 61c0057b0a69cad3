"""Indices of the states in fields/*.h5: XDMF, which everything reads, and VTKHDF, which knows every degree."""

import re
from pathlib import Path

import h5py
import numpy as np

from .files import hdf5, write_text

XDMF, VTKHDF, FOLDER, MESH = "fields.xdmf", "fields.vtkhdf", "fields", "mesh.h5"
QUADS = ("Quadrilateral", "corners", 4)
XDMF_CELLS = {1: QUADS, 2: ("Quadrilateral_9", "cells", 9), 3: QUADS}  # XDMF has no cell of degree 3
VTK_CELLS = {1: 9, 2: 28, 3: 70}  # VTK_QUAD, VTK_BIQUADRATIC_QUAD, VTK_LAGRANGE_QUADRILATERAL


def file_name(number: int) -> str:
    """Of the state of a load step, in the folder ``fields``."""
    return f"{number:06d}.h5"


def files_of(xdmf: str) -> list[str]:
    """The files that an index names, by their place in the folder of the run."""
    return sorted(set(re.findall(rf">({FOLDER}/[^:<]+):", xdmf)))


def local_nodes(degree: int) -> list[tuple[int, int]]:
    """(i, j) of the nodes of a cell, i along x and j upwards, in the order of VTK: corners, edges, inside."""
    d, between = degree, range(1, degree)
    corners = [(0, 0), (d, 0), (d, d), (0, d)]
    along_x = [[(i, j) for i in between] for j in (0, d)]
    upwards = [[(i, j) for j in between] for i in (d, 0)]
    edges = along_x[0] + upwards[0] + along_x[1] + upwards[1]
    return corners + edges + [(i, j) for j in between for i in between]


class FieldIndex:
    """Writes both indices. degree: of the displacement; points, cells: how many; names: fields that are kept."""

    def __init__(self, folder: Path, degree: int, points: int, cells: int, names: tuple[str, ...]):
        self.folder, self.degree, self.points, self.cells = folder, degree, points, cells
        self._shapes: dict[str, tuple[int, ...]] = {n: (points, 3) if n == "displacement" else (cells,) for n in names}

    def write(self, numbers: list[int], times: list[float]):
        """Both, of the states of these load steps at these load parameters."""
        write_text(self.folder / XDMF, self._xdmf(numbers, times))
        self._write_vtkhdf(numbers, times)

    def _xdmf(self, numbers, times):
        kind, data, nodes = XDMF_CELLS[self.degree]
        mesh = (
            f'<Topology TopologyType="{kind}" NumberOfElements="{self.cells}">'
            f"{_item(MESH, data, (self.cells, nodes), 'Int')}</Topology>"
            f'<Geometry GeometryType="XYZ">{_item(MESH, "points", (self.points, 3))}</Geometry>'
        )
        grids = []
        for number, time in zip(numbers, times, strict=True):
            attributes = "".join(
                f'<Attribute Name="{name}" AttributeType="{"Vector" if len(shape) > 1 else "Scalar"}" '
                f'Center="{_centre(name)}">{_item(file_name(number), name, shape)}</Attribute>'
                for name, shape in self._shapes.items()
            )
            start = f'<Grid Name="{number:06d}" GridType="Uniform"><Time Value="{time:.12g}"/>'
            grids.append(f"{start}{mesh}{attributes}</Grid>")
        series = '<Grid Name="states" GridType="Collection" CollectionType="Temporal">'
        return "\n".join(['<Xdmf Version="3.0"><Domain>', series, *grids, "</Grid>", "</Domain></Xdmf>", ""])

    def _write_vtkhdf(self, numbers, times):
        """A time series in which data stand as links to the files of the states: none is copied."""
        count, nodes, none = len(numbers), (self.degree + 1) ** 2, np.zeros(len(numbers), int)
        with hdf5(self.folder / VTKHDF) as file:
            group = file.create_group("VTKHDF")
            group.attrs["Version"] = [2, 0]
            group.attrs["Type"] = np.bytes_("UnstructuredGrid")
            group["NumberOfPoints"], group["NumberOfCells"] = [self.points], [self.cells]
            group["NumberOfConnectivityIds"] = [nodes * self.cells]
            group["Points"] = h5py.ExternalLink(f"{FOLDER}/{MESH}", "/points")
            group["Connectivity"] = h5py.ExternalLink(f"{FOLDER}/{MESH}", "/connectivity")
            group["Offsets"] = np.arange(0, nodes * self.cells + 1, nodes)
            group["Types"] = np.full(self.cells, VTK_CELLS[self.degree], np.uint8)
            steps = group.create_group("Steps")
            steps.attrs["NSteps"] = count
            steps["Values"], steps["NumberOfParts"] = times, none + 1
            steps["PartOffsets"] = steps["PointOffsets"] = none
            steps["CellOffsets"] = steps["ConnectivityIdOffsets"] = none[:, None]
            for name, shape in self._shapes.items():
                layout = h5py.VirtualLayout((count * shape[0], *shape[1:]), "f8")
                for i, number in enumerate(numbers):
                    source = h5py.VirtualSource(f"{FOLDER}/{file_name(number)}", name, shape)
                    layout[i * shape[0] : (i + 1) * shape[0]] = source
                centre = "PointData" if _centre(name) == "Node" else "CellData"
                group.require_group(centre).create_virtual_dataset(name, layout)
                steps[f"{centre}Offsets/{name}"] = shape[0] * np.arange(count)


def _centre(name):
    return "Node" if name == "displacement" else "Cell"


def _item(file, data, shape, kind="Float"):
    size = " ".join(map(str, shape))
    place = f"{FOLDER}/{file}:/{data}"
    return f'<DataItem DataType="{kind}" Precision="8" Dimensions="{size}" Format="HDF">{place}</DataItem>'
