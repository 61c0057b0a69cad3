"""Exact references of uncoupled runs: springs under the loads of the schedule; a loop with bulk strain in phase."""

from collections.abc import Sequence

import numpy as np

from analytic import CylinderContact, ProfileContact, SpringPath, StretchedLoop

from ..loading.schedule import LoadStep
from .comparison import last_cycle
from .history import Entry


class Springs:
    """Closed forms (7), (18), (21) along the lines between the loads of a schedule; they have no load steps.

    contact: the frictionless contact under the largest load; mu: friction coefficient, 0 without friction;
    schedule: the load steps, which an entry of the history names by its number; without_middle: see ``Reference``.
    """

    name = "closed form"
    coarser = None

    def __init__(
        self,
        contact: CylinderContact | ProfileContact,
        mu: float,
        schedule: Sequence[LoadStep],
        without_middle: bool = False,
    ):
        self._schedule, self.without_middle = schedule, without_middle
        self._states = SpringPath(contact, mu or 1.0).run([(step.P, step.Q) for step in schedule])

    def pressure(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """p, (7); it may be infinite under a sharp tip."""
        return self._states[entry.number].pressure(x)

    def traction(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """q, (18); at constant P [X5]."""
        return self._states[entry.number].traction(x)

    def slip(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """u_x - delta_x, the negative of (21)."""
        return -self._states[entry.number].slip(x)

    def contact(self, entry: Entry) -> tuple[float, float]:
        """Edges of the contact, (6)."""
        half_width = self._states[entry.number].contact_half_width
        return -half_width, half_width

    def stick_half_width(self, entry: Entry) -> float:
        """Half-width of the zone where |q| < mu p; at constant P (48), [X5]."""
        return self._states[entry.number].half_width_below_limit

    def dissipated_energy(self) -> float:
        """Of the last full cycle, where there is none since first contact; [X4] for a cycle at constant P."""
        return last_cycle(self._states, self._schedule)


class StretchedForm:
    """Closed form [X7] at the loads of a schedule; loop: in the units of the schedule."""

    name = "closed form"
    coarser, without_middle = None, False

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
