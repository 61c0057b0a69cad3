"""What ``solver.accuracy`` promises; and a run's error where no reference is known well enough, from two meshes and,
where load steps count, from twice as many of them.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import ceil

import numpy as np

from analytic.straight_way import FEWEST

from ..loading.stepping import SolveError
from ..scene import Scene, SceneError, accuracy, make_scene
from ..scene.effects import Effects
from .checks import MORE_STEPS, Check, largest
from .comparison import QUANTITIES, OfStates, compare_all, of_history
from .coupled_loop import serves
from .history import Entry, History
from .mesh_free import needs_many_steps, steps_for_one
from .report_data import Comparison
from .simulation import Simulation

COARSER_MESH = 2.0  # times the fineness
TOO_COARSE = "a smaller solver.accuracy may help"
TWICE = 2  # as many load steps; and FEWEST at least, as with fewer the energy is known in another way
FIRST_ORDER = 2.0  # an error like the load step is twice what half of that step changes
WELL_KNOWN = 0.3  # of the accuracy asked for: a reference whose own error is larger measures none


@dataclass(frozen=True)
class Errors:
    """Relative errors of a run by quantity, of its last state and its worst; an estimate where not measured.

    nan: one that is not known, as of a stick zone too narrow for the mesh; then the largest is not known either.
    """

    last: dict[str, float]
    worst: dict[str, float]
    is_estimate: bool

    @property
    def largest(self) -> float:
        """Of all."""
        return largest(map(abs, (*self.last.values(), *self.worst.values())))

    def plus(self, more: "Errors", names: set[str]) -> "Errors":
        """The sum of two estimates, of which the second counts for these quantities."""
        last, worst_state = (
            {name: abs(error) + (abs(others.get(name, 0.0)) if name in names else 0.0) for name, error in mine.items()}
            for mine, others in ((self.last, more.last), (self.worst, more.worst))
        )
        return Errors(last, worst_state, self.is_estimate or more.is_estimate)

    def in_words(self) -> list[str]:
        """The largest of both states, one line each."""
        kind, lines = "estimated, not measured" if self.is_estimate else "found", []
        for errors, where in ((self.last, "the last state"), (self.worst, "p, q and slip in the worst state")):
            name = max(errors, key=lambda name: np.nan_to_num(abs(errors[name]), nan=np.inf))
            lines.append(f"largest error of {where} {abs(errors[name]):.1e} ({name}; {kind})")
        return lines

    def summary(self) -> dict:
        """What summary.json says of them."""
        return {
            "largest_error": largest(map(abs, self.last.values())),
            "largest_error_worst_state": largest(map(abs, self.worst.values())),
            "is_estimate": self.is_estimate,
            "errors": self.last,
        }


def measured(exact: Comparison | None, wanted: float) -> Errors | None:
    """By a solution of the same physics; None where there is none, or it is not known well enough for ``wanted``."""
    if exact is None or max(exact.own.values(), default=0.0) > WELL_KNOWN * wanted:
        return None
    return Errors({name: e for name, e in exact.deviations.items() if name in QUANTITIES}, exact.worst, False)


def judged(
    simulation: Simulation, exact: Comparison | None, tell: Callable[[str], None] = lambda words: None
) -> tuple[Check, dict]:
    """Check of a finished run's errors against ``solver.accuracy``, and what it was made from; collective.

    exact: of rank 0, from which the errors are measured; else they are estimated, on a second mesh. tell: called with
    words.
    """
    wanted = simulation.scene.solver.accuracy or 0.0
    errors = simulation.body.mesh.comm.bcast(measured(exact, wanted))
    if errors is None:
        tell("second mesh, for the estimate of the error")
        try:
            other, ratio = second(simulation.body.mesh.comm, simulation.scene)
            errors = estimated(simulation, other.run_to_end(), ratio)
            dependent = dependent_on_load_steps(simulation)
            if dependent:
                tell("the same with more load steps")
                errors = errors.plus(of_load_steps(other), dependent)
        except (SceneError, SolveError) as reason:  # the run itself is done
            cause = f"the error is not known, as the second mesh fails: {reason}"
            return Check(float("nan"), wanted, cause), {"wanted": wanted, "is_within": False}
    cause = f"{MORE_STEPS} or {TOO_COARSE}" if simulation.history.friction else TOO_COARSE  # else no memory
    if unknown := [name for name, error in errors.last.items() if np.isnan(error)]:
        cause = f"{', '.join(unknown)} not known, as of a stick zone too narrow for the mesh; {cause}"
    check = Check(errors.largest, wanted, "" if errors.largest <= wanted else cause)
    for words in errors.in_words():
        tell(words)
    tell(f"all states, a, c and energy are {'within' if check.holds else 'NOT within'} {wanted:g}")
    return check, {"wanted": wanted, "is_within": check.holds} | errors.summary()


def _choice(scene: Scene) -> accuracy.Choice:
    """The mesh that ``solver.accuracy`` chose."""
    assert scene.solver.accuracy is not None
    return accuracy.choose(scene.solver.accuracy, *_asked(scene))


def _asked(scene: Scene):
    return accuracy.of_scene(scene.load, scene.material, scene.effects.coupling)


def expectation(scene: Scene) -> str:
    """What ``solver.accuracy`` chose and what is expected of it, in words."""
    choice = _choice(scene)
    sizes = f"facets of {choice.mesh['mesh.facet']:g} a, degree {choice.mesh['mesh.degree']}"
    effects = Effects(scene)
    if effects.has_closed_form or (scene.is_loop and scene.is_power_law and serves(scene, effects)):
        return f"accuracy {scene.solver.accuracy:g}: {sizes}; expected error {choice.error:.1e}"
    return f"accuracy {scene.solver.accuracy:g}: {sizes}; measured for simpler scenes: the error is said at the end"


def second(comm, scene: Scene) -> tuple[Simulation, float]:
    """The same scene on another mesh of the family, not yet run, a coarser one where it is allowed; and what its errors
    are over those of the scene's mesh.
    """
    choice = _choice(scene)
    levels = [level for level in accuracy.expected(*_asked(scene)) if level.fineness != choice.fineness]
    values = {key: value for key, value in scene.to_keys().items() if key != "solver.accuracy"}

    def on_mesh(times: float) -> tuple[Simulation, float]:
        """By the level whose fineness is nearest to so many times that of the scene's mesh."""
        other = min(levels, key=lambda level: abs(np.log(level.fineness / (times * choice.fineness))))
        return Simulation(comm, make_scene(values | other.mesh, base=None)), other.error / choice.error

    try:
        return on_mesh(COARSER_MESH)
    except SceneError:  # as of a slip zone too narrow for it; a finer one tells as much
        return on_mesh(1 / COARSER_MESH)


