"""Exact reference of uncoupled loops with bulk strain in phase, where ``analytic.StretchedLoop`` holds."""

from collections.abc import Sequence

import numpy as np

from analytic import StretchedLoop

from ..loading.schedule import LoadStep
from .history import Entry


class StretchedForm:
    """Closed form [X7] at the loads of a schedule; loop: in the units of the schedule."""

    name = "closed form"
    coarser = None

    def __init__(self, loop: StretchedLoop, schedule: Sequence[LoadStep]):
        self._loop, self._schedule = loop, schedule

    def pressure(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """p, (44)."""
        return self._loop.loop.contact.pressure(x)

    def traction(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """q, [X7]; 0 before Q has moved."""
        step = entry.step
        return self._loop.traction(x, step.Q, step.branch) if step.direction else np.zeros_like(x)

    def slip(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """u_x - delta_x, the negative of the slip in [X7]."""
        step = entry.step
        return -self._loop.slip(x, step.Q, step.branch) if step.direction else np.zeros_like(x)

    def contact(self, entry: Entry) -> tuple[float, float]:
        """Edges of the contact, (43)."""
        a = self._loop.loop.a
        return -a, a

    def stick_half_width(self, entry: Entry) -> float:
        """Half-width of what has stuck since the last turn of Q."""
        step = entry.step
        return float(self._loop.zone(step.Q, step.branch)[1]) if step.direction else self._loop.loop.a

    def dissipated_energy(self) -> float:
        """Of a cycle, where there is none of the initial loading."""
        last = self._schedule[-1]
        return self._loop.dissipated_energy if last.cycle else self._loop.dissipated(last.Q, "initial")
