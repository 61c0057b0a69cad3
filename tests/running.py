"""Scenes that solve in a fraction of a second, and commands run as a user runs them."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

from simulations.studies.costs.cases import SWEPT

COARSE = SWEPT  # keys of a coarse mesh
ROOT = Path(__file__).resolve().parent.parent
MPI_ENVIRONMENT = {  # more ranks than cores, as root, sharing them: what the image sets, for other places
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMP_NUM_THREADS": "1",
    "MPLBACKEND": "Agg",
}


def coarse_overrides(**changes) -> tuple[str, ...]:
    """``key=value`` overrides of a coarse scene; ``solver__method="full"`` changes solver.method."""
    keys = COARSE | {name.replace("__", "."): value for name, value in changes.items()}
    return tuple(f"{key}={value}" for key, value in keys.items())


def environment() -> dict[str, str]:
    """Environment of a command started by a test."""
    return os.environ | MPI_ENVIRONMENT | {"PYTHONPATH": str(ROOT), "GRADED_FRETTING_RUN": ""}


def python(*words, ranks: int = 1) -> list[str]:
    """A command line of Python, -m MODULE, -c CODE or a file with arguments, on ``ranks``."""
    command = [sys.executable, *map(str, words)]
    return command if ranks == 1 else [shutil.which("mpirun"), "-n", str(ranks), *command]


def run_python(*words, ranks: int = 1, cwd=ROOT, timeout=600) -> subprocess.CompletedProcess:
    """``python(*words)`` run to its end, its output as text."""
    how = {"cwd": cwd, "env": environment(), "timeout": timeout, "text": True, "capture_output": True}
    return subprocess.run(python(*words, ranks=ranks), stdin=subprocess.DEVNULL, **how)


def run_command(*arguments, module="simulations.fretting", **how) -> subprocess.CompletedProcess:
    """``python -m module`` with ``arguments``; how: ranks, cwd, timeout."""
    return run_python("-m", module, *arguments, **how)


def start_python(*words, ranks: int = 1, **streams) -> subprocess.Popen:
    """``python(*words)`` begun; streams: stdout, stderr, text."""
    return subprocess.Popen(
        python(*words, ranks=ranks), cwd=ROOT, env=environment(), stdin=subprocess.DEVNULL, **streams
    )


def ranks_of(pid: int) -> list[int]:
    """Processes of the ranks under an mpirun."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return sorted(int(c) for c in children if b"simulations." in Path(f"/proc/{c}/cmdline").read_bytes())


def coarse_arguments(folder, **changes) -> list[str]:
    """Command line of a coarse run into ``folder``."""
    sets = [word for override in coarse_overrides(**changes) for word in ("--set", override)]
    return [*sets, "--output", str(folder)]


def contents(folder: Path) -> dict[Path, bytes]:
    """Every file in it."""
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def csv_rows(path) -> list[dict[str, str]]:
    """Rows of a table by column."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def surface(folder: Path) -> dict[str, np.ndarray]:
    """What surface.h5 of a run has, by name."""
    with h5py.File(folder / "surface.h5") as file:
        return {name: file[name][...] for name in file}


def fill_disk(monkeypatch, call: int):
    """From the write of this number on nothing more goes to the disk."""
    calls, fsync = [], os.fsync

    def full(descriptor):
        calls.append(descriptor)
        if len(calls) >= call:
            raise OSError(28, "No space left on device")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
