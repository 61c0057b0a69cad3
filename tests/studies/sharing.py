"""Runs shared out over ranks: run under mpirun by test_engine."""

import time

from mpi4py import MPI

from simulations.studies.engine import Item, run_on

comm = MPI.COMM_WORLD
meeting = comm.Dup()  # apart from the messages of the executor
met = []  # whether every rank has got a run


def who(values):
    """The rank that works; no rank ends its first run before every rank has got one, however late it starts."""
    if not met:
        met.append(meeting.Ibarrier())
    while not met[0].Test():
        time.sleep(0.01)
    return {"n": values["n"], "rank": comm.rank}


if __name__ == "__main__":
    rows = run_on(comm, [Item(str(n), {"n": n}) for n in range(24)], who)
    if comm.rank == 0:
        assert [row["n"] for row in rows] == list(range(24))
        print(len(rows), "rows by", len({row["rank"] for row in rows}), "ranks")
