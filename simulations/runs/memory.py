"""Memory that the next load step needs, gathered on rank 0 as arrays that fit any number of ranks, and put back."""

from typing import Any

import numpy as np

from ..fem.body import Y
from ..fem.numbering import Numbering
from ..loading.present_state import HELD_FORCES, arrays, fields, put_back
from ..loading.stepping import LoadStepping


def save(solver: LoadStepping, numbering: Numbering) -> dict[str, np.ndarray] | None:
    """Everything that the next load step depends on, by name, on rank 0; None on the others."""
    body = solver.body
    memory: dict[str, Any] = {name: numbering.gather_field(field) for name, field in fields(solver.problem).items()}
    memory |= arrays(solver.system) | solver.save()
    if HELD_FORCES in memory:
        at_nodes = np.zeros_like(body.state.x.array)
        at_nodes[body.dofs[: body.owned_nodes, Y]] = memory[HELD_FORCES]
        memory[HELD_FORCES] = numbering.gather(at_nodes)
    return memory if body.mesh.comm.rank == 0 else None


def restore(memory: dict[str, np.ndarray], solver: LoadStepping, numbering: Numbering):
    """Put back ``save``'s memory, which every rank has, for the stage that ``solver`` stands at."""
    body = solver.body
    for name, field in fields(solver.problem).items():
        numbering.scatter_field(memory[name], field)
    if HELD_FORCES in memory:
        at_nodes = np.zeros_like(body.state.x.array)
        numbering.scatter(memory[HELD_FORCES], at_nodes)
        memory = memory | {HELD_FORCES: at_nodes[body.dofs[: body.owned_nodes, Y]]}
    put_back(solver.system, memory)
    solver.restore(memory)
