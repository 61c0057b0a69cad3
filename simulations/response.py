"""The response R of the strip to contact forces, kept as one dense block for each part that the body falls into."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix


@dataclass(frozen=True)
class Response:
    """R = sum of  rows @ dense @ columns.T  over ``blocks``, rows (r, h) and columns (c, w) sparse, dense (h, w)."""

    blocks: tuple[tuple[csr_matrix, np.ndarray, csr_matrix], ...]

    @property
    def columns(self) -> int:
        """c."""
        return self.blocks[0][2].shape[0]

    def chosen(self, columns: slice) -> "Response":
        """Some of the columns."""
        blocks = []
        for rows, dense, place in self.blocks:
            place = place[columns]
            used = np.unique(place.indices)
            blocks.append((rows, np.ascontiguousarray(dense[:, used]), place[:, used]))
        return Response(tuple(blocks))

    @cached_property
    def _gathering(self):
        return [place.T.tocsr() for _, _, place in self.blocks]

    def apply(self, forces: np.ndarray) -> np.ndarray:
        """R @ forces, (r,) from (c,)."""
        blocks = zip(self.blocks, self._gathering)
        return sum(rows @ (dense @ (gather @ forces)) for (rows, dense, _), gather in blocks)

    def times(self, left: csr_matrix) -> np.ndarray:
        """left @ R, (g, c) from a sparse (g, r)."""
        return sum((place @ ((left @ rows) @ dense).T).T for rows, dense, place in self.blocks)
