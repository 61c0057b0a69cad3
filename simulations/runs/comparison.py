"""A run beside a reference: relative errors where it has the same physics, differences otherwise."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ..fem.surface import BAND, longest_zone
from ..loading.schedule import LoadStep
from .history import Entry, History, all_states

ROUND_OFF = 1e-9  # of the largest pressure: smaller tractions are none
MIDDLE = 1e-9  # distance from x = 0 over that of nodes: of the one in the middle
QUANTITIES = ("pressure_l2", "traction_l2", "slip_l2", "a", "c", "dissipated_energy")  # that ``compare`` may find


class NoReference(RuntimeError):
    """There is no solution to compare with; the message says why."""


class Reference(Protocol):
    """Fields at x (n,), half-widths and the energy of the last cycle (all cycles, where none is full).

    without_middle: True where a peak at x = 0 is too narrow for the mesh: its node is not compared.
    """

    name: str
    without_middle: bool

    @property
    def coarser(self) -> "Reference | None":
        """The same less finely resolved: the difference is about its error. None where it is exact."""

    def pressure(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """Contact pressure."""

    def traction(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """Traction on the half-plane."""

    def slip(self, entry: Entry, x: np.ndarray) -> np.ndarray:
        """u_x - delta_x since tangential loading began."""

    def contact(self, entry: Entry) -> tuple[float, float]:
        """Edges of the contact."""

    def stick_half_width(self, entry: Entry) -> float:
        """Half-width of the zone that sticks."""

    def dissipated_energy(self) -> float | None:
        """As ``History.dissipated_energy``; None where unknown."""


class OfStates:
    """Reference made of the states of a half-plane solver, or of another run, dimensionless like the history.

    states: with p, q and slip at any x; energy: as ``History.dissipated_energy``, None where unknown; without_middle:
    see ``Reference``.
    """

    name = "another run"
    coarser: Reference | None = None

    def __init__(self, states: Sequence, energy: float | None, without_middle: bool = False):
        self.states, self._energy, self.without_middle = states, energy, without_middle

    def pressure(self, entry: Entry, x):
        """p."""
        return self.states[entry.number].pressure_at(x)

    def traction(self, entry: Entry, x):
        """q."""
        return self.states[entry.number].traction_at(x)

    def slip(self, entry: Entry, x):
        """u_x - delta_x since the end of the normal stage."""
        return self.states[entry.number].slip_at(x)

    def contact(self, entry: Entry) -> tuple[float, float]:
        """Edges of the contact."""
        return self.states[entry.number].contact

    def stick_half_width(self, entry: Entry) -> float:
        """Half the length of the longest stick zone, with narrow bands of slip within as in a run's; nan without."""
        state = self.states[entry.number]
        if not len(state.stick_zones):
            return np.nan
        left, right = state.stick_zones.T
        first, last = longest_zone(left, right, BAND * (state.contact[1] - state.contact[0]))
        return float(right[last] - left[first]) / 2

    def dissipated_energy(self) -> float | None:
        """Of the last full cycle, where there is none since first contact."""
        return self._energy


def last_cycle(states: Sequence, schedule: Sequence[LoadStep]) -> float:
    """Energy dissipated in the last full cycle of ``schedule``, where there is none since first contact."""
    before = before_last_cycle(states, schedule)
    return states[-1].dissipated_energy - (before.dissipated_energy if before else 0.0)


def before_last_cycle(states: Sequence, schedule: Sequence[LoadStep]):
    """The state with which the last full cycle of ``schedule`` begins; None where there is none."""
    return next((state for state, step in zip(states[::-1], schedule[::-1]) if step.cycle < schedule[-1].cycle), None)


def relative_l2(weight, computed, exact) -> float:
    """sqrt(∫ (computed - exact)² dx / ∫ exact² dx) with nodal ``weight``; nan where exact vanishes."""
    norm = weight @ exact**2
    return float(np.sqrt(weight @ (computed - exact) ** 2 / norm)) if norm > 0 else float("nan")


def compare_state(entry: Entry, reference: Reference) -> dict[str, float]:
    """Relative L2 deviations of one state's pressure, traction and slip, the last over the contact.

    What is known of the reference's own error is added.
    """
    return _compared(entry, reference)[0]


def apart(entry: Entry, other: Reference, reference: Reference) -> dict[str, float]:
    """The same of another reference in the place of the run."""
    return _deviations(entry, reference, _fields(entry, other))[0]


def _fields(entry, other: Reference) -> Callable[[str, np.ndarray], np.ndarray]:
    """Fields of another reference in the entry's state, by name and x."""
    return lambda name, x: getattr(other, name)(entry, x)


