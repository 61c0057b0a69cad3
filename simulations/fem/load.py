"""The pair of line loads on the indenter."""

from typing import NamedTuple


class Load(NamedTuple):
    """Line loads (dimensionless): P presses, Q shears along x."""

    P: float
    Q: float = 0.0

    @property
    def components(self) -> tuple[float, float]:
        """(Q, P): along x and along y, as the directions of forms.contact count them."""
        return self.Q, self.P

    def halfway_to(self, other: "Load") -> "Load":
        """The mean of both loads."""
        return Load((self.P + other.P) / 2, (self.Q + other.Q) / 2)


NO_LOAD = Load(0.0, 0.0)
