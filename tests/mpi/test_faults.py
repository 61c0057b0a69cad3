"""Faults of folders and disks on three ranks: every rank is told, none waits, and the run goes on after it.

One rank alone: tests/output/test_restart.py and test_folder.py.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc
from running import COARSE, coarse_arguments, contents, fill_disk

from simulations import fretting
from simulations.fem.mesh import create_mesh
from simulations.fem.parallel import on_root
from simulations.loading.stepping import SolveError
from simulations.output import lock
from simulations.output.files import OutputError
from simulations.runs.simulation import Simulation
from simulations.scene import SceneError, make_scene
from simulations.solvers.bulk_solver import FactorisationError

comm = MPI.COMM_WORLD
pytestmark = pytest.mark.skipif(comm.size < 3, reason="of three ranks")
RUN = {"solid__nu": 0.3, "effects__coupling": "false", "load__cycles": 0, "reference__kind": '"none"'}


@pytest.fixture
def folder(tmp_path):
    """Of a run that all ranks do."""
    return Path(comm.bcast(str(tmp_path))) / "run"


def run(folder):
    fretting.main([*coarse_arguments(folder, **RUN), "--quiet"])


def goes_on(folder):
    """All ranks end the run that was stopped."""
    fretting.main(["--resume", str(folder), "--quiet"])
    assert json.loads((folder / "summary.json").read_text())["converged"] is True


def refused(words, *arguments):
    """On every rank, and nothing in the folders changes."""
    with pytest.raises(SceneError, match=words) as error:
        fretting.main([*map(str, arguments), "--quiet"])
    assert "\n" not in str(error.value)


def stop(folder, monkeypatch, call=12):
    """Let the disk be full from some write on."""
    with monkeypatch.context() as patch:
        fill_disk(patch, call)
        with pytest.raises(OutputError, match="No space left on device; go on with .*--resume"):
            run(folder)
    comm.Barrier()


def test_gmsh(monkeypatch):
    """What it refuses on rank 0."""

    def refuse(*_):
        raise RuntimeError("no mesh")

    monkeypatch.setattr("gmsh.model.mesh.generate", refuse)
    with pytest.raises(RuntimeError, match="no mesh"):
        create_mesh(comm, np.array([0.0, 1.0]), np.array([0.0, 1.0]))


@pytest.mark.parametrize("rank", [0, 1])
def test_a_factorisation_on_one_rank(rank, monkeypatch):
    """Each of two ranks has half of the body, the third one nothing."""

    def refuse(*_):
        raise FactorisationError("no memory")

    if comm.rank == rank:
        monkeypatch.setattr("simulations.solvers.condensed.surface_compliance.PartialFactor", refuse)
    with pytest.raises(SolveError, match="load step 1 of .*: no memory"):
        Simulation(comm, make_scene(COARSE)).run_to_end()


@pytest.mark.parametrize("error", [MemoryError, np.linalg.LinAlgError, PETSc.Error])
def test_an_error_of_one_rank_alone_is_raised_on_all(error, monkeypatch):
    def refuse(*_):
        raise error(77)

    if comm.rank == 1:
        monkeypatch.setattr("simulations.solvers.condensed.surface_compliance.PartialFactor", refuse)
    with pytest.raises(error, match="77"):
        Simulation(comm, make_scene(COARSE)).run_to_end()


@pytest.mark.parametrize("call", [3, 16], ids=["mesh", "picture"])
def test_full_disk(call, folder, monkeypatch):
    stop(folder, monkeypatch, call)
    assert not list(folder.rglob("part.*"))
    goes_on(folder)


def test_a_folder_that_disappears(folder, monkeypatch):
    moved = folder.with_name("moved")

    def vanish(progress, entry):
        if comm.rank == 0 and folder.exists():
            folder.rename(moved)

    with monkeypatch.context() as patch:
        patch.setattr("simulations.command.progress.Progress.step", vanish)
        with pytest.raises(OutputError, match="the folder is gone"):
            run(folder)
    on_root(comm, lambda: (moved / lock.NAME).unlink(missing_ok=True))
    goes_on(moved)


def test_a_folder_of_another_process(folder):
    locks = []
    on_root(comm, lambda: folder.mkdir() or locks.append(lock.Lock(folder)))
    refused("is locked", *coarse_arguments(folder, **RUN))
    on_root(comm, lambda: locks.pop().release())
    run(folder)


def test_a_checkpoint_of_another_version_or_cut_short(folder, monkeypatch):
    stop(folder, monkeypatch)
    with monkeypatch.context() as patch:
        patch.setattr("simulations.output.checkpoint.__version__", "9.9.9")
        refused("made it, and this is 9.9.9", "--resume", folder)
    memory = folder / "checkpoint" / "memory.npz"
    on_root(comm, lambda: memory.write_bytes(memory.read_bytes()[:-100]))
    before = on_root(comm, lambda: contents(folder))  # other ranks may see the lock of rank 0
    refused("checkpoint cannot be read", "--resume", folder)
    assert on_root(comm, lambda: contents(folder)) == before