def _compared(entry, reference) -> tuple[dict[str, float], dict[str, float]]:
    """``compare_state``, and what of it is the reference's own, {} of an exact one."""
    others: list[Callable] = [lambda name, x: getattr(entry, f"{name}_at")(x)]
    if reference.coarser:
        others.append(_fields(entry, reference.coarser))
    deviation, *coarser = _deviations(entry, reference, *others)
    own = coarser[0] if coarser else {}
    return {name: value + own.get(name, 0.0) for name, value in deviation.items()}, own


def _deviations(entry, reference, *others: Callable[[str, np.ndarray], np.ndarray]) -> list[dict[str, float]]:
    """Of each of the ``others``, functions of a field's name and x, from the reference, which is asked once."""
    x, weight = entry.surface.x, entry.surface.weight
    compared = np.abs(x) > MIDDLE * weight if reference.without_middle else np.full(len(x), True)
    places = {"pressure": compared}
    if has_friction(entry, reference):
        places["traction"] = compared
    if entry.step.branch != "normal":  # there is no slip before
        left, right = reference.contact(entry)
        places["slip"] = compared & (x >= left) & (x <= right)
    found: list[dict[str, float]] = [{} for _ in others]
    for name, at in places.items():
        exact = getattr(reference, name)(entry, x[at])
        for deviations, other in zip(found, others):
            deviations[f"{name}_l2"] = relative_l2(weight[at], other(name, x[at]), exact)
    return found


class Deviations(NamedTuple):
    """Relative deviations of a run from a reference.

    last: fields, a and c of its last state, and the energy of its last cycle (signed where scalar); worst: the largest
    of the fields over every state of the last cycle, or of the run where there is none; own: what of these is the
    reference's own, the largest, {} of an exact one.
    """

    last: dict[str, float]
    worst: dict[str, float]
    own: dict[str, float]


def compare_all(history: History, reference: Reference) -> Deviations:
    """Those of all states, each compared once. What is known of the reference's own error is added."""
    states, own = zip(*(_compared(entry, reference) for entry in all_states(history)))
    of_numbers = _own_of_numbers(history.entries[-1], reference)
    last = states[-1] | _numbers_off(history, reference, of_numbers)
    return Deviations(last, _largest(states), _largest(own) | of_numbers)


def compare(history: History, reference: Reference) -> dict[str, float]:
    """``last`` of ``compare_all`` alone."""
    last = history.entries[-1]
    return compare_state(last, reference) | _numbers_off(history, reference, _own_of_numbers(last, reference))


def _numbers_off(history: History, reference: Reference, own: dict[str, float]) -> dict[str, float]:
    last = history.entries[-1]
    found = {"a": last.a, "c": last.c, "dissipated_energy": history.dissipated_energy}
    return {name: off(found[name], exact, own.get(name, 0.0)) for name, exact in numbers(last, reference).items()}


def off(computed: float, exact: float, own: float) -> float:
    """Relative deviation of a number from a reference's, whose ``own`` error makes it larger."""
    error = computed / exact - 1
    return float(error + np.copysign(own, error))


def own_of_number(exact: float, coarser: float) -> float:
    """Relative error of a reference's number, about; 0 where one of both has none, as of a stick zone that is lost."""
    return float(np.nan_to_num(abs(coarser / exact - 1)))


def _own_of_numbers(last: Entry, reference: Reference) -> dict[str, float]:
    if reference.coarser is None:
        return {}
    exact, coarser = numbers(last, reference), numbers(last, reference.coarser)
    return {name: own_of_number(value, coarser.get(name, 0.0)) for name, value in exact.items()}


def numbers(last: Entry, reference: Reference) -> dict[str, float]:
    """a, c and the energy of a reference; without friction, or where there is no energy, the others."""
    found = {"a": float(np.ptp(reference.contact(last))) / 2}
    if has_friction(last, reference):
        found["c"] = reference.stick_half_width(last)
        if energy := reference.dissipated_energy():
            found["dissipated_energy"] = energy
    return found


def has_friction(entry: Entry, reference: Reference) -> bool:
    """True from tangential loading on, and before where the reference has tractions: not round-off of mu p."""
    if entry.step.branch != "normal":
        return True
    x = entry.surface.x
    return bool(np.abs(reference.traction(entry, x)).max() > ROUND_OFF * reference.pressure(entry, x).max())


def _largest(states: Sequence[dict[str, float]]) -> dict[str, float]:
    """Of every quantity that the last state has; nan where no state has a number."""
    return {name: float(np.fmax.reduce([state.get(name, np.nan) for state in states])) for name in states[-1]}
