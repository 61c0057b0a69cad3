"""Scenes that solve in a fraction of a second, and commands run as a user runs them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

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
    return os.environ | MPI_ENVIRONMENT | {"PYTHONPATH": str(ROOT)}


def run_command(
    *arguments, ranks: int = 1, cwd=ROOT, timeout=600, module="simulations.fretting"
) -> subprocess.CompletedProcess:
    """``python -m module`` with ``arguments`` on ``ranks``, its output as text."""
    command = [sys.executable, "-m", module, *map(str, arguments)]
    if ranks > 1:
        command = [shutil.which("mpirun"), "-n", str(ranks), *command]
    return subprocess.run(
        command, cwd=cwd, env=environment(), timeout=timeout, text=True, capture_output=True, stdin=subprocess.DEVNULL
    )


def coarse_arguments(folder, **changes) -> list[str]:
    """Command line of a coarse run into ``folder``."""
    sets = [word for override in coarse_overrides(**changes) for word in ("--set", override)]
    return [*sets, "--output", str(folder)]


def fill_disk(monkeypatch, call: int):
    """From the write of this number on nothing more goes to the disk."""
    calls, fsync = [], os.fsync

    def full(descriptor):
        calls.append(descriptor)
        if len(calls) >= call:
            raise OSError(28, "No space left on device")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
