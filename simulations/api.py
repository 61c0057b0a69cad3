"""The package from Python: a scene from keys, a run without files, its results as arrays in SI units."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np
from mpi4py import MPI

from .runs import checks, comparison, estimate, reference, report_data
from .runs.history import Entry
from .runs.simulation import Simulation
from .scene import DEFAULT_SCENE, Scene, SceneError, make_scene
from .scene.scaling import Scales

_ALONE = RLock()  # gmsh and PETSc crash where several threads are in them at once


@dataclass(frozen=True)
class Result:
    """What a run found, SI units. s states, n surface nodes.

    Fields are those of every load step in order; ``simulation`` has the rest, in scaled units.
    """

    simulation: Simulation

    @property
    def _entries(self) -> list[Entry]:
        return self.simulation.history.entries

    @property
    def _scales(self) -> Scales:
        return self.simulation.scaled.scales

    def _stack(self, get: Callable[[Entry], Any], unit: float) -> np.ndarray:
        return np.array([get(entry) for entry in self._entries]) * unit

    @cached_property
    def x(self) -> np.ndarray:
        """(n,) positions along the surface, m."""
        return self._entries[0].surface.x * self._scales.length

    @cached_property
    def weight(self) -> np.ndarray:
        """(n,) length of surface that belongs to a node, m: ``pressure @ weight`` is P."""
        return self._entries[0].surface.weight * self._scales.length

    @cached_property
    def pressure(self) -> np.ndarray:
        """(s, n) contact pressure, Pa."""
        return self._stack(lambda entry: entry.surface.pressure, self._scales.stress)

    @cached_property
    def traction(self) -> np.ndarray:
        """(s, n) tangential traction on the half-plane, positive along +Q, Pa; 0 without friction."""
        return self._stack(lambda entry: entry.surface.traction, self._scales.stress)

    @cached_property
    def slip(self) -> np.ndarray:
        """(s, n) u_x - delta_x since tangential loading began, less the elastic slip, m; 0 without friction."""
        return self._stack(lambda entry: entry.slip, self._scales.displacement)

    @cached_property
    def frictional_work(self) -> np.ndarray:
        """(n,) energy dissipated per area in the last full cycle, w of (51), or since the start where there is none,
        J/m².
        """
        return self.simulation.history.work * self._scales.energy / self._scales.length

    @cached_property
    def P(self) -> np.ndarray:
        """(s,) normal line load, N/m."""
        return self._stack(lambda entry: entry.step.P, self._scales.line_load)

    @cached_property
    def Q(self) -> np.ndarray:
        """(s,) tangential line load, N/m."""
        return self._stack(lambda entry: entry.step.Q, self._scales.line_load)

    @cached_property
    def delta(self) -> np.ndarray:
        """(s, 2) displacement of the indenter along and into the surface, m."""
        return self._stack(lambda entry: entry.surface.delta, self._scales.displacement)

    @property
    def a(self) -> float:
        """Contact half-width at the end, m."""
        return self._entries[-1].a * self._scales.length

    @property
    def c(self) -> float:
        """Stick half-width at the end, m; nan without friction."""
        stick = self._entries[-1].c if self.simulation.history.friction else np.nan
        return stick * self._scales.length

    @property
    def dissipated_energy(self) -> float:
        """Of the last full cycle, or of everything where there is none, J/m; 0 without friction."""
        return self.simulation.history.dissipated_energy * self._scales.energy

    @cached_property
    def checks(self) -> dict[str, checks.Check]:
        """What the run is checked for after the solve, by name: value, limit, and whether it ``holds``.

        Errors are among them beside a closed form, which costs little. ``accuracy`` is, where ``solver.accuracy`` is
        given, and then every rank has to ask: without a closed form the errors are estimated from a second mesh.
        """
        simulation = self.simulation
        is_known = simulation.effects.has_closed_form and simulation.scene.reference.kind != "none"
        exact = reference.closed_form(simulation) if is_known else None
        beside = report_data.compared(simulation, exact) if exact else None
        found = report_data.checked(simulation, beside)
        if simulation.scene.solver.accuracy is not None:
            found["accuracy"], _ = estimate.judged(simulation, beside)
        return found

    def errors(self) -> dict[str, float]:
        """Relative deviations from what has the same physics; reference.NoReference where there is none."""
        return comparison.compare(self.simulation.history, reference.of_same_physics(self.simulation))


def run(
    changes: Mapping[str, Any] | Scene | None = None,
    base: str | Path | Scene | None = DEFAULT_SCENE,
    comm: MPI.Comm = MPI.COMM_SELF,
    progress: Callable[[Entry], None] | None = None,
) -> Result:
    """Run a Scene, or ``make_scene(changes, base)``, to its end; no files. SolveError where there is no solution.

    Where checks of the result fail, a ``ChecksWarning`` names them (``warnings.simplefilter("error", ChecksWarning)``
    makes it an error). What theory or mesh show badly is a warning too. comm: every rank of it calls ``run`` and gets
    the whole result; progress: called with each entry of the history. Threads that call ``run`` wait for each other.
    """
    if isinstance(changes, Scene) and base is not DEFAULT_SCENE:
        raise SceneError("base is not allowed beside a Scene: keys and values are changes of a base")
    with _ALONE:
        scene = changes if isinstance(changes, Scene) else make_scene(changes, base)
        simulation = Simulation(comm, scene)
        for words in simulation.warnings:
            warnings.warn(words, stacklevel=2)
        for entry in simulation.run():
            if progress:
                progress(entry)
        result = Result(simulation)
        if not checks.hold(result.checks):
            warnings.warn(checks.describe(result.checks), checks.ChecksWarning, stacklevel=2)
        return result
