"""Coupled loops over k, ν, μ and Q_A: finite elements on their default mesh, and the solver without load steps beside.

    mpirun -n 2 python -m simulations.studies.coupled_loops [--output DIR] [--stored]

A cylinder is pressed without friction, then Q goes from 0 to Q_A, to -Q_A and back. The ranks share the loops; a study
that was stopped goes on where it was.
"""

import itertools
import time
from argparse import Namespace

import numpy as np
from mpi4py import MPI

from ..command.command import comm, on_root, run, say
from ..loading.stepping import SolveError
from ..output.files import write_table, write_text
from ..runs.comparison import compare_all
from ..runs.mesh_free import MeshFree
from ..runs.reference import NoReference, of_same_physics
from ..runs.report_data import checked
from ..runs.simulation import Simulation
from ..runs.step_free import StepFree
from ..scene import SceneError, make_scene
from .commandline import asked_for, make_folders, study_parser
from .engine import FAILED, Item, Row, run_on
from .store import Store

GRID = {
    "load.mu": (0.3, 0.1, 0.6, 1.0),
    "load.amplitude": (0.6, 0.95, 0.3),
    "solid.nu": (0.0, 0.2, 0.4, 0.495),
    "solid.k": (-0.9, -0.7, -0.5, -0.3, 0.0, 0.3, 0.5, 0.7, 0.9),
}
BASE = {"solid.E0": 210e9, "solid.y0_over_a0": 10.0, "indenter.R": 0.1, "load.P": 1e6}
KEPT = "loops.jsonl"  # what is solved
ERRORS = ("pressure_l2", "traction_l2", "slip_l2", "c", "dissipated_energy")
OWN = tuple(f"own_{name}" for name in ERRORS)  # of these, what is the reference's own
MESH_FREE = ("mesh_free_states", "mesh_free_energy")
SECONDS = ("seconds", "reference_seconds")
COLUMNS = (*(key.partition(".")[2] for key in GRID), *ERRORS, *OWN, *MESH_FREE, *SECONDS, "zigzag", "fails", "why")
LETTERS = ("p", "q", "slip", "c", "energy")


def cases() -> list[Row]:
    """Scene keys of every loop beside those of BASE."""
    return [dict(zip(GRID, values)) for values in itertools.product(*GRID.values())]


def solve(values: Row) -> Row:
    """Row of one loop, or ``why`` there is none.

    Largest errors of p, q and slip over all states of the cycle, of c at its end and of its energy; what of these is
    the reference's own, 0 of a closed form; how many of its states, and whether its energy, are the mesh-free solver's;
    processor time of the run, and of the reference beyond what the run had found for its mesh; the largest zigzag of p
    or q over its range, and the checks of the run that do not hold.
    """
    start = time.process_time()
    try:
        simulation = Simulation(MPI.COMM_SELF, make_scene(BASE | values, base=None)).run_to_end()
        solved = time.process_time()
        reference = of_same_physics(simulation)
    except (SceneError, SolveError, NoReference) as reason:
        return {"why": str(reason)}
    last, worst, own = compare_all(simulation.history, reference)
    errors = last | worst
    row = {name: abs(errors[name]) for name in ERRORS} | dict(zip(OWN, (own.get(name, 0.0) for name in ERRORS)))
    mesh_free = (len(simulation.schedule), True) if isinstance(reference, MeshFree) else (0, False)
    if isinstance(reference, StepFree):
        mesh_free = len(reference.gaps), reference.lacks_energy
    row |= dict(zip(MESH_FREE, mesh_free))
    row |= dict(zip(SECONDS, (solved - start, time.process_time() - solved)))
    checks = checked(simulation)
    row["zigzag"] = max(checks[name].value for name in ("pressure zigzags", "traction zigzags"))
    return row | {"fails": ", ".join(name for name, check in checks.items() if not check.holds)}


def table(values: list[Row], rows: list[Row]) -> str:
    """Markdown: for every k the largest errors of finite elements and of the reference, and seconds in the middle.

    A table of the loops of which the reference has every state and the energy, and one of the others.
    """
    text = ""
    for filled, title in ((False, "Every state without load steps"), (True, "Some states of the mesh-free solver")):
        lines = [f"{title}:\n"]
        lines.append("| k | loops | " + " | ".join((*LETTERS, *(f"own {one}" for one in LETTERS), *SECONDS)) + " |")
        lines.append("|---" * (2 + len(ERRORS + OWN + SECONDS)) + "|")
        for k in GRID["solid.k"]:
            here = [row for value, row in zip(values, rows, strict=True) if value["solid.k"] == k]
            found = [row for row in here if "why" not in row and any(row[name] for name in MESH_FREE) == filled]
            numbers = [f"{max(row[name] for row in found):.1e}" for name in ERRORS + OWN if found]
            numbers += [f"{np.median([row[name] for row in found]):.1f}" for name in SECONDS if found]
            lines.append("| " + " | ".join([f"{k:g}", f"{len(found)} of {len(here)}", *numbers]) + " |")
        text += "\n".join(lines) + "\n\n"
    return text


def main(arguments: list[str]):
    """Solve what is not yet solved, then write the tables."""
    given, items = on_root(lambda: read(arguments))
    rows = run_on(comm, items, solve, Store(given.output / KEPT), say)
    if rows is None:
        return
    values = [item.values for item in items]
    found = [row if FAILED not in row else {"why": row[FAILED]} for row in rows]
    write_table(given.output / "coupled_loops.csv", [_line(*pair) for pair in zip(values, found, strict=True)])
    write_text(given.page, table(values, found))
    say(f"written to {given.output}: coupled_loops.csv; {given.page}")


def _line(values: Row, row: Row) -> Row:
    named = {key.partition(".")[2]: value for key, value in values.items()}
    named |= {name: f"{x:.2e}" if isinstance(x, float) else x for name, x in row.items()}
    return dict.fromkeys(COLUMNS, "") | named


def read(arguments: list[str]) -> tuple[Namespace, list[Item]]:
    """The checked command line and its loops; SceneError where it is wrong."""
    page = "the table (default: DIR/coupled_loops.md)"
    parser = study_parser("coupled_loops", __doc__, "results/coupled_loops", page)
    parser.add_argument("--stored", action="store_true", help="tables of what is solved already")
    given = parser.parse_args(arguments)
    items = [Item(", ".join(f"{name.partition('.')[2]} = {x}" for name, x in one.items()), one) for one in cases()]
    items = asked_for(given, items, KEPT)
    make_folders(given, "coupled_loops.md")
    return given, items


if __name__ == "__main__":
    run(main)
