"""Finite-element runs for the figures, each made once, and how far they are from the closed forms."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from analytic import CylinderContact

from ...fem.mesh import Grading
from ...output.style import evenly
from ...runs.comparison import relative_l2
from ...runs.simulation import Simulation
from ...scene import Scene, make_scene
from ...scene.scaling import Scaled
from .setting import MU, NU, SHARES, Units, own_units

DRAWN, REACH = 41, 1.05  # computed points drawn a curve, and up to where, over a


@dataclass(frozen=True)
class Field:
    """One state on the surface, arrays (n,), in ``own_units`` of its contact. slip opposes the traction: -h_x."""

    x: np.ndarray
    weight: np.ndarray
    pressure: np.ndarray
    traction: np.ndarray
    slip: np.ndarray

    @property
    def density(self) -> np.ndarray:
        """4 q h_x of a state at +Q_A, (51)."""
        return -4 * self.traction * self.slip

    def drawn(self, farthest: int) -> np.ndarray:
        """Indices of about DRAWN nodes evenly spread over |x| < REACH a, and of the node ``farthest``."""
        return np.unique([*evenly(self.x, REACH, DRAWN), farthest])


@dataclass(frozen=True)
class Loop:
    """Fields at the states A (first loading) ... E, and the energy dissipated in it in ``own_units``."""

    states: dict[str, Field]
    energy: float


@dataclass(frozen=True)
class Deviation:
    """How far computed points are from a curve: an error where both have the same physics, else a difference.

    largest: at any node of the contact, over the curve's largest value. l2: over the contact; nan for single numbers.
    at: index of that node.
    """

    panel: str
    curve: str
    quantity: str
    kind: str
    largest: float
    l2: float
    at: int = -1

    @classmethod
    def of(cls, panel, curve, quantity, exact: bool, weight, computed, closed) -> "Deviation":
        """Deviation of nodal values (n,) from those of the closed form; exact: same physics."""
        distance = np.abs(computed - closed)
        largest, l2 = float(distance.max() / np.abs(closed).max()), relative_l2(weight, computed, closed)
        return cls(panel, curve, quantity, "error" if exact else "difference", largest, l2, int(distance.argmax()))


def convert(values, own: Units, target: Units, quantity: str):
    """Values in ``own`` units, as units of ``target``; quantity: a field of Units."""
    return values * (getattr(own, quantity) / getattr(target, quantity))


class Runs:
    """Runs scenes on a communicator and keeps what the figures need. Every rank calls, every rank gets the result."""

    def __init__(self, comm, overrides: dict | None = None):
        self.comm, self.overrides = comm, overrides or {}

    @cache
    def monotone(self, k: float) -> dict[float, Field]:
        """Fields at Q = share mu P for the SHARES, evenly spaced, of one monotone loading without coupling."""
        scene = self._scene(k, NU, SHARES[-1], coupling=False, cycles=0, increments=len(SHARES))
        simulation = Simulation(self.comm, scene, _cells(scene)).run_to_end()
        fields = [_field(entry, simulation) for entry in simulation.history.entries if entry.step.branch == "initial"]
        return dict(zip(SHARES, fields, strict=True))

    @cache
    def loop(self, k: float, nu: float, amplitude: float, coupling: bool) -> Loop:
        """A full cycle after the first loading."""
        scene = self._scene(k, nu, amplitude, coupling, cycles=1, increments=6)
        simulation = Simulation(self.comm, scene).run_to_end()
        states: dict[str, Field] = {}
        for entry in simulation.history.entries:  # A is the end of the first loading, not of the cycle
            if entry.step.state and entry.step.state not in states:
                states[entry.step.state] = _field(entry, simulation)
        return Loop(states, simulation.history.dissipated_energy / _own_units(simulation).energy)

    def _scene(self, k, nu, amplitude, coupling, cycles, increments) -> Scene:
        scene = {
            "solid.E0": 210e9,
            "solid.k": k,
            "solid.nu": nu,
            "solid.y0_over_a0": 10.0,
            "indenter.R": 0.1,
            "load.P": 1e6,
            "load.mu": MU,
            "load.amplitude": amplitude,
            "load.cycles": cycles,
            "effects.coupling": coupling,
            "solver.increments": increments,
        }
        return make_scene(scene | self.overrides, base=None)


def _cells(scene) -> Grading:
    """Cells graded to the stick edges of every share, not of the last alone."""
    contact = Scaled.of(scene).contact
    edges = [contact.fretting(MU, z=1 - share).c for share in SHARES] + [contact.a]
    return Grading(edges=tuple(sorted([*edges, *(-edge for edge in edges)])), **scene.cell_sizes)


def _own_units(simulation: Simulation) -> Units:
    assert isinstance(simulation.contact, CylinderContact)  # as the scenes here are
    return own_units(simulation.contact)


def _field(entry, simulation: Simulation) -> Field:
    own, surface = _own_units(simulation), entry.surface
    return Field(
        x=surface.x / own.length,
        weight=surface.weight / own.length,
        pressure=surface.pressure / (own.traction / MU),
        traction=surface.traction / own.traction,
        slip=entry.slip / own.slip,
    )


def closed_field(normal: CylinderContact, loop, x, Q: float, branch: str) -> dict[str, np.ndarray]:
    """Closed forms [X5] at x (in a), in ``own_units``; slip as h_x, along the traction, zero outside the contact."""
    own, inside = own_units(normal), np.abs(x) <= 1
    at = x * normal.a
    slip = np.where(inside, loop.slip(at, Q, branch), 0.0) / own.slip
    return {"traction": loop.traction(at, Q, branch) / own.traction, "slip": slip}
