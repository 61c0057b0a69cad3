"""Loads and unknowns of the last two load steps. Where the load goes on, the next starts on the line through them."""

import numpy as np

from ..fem.load import SAME, Load

FURTHEST = 3.0  # that a load may be ahead


class LastSteps:
    """What the last two load steps ended with, fewer at first."""

    def __init__(self):
        self._kept: list[tuple] = []  # load and vector of unknowns

    def keep(self, load: Load, x):
        """A load step has ended with the unknowns ``x``."""
        self._kept = [*self._kept[-1:], (load, x.copy())]

    def ahead(self, load: Load) -> float:
        """How far ``load`` lies beyond the last step, over the way of that; 0 where it is not on the line of both."""
        if len(self._kept) < 2:
            return 0.0
        before, last = (np.array(kept) for kept, _ in self._kept)
        done, ahead = last - before, np.array(load) - last
        share = done @ ahead / (done @ done) if np.any(done) else 0.0
        return share if 0 < share <= FURTHEST and np.allclose(ahead, share * done, rtol=0, atol=SAME * load.P) else 0.0

    def stays(self, load: Load) -> bool:
        """Whether ``load`` is that of the last step."""
        return bool(self._kept) and load.is_near(self._kept[-1][0])

    def turned(self, load: Load) -> bool:
        """Whether ``load`` is known to lie another way than the last step went."""
        return len(self._kept) == 2 and not self.ahead(load)

    def extrapolate(self, load: Load, x):
        """Fill the unknowns ``x`` for a load that is ahead."""
        (_, first), (_, second) = self._kept
        share = self.ahead(load)
        x.set(0.0)
        x.axpy(1.0 + share, second)
        x.axpy(-share, first)

    def save(self) -> dict[str, np.ndarray]:
        """As arrays by name; for unknowns that rank 0 has alone, and of that rank."""
        loads, unknowns = [kept for kept, _ in self._kept], [x.array_r.copy() for _, x in self._kept]
        return {"last loads": np.reshape(loads, (-1, 3)), "last unknowns": np.array(unknowns)}

    def restore(self, saved: dict[str, np.ndarray], x):
        """Go on from what ``save`` has returned, if it is among ``saved``; x: a vector of the unknowns."""
        self._kept = []
        for load, unknowns in zip(saved.get("last loads", ()), saved.get("last unknowns", ()), strict=True):
            vector = x.duplicate()
            vector.array[:] = unknowns[: vector.getLocalSize()]
            self._kept.append((Load(*load), vector))
