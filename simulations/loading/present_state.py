"""The present state of a load stage: what a failed load step goes back to, and what a checkpoint keeps."""

from typing import Any

import numpy as np
from dolfinx import fem

from forms.contact import Y

from ..fem.body import ElasticBody
from ..fem.contact_problem import ContactProblem
from ..fem.numbering import Numbering
from ..solvers.system import System

HELD_FORCES = "held forces"  # (n,) on owned nodes

Arrays = dict[str, np.ndarray]


def save(system: System) -> Arrays:
    """All of it, of this rank."""
    return {name: field.x.array.copy() for name, field in _fields(system.problem).items()} | _beside_fields(system)


def restore(system: System, saved: Arrays):
    """Put back what ``save`` gave."""
    for name, field in _fields(system.problem).items():
        field.x.array[:] = saved[name]
    _put_back(system, saved)


def gather(system: System, numbering: Numbering) -> Arrays:
    """All of it on rank 0, as arrays that fit any number of ranks; of no use on the others. Collective."""
    fields = _fields(system.problem)
    found: dict[str, Any] = {name: numbering.gather_field(field) for name, field in fields.items()}
    found |= _beside_fields(system)
    if HELD_FORCES in found:
        at_nodes, held = _at_nodes(system.problem.body)
        at_nodes[held] = found[HELD_FORCES]
        found[HELD_FORCES] = numbering.gather(at_nodes)
    return found


def scatter(system: System, gathered: Arrays, numbering: Numbering):
    """Put back what ``gather`` gave, which every rank has."""
    for name, field in _fields(system.problem).items():
        numbering.scatter_field(gathered[name], field)
    if HELD_FORCES in gathered:
        at_nodes, held = _at_nodes(system.problem.body)
        numbering.scatter(gathered[HELD_FORCES], at_nodes)
        gathered = gathered | {HELD_FORCES: at_nodes[held]}
    _put_back(system, gathered)


def _fields(problem: ContactProblem) -> dict[str, fem.Function]:
    """Its fields, by name: of the body's unknowns or of the surface points."""
    found = {"state": problem.body.state}
    if problem.friction:
        found |= {"anchor": problem.memory.anchor, "at rest": problem.memory.at_rest}
    if problem.held is not None:
        found |= {"held state": problem.held.state, "held pressure": problem.held.pressure}
    return found


def _beside_fields(system: System) -> Arrays:
    """Rigid displacements, and forces."""
    problem = system.problem
    found = {"delta": problem.body.delta.value.copy(), "forces": system.last_forces()}
    return found if problem.held is None else found | {HELD_FORCES: problem.held.forces}


def _put_back(system: System, saved: Arrays):
    """``_beside_fields``, once the fields are back."""
    problem = system.problem
    problem.body.delta.value[:] = saved["delta"]
    system.take_up(saved["forces"])
    if problem.held is not None:
        problem.held.forces = saved[HELD_FORCES]


def _at_nodes(body: ElasticBody) -> tuple[np.ndarray, np.ndarray]:
    """An array like that of the body's state, and where in it forces into the body at owned nodes are."""
    return np.zeros_like(body.state.x.array), body.dofs[: body.owned_nodes, Y]
