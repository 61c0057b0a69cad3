"""The files of a run opened by pyvista and meshio, wheels on any machine:  python tests/output/other_readers.py DIR.

Needs neither FEniCSx nor this package:  pip install pyvista meshio h5py. CI calls it outside the image.
"""

import sys
from pathlib import Path

import h5py
import meshio
import numpy as np
import pyvista


def states(folder: Path) -> list[dict[str, np.ndarray]]:
    """Fields by name of every state, as they are in its file."""
    found = []
    for path in sorted((folder / "fields").glob("0*.h5")):
        with h5py.File(path) as file:
            found.append({name: file[name][...] for name in file if name != "lines"})  # a group, in lines.csv alone
    return found


def check_pyvista(path: Path, expected: list[dict[str, np.ndarray]]):
    """Every field of every state has the values of its file; stresses are in cells, the displacement at nodes."""
    reader = pyvista.get_reader(str(path))
    reader.reader.UpdateInformation()
    is_xdmf = path.suffix == ".xdmf"
    count = reader.number_time_points if is_xdmf else reader.reader.GetNumberOfSteps()
    assert count == len(expected)
    for number, fields in enumerate(expected):
        reader.set_active_time_point(number) if is_xdmf else reader.reader.SetStep(number)
        mesh = reader.read()
        while isinstance(mesh, pyvista.MultiBlock):
            mesh = mesh[0]
        for name, values in fields.items():
            found = (mesh.point_data if name == "displacement" else mesh.cell_data)[name]
            assert np.array_equal(found, values), (path.name, number, name)
        assert mesh.bounds[3] == 0.0 and mesh.bounds[2] < 0.0  # y upwards, the surface on top
    print(f"{path.name}: {count} states, {len(expected[0])} fields, {mesh.n_cells} cells by pyvista")


def check_meshio(path: Path, expected: list[dict[str, np.ndarray]]):
    """The same."""
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, _ = reader.read_points_cells()
        assert reader.num_steps == len(expected)
        for number, fields in enumerate(expected):
            _, at_points, in_cells = reader.read_data(number)
            for name, values in fields.items():
                found = at_points[name] if name == "displacement" else in_cells[name][0]
                assert np.array_equal(found, values), (number, name)
    print(f"{path.name}: {reader.num_steps} states, {len(points)} points by meshio")


if __name__ == "__main__":
    run = Path(sys.argv[1])
    wanted = states(run)
    assert wanted, f"{run} has no fields"
    for name in ("fields.vtkhdf", "fields.xdmf"):
        check_pyvista(run / name, wanted)
    check_meshio(run / "fields.xdmf", wanted)
