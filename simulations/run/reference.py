"""What a run is measured against: the closed forms, or the mesh-free half-plane solver for everything else.

A reference answers for the states of a history; dimensionless, like the history.
"""

from typing import Protocol

import numpy as np

from analytic import CylinderContact, FrettingLoop, ProfileContact
from analytic.half_plane.state import ContactState

from .expected_edges import half_plane_solver
from .history import Entry, History
from .simulation import Simulation

NODES = (400, 300)  # of the half-plane solver; the next number is tried where one does not converge


class NoReference(RuntimeError):
    """The half-plane solver could not do what the finite elements did; the message says why."""


class Reference(Protocol):
    """Fields at x (n,), half-widths and the energy of the last cycle (all cycles, where none is full)."""

    name: str

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


class ClosedForm:
    """The closed forms (44), [X4], [X5], which neglect coupling."""

    def __init__(self, normal: CylinderContact | ProfileContact, loop: FrettingLoop | None, cycles: int):
        self.normal, self.loop, self._cycles = normal, loop, cycles
        self.name = "closed form"

    def pressure(self, entry, x):
        """Of the largest load."""
        return self.normal.pressure(x)

    def traction(self, entry, x):
        """[X5]."""
        return self.loop.traction(x, Q=entry.increment.Q, branch=entry.increment.branch)

    def slip(self, entry, x):
        """[X5]; the closed form's slip is that of the indenter on the half-plane."""
        return -self.loop.slip(x, Q=entry.increment.Q, branch=entry.increment.branch)

    def contact(self, entry):
        """(43)."""
        return -self.normal.a, self.normal.a

    def stick_half_width(self, entry):
        """(48) at ±Q_A; the zone that has stuck since the last turn on the way, [X5]."""
        return self.loop.active_half_width(entry.increment.Q, entry.increment.branch)

    def dissipated_energy(self):
        """[X4] for a cycle."""
        return self.loop.dissipated_energy if self._cycles else None


class HalfPlane:
    """States of the half-plane solver at the increments of a simulation; NoReference where it fails."""

    name = "mesh-free half-plane solver"
    nodes: int  # that it converged with

    def __init__(self, simulation: Simulation):
        loads = [(increment.P, increment.Q) for increment in simulation.programme]
        failure = None
        for nodes in NODES:
            try:
                solver = half_plane_solver(simulation.scene, simulation.scaled, simulation.effects, nodes)
                states = solver.run(loads)
                self.nodes = nodes
                break
            except (RuntimeError, ValueError) as reason:
                failure = failure or reason  # the one of the finest nodes is told
        else:
            raise NoReference(str(failure))
        self._increments = simulation.programme
        self._states = {id(increment): state for increment, state in zip(self._increments, states)}

    def _at(self, entry: Entry) -> ContactState:
        return self._states[id(entry.increment)]

    def _interpolated(self, entry, name, x):
        state = self._at(entry)
        return np.interp(x, state.x, getattr(state, name), left=0.0, right=0.0)

    def pressure(self, entry, x):
        """p."""
        return self._interpolated(entry, "pressure", x)

    def traction(self, entry, x):
        """q."""
        return self._interpolated(entry, "traction", x)

    def slip(self, entry, x):
        """Slip."""
        return self._interpolated(entry, "slip", x)

    def contact(self, entry):
        """Edges of the contact."""
        return self._at(entry).contact

    def stick_half_width(self, entry):
        """Half the length of the longest stick zone."""
        left, right = self._at(entry).stick
        return (right - left) / 2

    def dissipated_energy(self):
        """As in the history."""
        last = self._increments[-1]
        energy = self._states[id(last)].dissipated_energy
        if last.cycle:
            start = [increment for increment in self._increments if increment.cycle == last.cycle - 1][-1]
            energy -= self._states[id(start)].dissipated_energy
        return energy


def closed_form(simulation: Simulation) -> ClosedForm | None:
    """The closed forms of a simulation, whether they describe its physics or neglect some; None without any."""
    scene = simulation.scene
    if simulation.contact is None or (scene.friction and not scene.is_loop):
        return None
    return ClosedForm(simulation.contact, simulation.loop, scene.cycles)


def of_same_physics(simulation: Simulation) -> Reference:
    """The reference that ``reference.kind`` asks for, "auto": closed form where exact; NoReference says why none."""
    kind, scene = simulation.scene.reference.kind, simulation.scene
    if kind == "none":
        raise NoReference("reference.kind = none")
    if simulation.effects.without_reference:
        raise NoReference(f"no reference describes {', '.join(simulation.effects.without_reference)}")
    if scene.contact_has_closed_form and kind != "half-plane":
        exact = closed_form(simulation)
        assert exact is not None  # contact_has_closed_form
        return exact
    if kind == "closed form":
        raise NoReference("there is no closed form of this problem, and reference.kind = closed form")
    return HalfPlane(simulation)


def describe(reference: Reference, simulation: Simulation) -> str:
    """The reference in words: why it has the same physics."""
    scene = simulation.scene
    if not isinstance(reference, ClosedForm):
        friction = "the same friction" if scene.friction else "no friction"
        nodes = f" of {reference.nodes} nodes" if isinstance(reference, HalfPlane) else ""
        return f"{reference.name}{nodes} with {friction}{' and coupling' if 'coupling' in simulation.effects else ''}"
    if not scene.friction:
        return "closed form of the frictionless contact"
    if "coupling" not in simulation.effects:
        return "closed form, which neglects coupling as this run does"
    return "closed form, exact at the Holl ratio"


def all_states(history: History) -> list[Entry]:
    """Entries with a tangential load, of the last cycle where there is one."""
    if history.has_cycle:
        return history.last_cycle
    return [entry for entry in history.entries if entry.increment.branch != "normal"]
