"""Compliance matrix C of the strip, kept as one dense block for each symmetric part of the body."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix


@dataclass(frozen=True)
class ComplianceMatrix:
    """C (r, c): displacements of the strip from nodal contact forces.

    It is the sum of  rows @ dense @ columns.T  over ``blocks``, rows (r, h) and columns (c, w) sparse, dense (h, w).
    """

    shape: tuple[int, int]
    blocks: tuple[tuple[csr_matrix, np.ndarray, csr_matrix], ...]

    def chosen(self, columns: slice) -> "ComplianceMatrix":
        """Some of the columns."""
        blocks = []
        for rows, dense, place in self.blocks:
            place = place[columns]
            used = np.unique(place.indices)
            blocks.append((rows, np.ascontiguousarray(dense[:, used]), place[:, used]))
        size = len(range(*columns.indices(self.shape[1])))
        return ComplianceMatrix((self.shape[0], size), tuple(blocks))

    @cached_property
    def _gathering(self):
        return [place.T.tocsr() for _, _, place in self.blocks]

    def apply(self, forces: np.ndarray) -> np.ndarray:
        """C @ forces, (r,) from (c,)."""
        displacement = np.zeros(self.shape[0])
        for (rows, dense, _), gather in zip(self.blocks, self._gathering):
            displacement += rows @ (dense @ (gather @ forces))
        return displacement

    def times(self, left: csr_matrix) -> np.ndarray:
        """left @ C, (g, c) from a sparse (g, r)."""
        product = np.zeros((left.shape[0], self.shape[1]))
        for rows, dense, place in self.blocks:
            product += (place @ ((left @ rows) @ dense).T).T
        return product
