"""The present state of a load stage: what a failed load step goes back to, and what a checkpoint keeps."""

import numpy as np
from dolfinx import fem

from ..fem.contact_problem import ContactProblem
from ..solvers.system import System

HELD_FORCES = "held forces"  # (n,) on owned nodes


def fields(problem: ContactProblem) -> dict[str, fem.Function]:
    """Its fields, by name: of the body's unknowns or of the surface points."""
    found = {"state": problem.body.state}
    if problem.friction:
        found |= {"anchor": problem.memory.anchor, "at rest": problem.memory.at_rest}
    if problem.held is not None:
        found |= {"held state": problem.held.state, "held pressure": problem.held.pressure}
    return found


def arrays(system: System) -> dict[str, np.ndarray]:
    """Beside the fields: rigid displacements, and forces."""
    problem = system.problem
    found = {"delta": problem.body.delta.value.copy(), "forces": system.last_forces()}
    return found if problem.held is None else found | {HELD_FORCES: problem.held.forces}


def put_back(system: System, saved: dict[str, np.ndarray]):
    """``arrays``, once the fields are back."""
    problem = system.problem
    problem.body.delta.value[:] = saved["delta"]
    system.take_up(saved["forces"])
    if problem.held is not None:
        problem.held.forces = saved[HELD_FORCES]


def save(system: System) -> dict[str, np.ndarray]:
    """All of it, of this rank."""
    return {name: field.x.array.copy() for name, field in fields(system.problem).items()} | arrays(system)


def restore(system: System, saved: dict[str, np.ndarray]):
    """Put back what ``save`` gave."""
    for name, field in fields(system.problem).items():
        field.x.array[:] = saved[name]
    put_back(system, saved)
