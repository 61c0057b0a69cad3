"""Runs shared out over ranks: run under mpirun by test_engine."""

import time

from mpi4py import MPI

from simulations.studies.engine import Item, run_all, workers

comm = MPI.COMM_WORLD


def who(values):
    """The rank that works."""
    time.sleep(0.02)
    return {"n": values["n"], "rank": comm.rank}


if __name__ == "__main__":
    with workers(comm) as executor:
        if comm.rank == 0:
            rows = run_all([Item(str(n), {"n": n}) for n in range(24)], who, executor=executor)
            assert [row["n"] for row in rows] == list(range(24))
            print(len(rows), "rows by", len({row["rank"] for row in rows}), "ranks")
