"""The response R of the strip to contact forces, kept as one dense block for each part that the body falls into; a rank
keeps those of its own parts, and R is the sum over the ranks.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix


@dataclass(frozen=True)
class Response:
    """This rank's share of R (r, c).

    It is the sum of  rows @ dense @ columns.T  over ``blocks``, rows (r, h) and columns (c, w) sparse, dense (h, w).
    """

    shape: tuple[int, int]
    blocks: tuple[tuple[csr_matrix, np.ndarray, csr_matrix], ...]

    def chosen(self, columns: slice) -> "Response":
        """Some of the columns."""
        blocks = []
        for rows, dense, place in self.blocks:
            place = place[columns]
            used = np.unique(place.indices)
            blocks.append((rows, np.ascontiguousarray(dense[:, used]), place[:, used]))
        size = len(range(*columns.indices(self.shape[1])))
        return Response((self.shape[0], size), tuple(blocks))

    @cached_property
    def _gathering(self):
        return [place.T.tocsr() for _, _, place in self.blocks]

    def apply(self, forces: np.ndarray) -> np.ndarray:
        """The share of R @ forces, (r,) from (c,)."""
        displacement = np.zeros(self.shape[0])
        for (rows, dense, _), gather in zip(self.blocks, self._gathering):
            displacement += rows @ (dense @ (gather @ forces))
        return displacement

    def times(self, left: csr_matrix) -> np.ndarray:
        """The share of left @ R, (g, c) from a sparse (g, r)."""
        product = np.zeros((left.shape[0], self.shape[1]))
        for rows, dense, place in self.blocks:
            product += (place @ ((left @ rows) @ dense).T).T
        return product
