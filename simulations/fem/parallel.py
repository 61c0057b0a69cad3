"""Collective operations: rows of all ranks on every rank; a task of rank 0, its result or failure on every rank."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from mpi4py import MPI

T = TypeVar("T")


def gathered(comm: MPI.Comm, local) -> np.ndarray:
    """Rows of all ranks, one rank after the other, on every rank."""
    return np.concatenate(comm.allgather(np.ascontiguousarray(local)))


def on_root(comm, work: Callable[[], T], expected=Exception) -> T:
    """Result of ``work`` done by rank 0, or the ``expected`` exceptions of it raised on every rank. Collective."""
    result = failure = None
    if comm.rank == 0:
        try:
            result = work()
        except expected as problem:
            failure = problem
    result, failure = comm.bcast((result, failure))
    if failure is not None:
        raise failure
    return result  # type: ignore[return-value]