def estimated(simulation: Simulation, other: Simulation, ratio: float) -> Errors:
    """Errors of ``simulation`` from how far ``other`` is off it.

    The difference is the coarser mesh's error; it is divided by the ``ratio`` that the errors of both meshes have
    where there are closed forms, and multiplied by the margin of the table.
    """
    return _scaled(accuracy.MARGIN / max(ratio, 1.0), other.history, of_history(simulation.history))


def dependent_on_load_steps(simulation: Simulation) -> set[str]:
    """Which quantities of a run depend on its load steps, whatever the mesh.

    All where P changes under friction or the error falls more slowly than the load step, and with coupling, where
    points may come into contact in stick; else, at constant P, the energy alone with elastic slip, and none without.
    """
    pairs, scene = pairwise(simulation.schedule), simulation.scene
    loaded = any(step.P != before.P for before, step in pairs if step.branch != "normal")
    if loaded or needs_many_steps(simulation) or "coupling" in simulation.effects:
        return set(QUANTITIES)
    return {"dissipated_energy"} if scene.effects.elastic_slip else set()


def of_load_steps(simulation: Simulation) -> Errors:
    """Errors of a finished ``simulation`` from its load steps, estimated with more of them on its mesh; collective."""
    scene, history = simulation.scene, simulation.history
    enough = max(TWICE, ceil(FEWEST / scene.solver.increments))
    times = steps_for_one(simulation) if needs_many_steps(simulation) else enough
    more = {"solver.increments": times * scene.solver.increments}
    if "friction in normal stage" in simulation.effects:  # else these do not matter
        more["solver.normal_increments"] = TWICE * scene.solver.normal_increments
    other = Simulation(simulation.body.mesh.comm, make_scene(more, base=scene), simulation.cells).run_to_end()
    finer = OfStates(list(_at_same_loads(history, other.history)), other.history.dissipated_energy)
    return _scaled(FIRST_ORDER, history, finer)


def _scaled(factor: float, history: History, finer: OfStates) -> Errors:
    """How far ``history`` is off what is ``finer``, times ``factor``, as an estimate."""
    last, worst_state = (
        {name: factor * abs(error) for name, error in found.items()}
        for found in compare_all(history, finer)[:2]
    )
    return Errors(last, worst_state, True)


def _at_same_loads(history: History, finer: History) -> Iterator[Entry]:
    """For each entry of a history that of one with more load steps, in order."""
    entries = iter(finer.entries)
    for entry in history.entries:
        yield next(e for e in entries if entry.step.load.is_near(e.step.load))
