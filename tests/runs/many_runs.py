"""Memory of one process after many runs, MB: test_many_runs runs it with their number, also on ranks."""

import sys
from pathlib import Path

from mpi4py import MPI

from simulations import run
from tests.running import COARSE

FIRST = 5


def resident() -> float:
    """Memory that this process has, MB."""
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * 4096 / 1e6


if __name__ == "__main__":
    comm, runs = MPI.COMM_WORLD, int(sys.argv[1])
    for number in range(1, runs + 1):
        run(COARSE | {"load.cycles": 0, "solver.increments": 1}, comm=comm)
        if number in (FIRST, runs):
            largest = comm.allreduce(resident(), MPI.MAX)
            if comm.rank == 0:
                print(f"{largest:.1f}", flush=True)
