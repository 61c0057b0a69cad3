"""Fields of a run at its recorded states, read from its folder: arrays for pictures, functions for dolfinx."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import basix
import basix.ufl
import dolfinx
import h5py
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from ..fem.numbering import nearest
from ..scene import SceneError
from ..scene.output import NORMAL
from .field_index import FOLDER, MESH
from .files import reading


@dataclass(frozen=True)
class BodyState:
    """One recorded state, SI units. x (m,), y (n,): cell centres, y the depth; von_mises (n, m) [Pa]."""

    label: str
    x: np.ndarray
    y: np.ndarray
    von_mises: np.ndarray


def read_states(folder: Path) -> list[BodyState]:
    """The states in ``folder``, with their names, on both halves of the body; SceneError where it holds no run or none
    of its von Mises stress.
    """
    files = _files(folder)
    with reading(folder / FOLDER / MESH) as path, h5py.File(path) as mesh:
        is_half = mesh["x"][0] == 0
        x, y = ((mesh[name][1:] + mesh[name][:-1]) / 2 for name in ("x", "depth"))
    states = []
    for path in files.values():
        with reading(path), h5py.File(path) as file:
            if "von_mises" not in file:
                raise SceneError(f"{folder} holds no von Mises stress: output.fields left it out")
            name = file.attrs["state"] or f"increment {file.attrs['load_step']}"
            label = "pressed" if name == NORMAL else f"{name}, {file.attrs['branch']}"
            stress = file["von_mises"][...].reshape(len(y), len(x))
        states.append(_mirrored(label, x, y, stress) if is_half else BodyState(label, x, y, stress))
    return states


def _mirrored(label, x, y, stress):
    """The whole body from its half x > 0."""
    return BodyState(label, np.concatenate([-x[::-1], x]), y, np.hstack([stress[:, ::-1], stress]))


def body_functions(
    folder: Path | str, state: str | int = "A", comm: MPI.Comm = MPI.COMM_SELF
) -> dict[str, fem.Function]:
    """Fields of a recorded state as dolfinx functions by name, on one mesh in physical coordinates: x along +Q and y
    upwards [m], the surface at y = 0.

    state: "normal", "A" ... (the last of that name), or the ``increment`` that history.csv names. ``displacement`` [m]
    has the degree of the run and is exact at the nodes; the others are constant in each cell. Every rank of ``comm``
    calls it. Raises SceneError where the folder has no such state.
    """
    path = _file_of(Path(folder), state)
    with h5py.File(path.with_name(MESH)) as file, h5py.File(path) as values:
        degree = int(file.attrs["degree"])
        mesh = _mesh(comm, file)
        cell = mesh.basix_cell()
        nodes = basix.ufl.element("Lagrange", cell, degree, basix.LagrangeVariant.equispaced, shape=(2,))
        space, constants = fem.functionspace(mesh, nodes), fem.functionspace(mesh, ("DG", 0))
        found = {}
        for name in values:
            if not isinstance(values[name], h5py.Dataset):
                continue  # a group: what belongs to lines
            function = fem.Function(space if name == "displacement" else constants, name=name)
            if name == "displacement":
                points = file["points"][...]
                x, y = (np.unique(points[:, i]) for i in (0, 1))
                at = space.tabulate_dof_coordinates()
                place = nearest(-y[::-1], -at[:, 1]) * len(x) + nearest(x, at[:, 0])
                function.x.array[:] = values[name][...][place, :2].ravel()
            else:
                function.x.array[:] = values[name][...][mesh.topology.original_cell_index]
            found[name] = function
    return found


def _mesh(comm, file):
    """The mesh of straight cells, distributed: rank 0 gives all of it."""
    corners, points = file["corners"][...], file["points"][:, :2]
    used, cells = np.unique(corners, return_inverse=True)
    cells = cells.reshape(corners.shape)[:, [0, 1, 3, 2]].astype(np.int64)  # dolfinx counts by rows
    share = slice(None) if comm.rank == 0 else slice(0, 0)
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    return dolfinx.mesh.create_mesh(comm, cells[share], points[used][share], ufl.Mesh(element))


def _files(folder: Path) -> dict[int, Path]:
    """The files of the states by load step."""
    found = {int(p.stem): p for p in (folder / FOLDER).glob("*.h5") if re.fullmatch(r"\d{6,}", p.stem)}
    if not found or not (folder / FOLDER / MESH).is_file():
        raise SceneError(f"{folder} holds no results of a run: {FOLDER}/ with states is needed")
    return dict(sorted(found.items()))


def _file_of(folder: Path, state: str | int) -> Path:
    files, names = _files(folder), {}
    state = int(state) if isinstance(state, np.integer) else state
    for number, path in files.items():
        with reading(path), h5py.File(path) as file:
            names[file.attrs["state"] or str(number)] = path
    if isinstance(state, int) and state in files:
        return files[state]
    if state not in names:
        kind = "increment" if isinstance(state, int) else "state"
        there = ", ".join(map(str, files)) if isinstance(state, int) else ", ".join(map(repr, names))
        raise SceneError(f"{folder} has no fields of {kind} {state!r}: there are {there}")
    return names[state]
