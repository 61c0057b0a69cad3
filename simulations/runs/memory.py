"""Memory that the next load step needs, gathered on rank 0 as arrays that fit any number of ranks, and put back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..fem.body import Y
from ..fem.numbering import Numbering

if TYPE_CHECKING:
    from ..loading.stepping import LoadStepping


def save(solver: LoadStepping, numbering: Numbering) -> dict[str, np.ndarray] | None:
    """Everything that the next load step depends on, by name, on rank 0; None on the others."""
    body, problem = solver.body, solver.problem
    memory = {"delta": body.delta.value.copy(), "forces": solver.system.last_forces()}
    memory |= solver.save()
    memory["state"] = numbering.gather(body.state.x.array)
    if problem.friction:
        memory["anchor"] = numbering.gather_points(problem.memory.anchor.x.array)
        memory["at rest"] = numbering.gather_points(problem.memory.at_rest.x.array)
        memory["ratios"] = solver.entering.ratios()
    if problem is not solver.normal and Y not in problem.directions:
        held = problem.held
        at_nodes = np.zeros_like(held.state.x.array)
        at_nodes[body.dofs[: body.owned_nodes, Y]] = held.forces
        memory["held state"] = numbering.gather(held.state.x.array)
        memory["held pressure"] = numbering.gather_points(held.pressure.x.array)
        memory["held forces"] = numbering.gather(at_nodes)
        memory["normal forces"] = solver.normal_system.last_forces()
    return memory if body.mesh.comm.rank == 0 else None


def restore(memory: dict[str, np.ndarray], solver: LoadStepping, numbering: Numbering):
    """Put back ``save``'s memory, which every rank has, for the stage that ``solver`` stands at."""
    body, problem = solver.body, solver.problem
    body.delta.value[:] = memory["delta"]
    if problem.friction:
        fields = problem.memory.save()
        numbering.scatter_points(memory["anchor"], fields[0])
        numbering.scatter_points(memory["at rest"], fields[1])
        problem.memory.restore(fields)
        solver.entering.take_up(memory.get("ratios", np.array([0.0, 0.0, np.nan, np.nan])))
    if problem is not solver.normal and Y not in problem.directions:
        state, at_nodes = np.zeros_like(body.state.x.array), np.zeros_like(body.state.x.array)
        pressure = np.zeros_like(problem.held.pressure.x.array)
        numbering.scatter(memory["held forces"], at_nodes)
        numbering.scatter_points(memory["held pressure"], pressure)
        numbering.scatter(memory["held state"], state)
        problem.held.restore(state, pressure, at_nodes[body.dofs[: body.owned_nodes, Y]])
        body.state.x.array[:] = state
        solver.normal_system.take_up(memory["normal forces"])
    numbering.scatter(memory["state"], body.state.x.array)
    solver.system.take_up(memory["forces"])
    solver.restore(memory)
