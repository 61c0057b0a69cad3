"""Reference of a run: closed forms where they are exact, the mesh-free solver for everything else.

A reference answers for the states of a history; dimensionless, like the history. It shares neither the mesh nor the
load steps of the run.
"""

from math import ceil, log2

import numpy as np

from .checks import ERRORS
from .closed_forms import Springs, StretchedForm
from .comparison import NoReference, Reference, compare_all
from .coupled_loop import grades, serves
from .mesh_free import FEWER_NODES, FINER, MeshFree, Tell, nodes_for, steps_for_one
from .simulation import Simulation
from .step_free import StepFree

HALVINGS = 3  # of the load steps of a mesh-free solution that is known too badly to judge a run
ROUGH_TIMES = 20.0  # of a path over its rough edges, of as many load steps; of a loop these take as long as a step


def closed_form(simulation: Simulation) -> Springs | StretchedForm | None:
    """The closed forms of a simulation, whether they describe its physics or neglect some; None without any."""
    if simulation.contact is None:
        return None
    if "bulk strain" in simulation.effects and simulation.stretched:
        return StretchedForm(simulation.stretched, simulation.schedule)
    return Springs(simulation.contact, simulation.mu, simulation.schedule, bool(simulation.hidden_peak))


def neglected(simulation: Simulation) -> list[str]:
    """Effects of a simulation that its closed form, where there is one, leaves out."""
    strained = "bulk strain" in simulation.effects and simulation.stretched is None
    return ["coupling"] * simulation.is_coupled + ["bulk strain"] * strained + simulation.effects.without_closed_form


def expected_seconds(simulation: Simulation) -> float:
    """What ``of_same_physics`` may take, from what the rough edges of the mesh took; 0 for a closed form or none."""
    kind, effects = simulation.scene.reference.kind, simulation.effects
    if kind in ("none", "closed form") or effects.without_reference or (effects.has_closed_form and kind == "auto"):
        return 0.0
    seconds = simulation.watch.seconds.get("edges", 0.0)
    if grades(simulation.scene, effects):
        return seconds  # the edges are the reference's; its error takes as long again
    times = len(simulation.schedule) if simulation.scene.is_loop else ROUGH_TIMES
    return times * steps_for_one(simulation) / FINER * seconds


def of_same_physics(simulation: Simulation, tell: Tell | None = None) -> Reference:
    """The reference that ``reference.kind`` asks for, "auto": closed form where exact; NoReference says why none."""
    kind, foreign = simulation.scene.reference.kind, simulation.effects.without_reference
    if kind == "none":
        raise NoReference("reference.kind = none")
    if foreign:
        raise NoReference(f"no reference describes {' and '.join(foreign)}")
    if simulation.effects.has_closed_form and kind != "half-plane":
        exact = closed_form(simulation)
        assert exact is not None  # has_closed_form
        return exact
    if kind == "closed form":
        raise NoReference("there is no closed form of this problem, and reference.kind = closed form")
    if serves(simulation.scene, simulation.effects):
        # with friction load steps of pressing count too: then the other solver gives all states or none
        pressed_first = "friction in normal stage" in simulation.effects
        try:
            return StepFree(simulation, estimated=True, filled=not pressed_first, tell=tell)
        except NoReference:  # the other solver may
            if simulation.scene.is_loop and not pressed_first and (found := _since_turns(simulation, tell)):
                return found
    return _mesh_free(simulation, tell)


def _since_turns(simulation, tell) -> MeshFree | None:
    """With load steps that grow from each turn: points come into contact in stick before it. None where its error is
    larger than a run's may be: small slip zones drift in so many steps.
    """
    try:
        every = range(1, len(simulation.schedule))
        reference = MeshFree(simulation, tell, FEWER_NODES, estimated=True, since_turn=every)
    except NoReference:
        return None
    return reference if _excess(simulation, reference) <= 1.0 else None


def _mesh_free(simulation, tell) -> MeshFree:
    """With its error, which mostly falls like its load steps: with more of these, should it be larger than a run's may
    be and they help.
    """
    reference = MeshFree(simulation, tell, nodes_for(simulation), estimated=True)
    excess = _excess(simulation, reference)
    if not excess > 1.0:
        return reference
    finer = reference.finer * 2 ** min(ceil(log2(excess)), HALVINGS)
    try:
        other = MeshFree(simulation, tell, FEWER_NODES, finer, estimated=True)
    except NoReference:
        return reference
    return other if _excess(simulation, other) < excess else reference


def _excess(simulation, reference) -> float:
    """Largest of a reference's own errors, over what a run's may be."""
    own = compare_all(simulation.history, reference).own
    return np.nanmax([error / ERRORS[name] for name, error in own.items() if name in ERRORS and name != "c"])


def describe(reference: Reference, simulation: Simulation) -> str:
    """The reference in words: why it has the same physics."""
    scene = simulation.scene
    strain = " with bulk strain" if isinstance(reference, StretchedForm) else ""
    if not isinstance(reference, (Springs, StretchedForm)):
        friction = "the same friction" if scene.friction else "no friction"
        nodes = ""
        if isinstance(reference, StepFree) and reference.between:
            other, places = reference.between, []
            if reference.gaps:
                places.append(f"at {len(reference.gaps)} of {len(reference.states)} states")
            if reference.lacks_energy:
                places.append("for the energy")
            nodes = f", and {' and '.join(places)} {other.name} of {other.nodes} nodes,"
        if isinstance(reference, MeshFree):
            nodes = f" of {reference.nodes} nodes"
            if reference.since_turn:
                nodes += f" and {reference.finer} load steps for ten times the distance from a turn"
            elif reference.finer > steps_for_one(simulation):
                nodes += f" and {reference.finer} load steps for one"
        own = ", whose own error is added" if reference.coarser else ""
        coupling = " and coupling" if "coupling" in simulation.effects else ""
        return f"{reference.name}{nodes} with {friction}{coupling}{own}"
    if not scene.friction:
        return "closed form of the frictionless contact"
    if not scene.is_decoupled:
        return f"closed form{strain}, which neglects coupling as this run does"
    return f"closed form{strain}, exact at the Holl ratio"
