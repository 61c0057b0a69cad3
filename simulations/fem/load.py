"""The line loads on the indenter, and the strain of the body beside it."""

from typing import NamedTuple

import numpy as np

SAME = 1e-9  # of P: loads this close are equal


class Load(NamedTuple):
    """Line loads (dimensionless): P presses, Q shears along x; and the strain of the body along x, in P/(a E(a))."""

    P: float
    Q: float = 0.0
    strain: float = 0.0

    @property
    def components(self) -> tuple[float, float]:
        """(Q, P): along x and along y, as the directions of forms.contact count them."""
        return self.Q, self.P

    def towards(self, other: "Load", share: float) -> "Load":
        """The load after this share of the straight way to another."""
        return Load(*(mine + share * (theirs - mine) for mine, theirs in zip(self, other)))

    def is_near(self, other: "Load") -> bool:
        """Whether both are equal but for round-off."""
        return np.allclose(self, other, rtol=0, atol=SAME * self.P)


NO_LOAD = Load(0.0, 0.0)
