"""Compliance matrix C of the strip, kept as one block for each symmetric part of the body."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu


@dataclass(frozen=True)
class StripInside:
    """Stiffness of the strip's inside (m, m), and the border (m, b) that couples it to its interface.

    definite: whether the stiffness is; else, with the mean stress, a sparse solve loses four digits.
    """

    stiffness: csc_matrix
    border: csr_matrix
    definite: bool

    @cached_property
    def factor(self):
        """Sparse factor of the stiffness."""
        return splu(self.stiffness)

    def __getstate__(self):  # a factor cannot be sent to another rank
        return {"stiffness": self.stiffness, "border": self.border, "definite": self.definite}

    def solve(self, forces: np.ndarray, interface: np.ndarray) -> np.ndarray:
        """Displacements (m, ...) inside under forces (m, ...) there, those of the interface (b, ...) known."""
        return self.factor.solve(forces - self.border @ interface)


@dataclass(frozen=True)
class Block:
    """Share of a part in C: displacements ``rows @ dense @ columns.T``, rows (r, h) and columns (c, w) sparse.

    dense: (h, w), those inside the strip first, then those of its interface; loads: (m, w) sparse, forces inside. From
    these and the displacements of the interface, a third of all, those inside follow.
    """

    rows: csr_matrix
    dense: np.ndarray
    columns: csr_matrix
    loads: csr_matrix
    inside: StripInside

    @cached_property
    def _gathering(self):
        return self.columns.T.tocsr()

    def chosen(self, columns: slice) -> "Block":
        """Some of the columns of C."""
        place = self.columns[columns]
        used = np.unique(place.indices)
        dense = np.ascontiguousarray(self.dense[:, used])
        return replace(self, dense=dense, columns=place[:, used], loads=self.loads[:, used])

    def apply(self, forces: np.ndarray) -> np.ndarray:
        """Displacements (r,) under forces (c,)."""
        own = self._gathering @ forces
        if not self.inside.definite:
            return self.rows @ (self.dense @ own)
        interface = self.dense[self.loads.shape[0] :] @ own
        inside = self.inside.solve(self.loads @ own, interface)
        return self.rows @ np.concatenate([inside, interface])


@dataclass(frozen=True)
class ComplianceMatrix:
    """C (r, c): displacements of the strip from nodal contact forces, the sum of its blocks."""

    shape: tuple[int, int]
    blocks: tuple[Block, ...]

    def chosen(self, columns: slice) -> "ComplianceMatrix":
        """Some of the columns."""
        size = len(range(*columns.indices(self.shape[1])))
        return ComplianceMatrix((self.shape[0], size), tuple(block.chosen(columns) for block in self.blocks))

    def apply(self, forces: np.ndarray) -> np.ndarray:
        """C @ forces, (r,) from (c,)."""
        return sum((block.apply(forces) for block in self.blocks), np.zeros(self.shape[0]))

    def times(self, left: csr_matrix) -> np.ndarray:
        """left @ C, (g, c) from a sparse (g, r)."""
        product = np.zeros((left.shape[0], self.shape[1]))
        for block in self.blocks:
            product += (block.columns @ ((left @ block.rows) @ block.dense).T).T
        return product
