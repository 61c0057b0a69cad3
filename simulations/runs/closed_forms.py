"""Exact references of uncoupled runs: springs under the loads of the schedule; a loop with bulk strain in phase."""

from collections.abc import Sequence

import numpy as np

from analytic import CylinderContact, ProfileContact, SpringPath, StretchedLoop

from ..loading.schedule import LoadStep
from .comparison import MIDDLE, last_cycle
from .history import Entry
from .limits import BLUNTED


class Springs:
    """Closed forms (7), (18), (21) along the lines between the loads of a schedule; they have no load steps.

    contact: the frictionless contact under the largest load; mu: friction coefficient, 0 without friction;
    schedule: the load steps, which an entry of the history names by its number.
    """

    name = "closed form"
    coarser, without_middle = None, False

    def __init__(self, contact: CylinderContact | ProfileContact, mu: float, schedule: Sequence[LoadStep]):
        self._schedule = schedule
        self._is_sharp = isinstance(contact, ProfileContact) and contact.profile.order < 2
        self._states = SpringPath(contact, mu or 1.0).run([(step.P, step.Q) for step in schedule])

    def pressure(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """p, (7)."""
        state = self._states[entry.number]
        return self._with_finite_tip(entry, x, state.pressure, state.pressure_within)

    def traction(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """q, (18); at constant P [X5]."""
        state = self._states[entry.number]
        return self._with_finite_tip(entry, x, state.traction, state.traction_within)

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

    def _with_finite_tip(self, entry, x, value, within):
        """``value`` at x. Under a sharp tip it may be infinite, or much above that of any node of the mesh: there the
        mean over the length of surface of the node.
        """
        nodes = entry.surface
        middle = np.abs(nodes.x).argmin()
        at_tip = np.abs(x) <= MIDDLE * nodes.weight[middle]
        if not self._is_sharp or not at_tip.any():
            return value(x)
        mean = within(nodes.weight[middle] / 2) / nodes.weight[middle]
        with np.errstate(invalid="ignore"):  # 0 times an infinite pressure: the mean
            exact = float(value(0.0))
        if abs(mean - exact) <= BLUNTED * abs(exact) < np.inf:
            mean = exact
        return np.where(at_tip, mean, value(np.where(at_tip, nodes.weight[middle], x)))


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
