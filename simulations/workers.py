"""Work of rank 0 alone: what comes of it on every rank, and sums over the ranks of what each keeps a part of.

All ranks enter ``Workers.lead`` together. Rank 0 works through its task and decides alone what comes next; the others
wait for the sums it asks for, and leave when it has done. On one rank nothing is sent.
"""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

T = TypeVar("T")


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


class Workers:
    """Ranks that add up parts for rank 0."""

    def __init__(self, comm):
        self.comm = comm
        self._parts = {}

    def can(self, name: str, part):
        """What this rank adds to the sum ``name``: a function that returns an array, of one shape on all ranks, or
        None where there is nothing to add up.
        """
        self._parts[name] = part

    def lead(self, task):
        """``task()`` on rank 0, which may ask for sums meanwhile; its result there, None elsewhere. Collective."""
        if self.comm.rank:
            while (call := self.comm.bcast(None)) is not None:
                self._add(*call)
            return None
        try:
            return task()
        finally:
            if self.comm.size > 1:
                self.comm.bcast(None)

    def sum(self, name: str, *arguments):
        """The sum of what all ranks return for these arguments. On rank 0, within ``lead``."""
        if self.comm.size == 1:
            return self._parts[name](*arguments)
        self.comm.bcast((name, arguments))
        return self._add(name, arguments)

    def _add(self, name, arguments):
        part = self._parts[name](*arguments)
        if part is None:
            return None
        total = np.empty(part.shape) if self.comm.rank == 0 else None
        self.comm.Reduce(np.ascontiguousarray(part, dtype=float), total)
        return total


class SharedMatrix:
    """A square matrix of rank 0 of which every rank keeps some columns, to multiply vectors with them.

    whole: the matrix (n, n) on rank 0, None elsewhere.
    """

    def __init__(self, workers: Workers, name: str):
        self._workers, self._name = workers, name
        self.whole: np.ndarray | None = None
        workers.can(f"share {name}", self._share)
        workers.can(f"{name} b", self._times)

    def keep(self, matrix: np.ndarray):
        """Replace it by ``matrix`` (n, n), in column order."""
        self.whole = matrix
        self._workers.sum(f"share {self._name}", matrix)

    def times(self, b: np.ndarray) -> np.ndarray:
        """matrix @ b."""
        return self._workers.sum(f"{self._name} b", b)

    def _share(self, matrix):
        comm, n = self._workers.comm, len(matrix)
        self._columns = slice(n * comm.rank // comm.size, n * (comm.rank + 1) // comm.size)
        own = matrix[:, self._columns]
        self._own = own if comm.rank == 0 else own.copy(order="F")

    def _times(self, b):
        return self._own @ b[self._columns]
