"""What ``solver.accuracy`` promises; and a run's error where no reference is known well enough, from a finer mesh on a
larger domain and, where load steps count, with more of them.
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
from .comparison import QUANTITIES, OfStates, compare_all
from .coupled_loop import serves
from .history import Entry, History
from .mesh_free import needs_many_steps, steps_for_one
from .report_data import Comparison
from .simulation import Simulation

TOO_COARSE = "a smaller solver.accuracy may help"
TWICE = 2  # as many load steps; and FEWEST at least, as with fewer the energy is known in another way
OVER_CHANGE = 2.5  # error over what the next finer mesh changes; beside known errors 0.2 to 2.3 times that was enough
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
            errors = estimated(simulation, second(simulation).run_to_end())
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
    return accuracy.choose(scene.solver.accuracy, *_asked(scene), share=accuracy.share_for(scene.reference.kind))


def _asked(scene: Scene) -> tuple[float, float | None, bool]:
    return accuracy.of_scene(scene.load, scene.material, scene.effects.coupling)


def expectation(scene: Scene) -> str:
    """What ``solver.accuracy`` chose and what is expected of it, in words."""
    choice = _choice(scene)
    sizes = f"facets of {choice.mesh['mesh.facet']:g} a, degree {choice.mesh['mesh.degree']}"
    effects = Effects(scene)
    if effects.has_closed_form or (scene.is_loop and scene.is_power_law and serves(scene, effects)):
        return f"accuracy {scene.solver.accuracy:g}: {sizes}; expected error {choice.error:.1e}"
    return f"accuracy {scene.solver.accuracy:g}: {sizes}; measured for simpler scenes: the error is said at the end"


def second(simulation: Simulation) -> Simulation:
    """The same scene, not yet run, on the next finer mesh of the family, or the next coarser one where that is refused;
    on a domain that is larger (smaller) by as much, and with more load steps where errors depend on them; collective.
    """
    scene, choice = simulation.scene, _choice(simulation.scene)
    values = {key: value for key, value in scene.to_keys().items() if key != "solver.accuracy"}
    values |= more_load_steps(simulation)
    levels = accuracy.expected(*_asked(scene))  # the finest first
    place = [level.fineness for level in levels].index(choice.fineness)
    refused = SceneError("its family has no other")
    for level in (*levels[:place][-1:], *levels[place + 1 :][:1]):
        extent = choice.mesh["mesh.extent"] * choice.fineness / level.fineness
        sizes = level.mesh | {"mesh.extent": extent}
        try:
            return Simulation(simulation.body.mesh.comm, make_scene(values | sizes, base=None))
        except SceneError as reason:  # as of a finer one too large, or a slip zone too narrow for a coarser one
            refused = reason
    raise refused


def more_load_steps(simulation: Simulation) -> dict[str, int]:
    """Keys of a scene with more load steps; none where errors of a run do not depend on them, whatever the mesh.

    They do where P changes under friction or the error falls more slowly than the load step, and with coupling, where
    points may come into contact in stick; else, at constant P, with elastic slip alone.
    """
    scene, keys = simulation.scene, {}
    loaded = any(step.P != before.P for before, step in pairwise(simulation.schedule) if step.branch != "normal")
    many = needs_many_steps(simulation)
    if loaded or many or "coupling" in simulation.effects or scene.effects.elastic_slip:
        times = steps_for_one(simulation) if many else max(TWICE, ceil(FEWEST / scene.solver.increments))
        keys["solver.increments"] = times * scene.solver.increments
    if "friction in normal stage" in simulation.effects:  # else these do not matter
        keys["solver.normal_increments"] = TWICE * scene.solver.normal_increments
    return keys


def estimated(simulation: Simulation, other: Simulation) -> Errors:
    """Errors of ``simulation`` from how far it is off ``other``, a finished run on another mesh."""
    history = simulation.history
    beside = OfStates(list(_at_same_loads(history, other.history)), other.history.dissipated_energy)
    last, worst_state = (
        {name: OVER_CHANGE * abs(error) for name, error in found.items()}
        for found in compare_all(history, beside)[:2]
    )
    return Errors(last, worst_state, True)


def _at_same_loads(history: History, finer: History) -> Iterator[Entry]:
    """For each entry of a history that of one with more load steps, in order."""
    entries = iter(finer.entries)
    for entry in history.entries:
        yield next(e for e in entries if entry.step.load.is_near(e.step.load))
