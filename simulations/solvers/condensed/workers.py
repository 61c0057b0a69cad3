"""Sums over the ranks of what each keeps a part of, asked for by rank 0.

All ranks enter ``Workers.lead`` together. Rank 0 works through its task and decides alone what comes next; the others
wait for the sums it asks for, and leave when it has done. On one rank nothing is sent.
"""

import numpy as np
from scipy.linalg import lapack


class Workers:
    """Ranks that add up parts for rank 0."""

    def __init__(self, comm):
        self.comm = comm
        self._parts = {}

    def can(self, name: str, part):
        """What this rank adds to the sum ``name``: a function that returns an array, of one shape on all ranks."""
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
        total = np.empty(part.shape) if self.comm.rank == 0 else None
        self.comm.Reduce(np.ascontiguousarray(part, dtype=float), total)
        return total


class SharedInverse:
    """The inverse of a matrix of rank 0, of which every rank works out some columns and multiplies vectors with them.

    whole: the inverse (n, n) on rank 0, None elsewhere.
    """

    def __init__(self, workers: Workers):
        self._workers = workers
        self.whole: np.ndarray | None = None
        workers.can("columns of the inverse", self._invert)
        workers.can("inverse b", self._times)

    def invert(self, rows: np.ndarray, active: np.ndarray) -> bool:
        """Invert the matrix whose ``active`` rows (bool (n,)) are ``rows`` (g, n), the others those of the identity;
        whether that can be done.
        """
        self.whole = self._workers.sum("columns of the inverse", rows, active).T
        return not self._is_singular

    def times(self, b: np.ndarray) -> np.ndarray:
        """inverse @ b."""
        return self._workers.sum("inverse b", b)

    def _invert(self, rows, active):
        """The transposed inverse (n, n) where it is this rank's, zero elsewhere."""
        comm, n = self._workers.comm, len(active)
        first, end = (-(-n * rank // comm.size) for rank in (comm.rank, comm.rank + 1))  # rank 0 has some
        self._columns = slice(first, end)
        self._own = np.eye(n, end - first, -first, order="F")
        right = self._own[active]
        passive = ~active[self._columns]
        right[:, passive] = -rows[:, self._columns][:, passive]
        if right.shape[1]:
            *_, self._own[active], self._is_singular = lapack.dgesv(rows[:, active], right)
        if comm.size == 1:
            return self._own.T
        whole = np.zeros((n, n))
        whole[self._columns] = self._own.T
        return whole

    def _times(self, b):
        return self._own @ b[self._columns]
