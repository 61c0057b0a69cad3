"""What ``solver.accuracy`` promises; and a run's error from two meshes, where no reference is known well enough."""

import numpy as np

from ..scene import Scene, accuracy, make_scene
from ..scene.effects import Effects
from ..scene.solid import is_holl_ratio
from .comparison import compare, worst
from .coupled_loop import serves
from .history import Entry, History
from .simulation import Simulation

COARSER = 2.0  # times the fineness


class Solved:
    """Another run of the same schedule as reference, between its nodes interpolated."""

    name = "finer mesh"
    coarser = None

    def __init__(self, history: History):
        """history: of the increments of the run whose entries this is asked about."""
        self.history = history

    def _at(self, entry: Entry) -> Entry:
        return self.history.entries[entry.number]

    def _interpolated(self, entry, x, values):
        return np.interp(x, self._at(entry).surface.x, values)

    def pressure(self, entry, x):
        """p."""
        return self._interpolated(entry, x, self._at(entry).surface.pressure)

    def traction(self, entry, x):
        """q."""
        return self._interpolated(entry, x, self._at(entry).surface.traction)

    def slip(self, entry, x):
        """Slip."""
        return self._interpolated(entry, x, self._at(entry).slip)

    def contact(self, entry):
        """Edges of the contact."""
        return self._at(entry).contact

    def stick_half_width(self, entry):
        """c."""
        return self._at(entry).c

    def dissipated_energy(self):
        """As in the history."""
        return self.history.dissipated_energy


def _choice(scene: Scene) -> accuracy.Choice:
    """The mesh that ``solver.accuracy`` chose."""
    assert scene.solver.accuracy is not None
    return accuracy.choose(scene.solver.accuracy, *_asked(scene))


def _asked(scene: Scene):
    coupled = scene.effects.coupling and not is_holl_ratio(scene.solid.nu, scene.k)
    return accuracy.of_load(scene.load, coupled, scene.k)


def expectation(scene: Scene) -> str:
    """What ``solver.accuracy`` chose and what is expected of it, in words."""
    choice = _choice(scene)
    sizes = f"facets of {choice.mesh['mesh.facet']:g} a, degree {choice.mesh['mesh.degree']}"
    effects = Effects(scene)
    if effects.has_closed_form or (scene.is_loop and serves(scene, effects)):
        return f"accuracy {scene.solver.accuracy:g}: {sizes}; expected error {choice.error:.1e}"
    return f"accuracy {scene.solver.accuracy:g}: {sizes}; measured for simpler scenes: the error is said at the end"


def coarser(comm, scene: Scene) -> tuple[Simulation, float]:
    """The same scene on a coarser mesh of the family, not yet run, and what its errors are over those of the
    scene's mesh.
    """
    choice = _choice(scene)
    levels = accuracy.expected(*_asked(scene))
    other = min(levels, key=lambda level: abs(np.log(level.fineness / (COARSER * choice.fineness))))
    if other.fineness <= choice.fineness:  # already the coarsest: a finer one tells as much
        other = min(levels, key=lambda level: abs(np.log(level.fineness * COARSER / choice.fineness)))
    values = {key: value for key, value in scene.to_keys().items() if key != "solver.accuracy"} | other.mesh
    return Simulation(comm, make_scene(values, base=None)), other.error / choice.error


def estimated(simulation: Simulation, other: Simulation, ratio: float) -> tuple[dict[str, float], dict[str, float]]:
    """Errors of ``simulation`` by quantity, at the last and at the worst state, from how far ``other`` is off it.

    The difference is the coarser mesh's error; it is divided by the ``ratio`` that the errors of both meshes have
    where there are closed forms, and multiplied by the margin of the table.
    """
    factor, finer = accuracy.MARGIN / max(ratio, 1.0), Solved(simulation.history)
    found = compare(other.history, finer), worst(other.history, finer)
    last, worst_state = ({name: factor * abs(v) for name, v in f.items() if np.isfinite(v)} for f in found)
    return last, worst_state
