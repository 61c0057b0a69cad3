"""Coupled loops over k, ν, μ and Q_A: the solver without load steps at two orders, and finite elements beside it.

    mpirun -n 2 python -m simulations.studies.coupled_loops [--output DIR] [--only reference elements] [--stored]

A cylinder is pressed without friction, then Q goes from 0 to Q_A, to -Q_A and back. The ranks share the loops; a study
that was stopped goes on where it was.
"""

import itertools
import time
from argparse import Namespace

import numpy as np
from mpi4py import MPI

from analytic import CoupledLoop, GradedHalfPlane, PowerProfile
from analytic.coupled.loop import ORDER
from analytic.half_plane.linear import ContactNotConverged

from ..command.command import comm, on_root, run, say
from ..loading.stepping import SolveError
from ..output.files import write_table, write_text
from ..runs.comparison import NoReference, compare, worst
from ..runs.simulation import Simulation
from ..runs.step_free import LOWER, StepFree
from ..scene import SceneError, make_scene
from .commandline import asked_for, make_folders, study_parser
from .engine import FAILED, Item, Row, run_all, workers
from .store import Store

K, NU = (-0.9, -0.7, -0.5, -0.3, 0.0, 0.3, 0.5, 0.7, 0.9), (0.0, 0.2, 0.4, 0.495)
FRICTION, AMPLITUDE = (0.3, 0.1, 0.6, 1.0), (0.6, 0.95, 0.3)
WITH_ELEMENTS = (0.2, 0.3, 0.95), (0.4, 0.6, 0.6)  # ν, μ and Q_A/μP, for every k, with finite elements beside
WAY = (0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0, 0.5, 1.0)  # Q over Q_A
KINDS = ("reference", "elements")
KEPT = "loops.jsonl"  # what is solved
DIFFERENCES = ("pressure", "traction", "stick", "energy")  # of two orders of the basis
ERRORS = ("pressure_l2", "traction_l2", "slip_l2", "dissipated_energy")  # of finite elements
COLUMNS = ("kind", "k", "nu", "mu", "share", *DIFFERENCES, *ERRORS, "seconds", "why")


def cases(kinds=KINDS) -> list[Row]:
    """Values of every run."""
    grid = itertools.product(FRICTION, AMPLITUDE, NU, K)
    loops = [(k, nu, mu, share, KINDS[0]) for mu, share, nu, k in grid]
    loops += [(k, *case, KINDS[1]) for case in WITH_ELEMENTS for k in K]
    return [dict(zip(("k", "nu", "mu", "share", "kind"), loop)) for loop in loops if loop[-1] in kinds]


def solve(values: Row) -> Row:
    """Row of one run: differences of two orders, or errors of finite elements, and processor time; or ``why`` not."""
    try:
        return (orders_apart if values["kind"] == KINDS[0] else elements)(values)
    except (SceneError, SolveError, NoReference, ContactNotConverged) as reason:
        return {"why": str(reason)}


def orders_apart(values: Row) -> Row:
    """Largest differences over all states between a lower order and that of the reference.

    Of p and q in L2, over p; of the stick half-width over that of the contact; of the energy of the cycle.
    """
    start = time.process_time()
    fine = _states(values, ORDER)
    try:
        coarse = _states(values, ORDER - LOWER, fine)
    except ContactNotConverged:
        coarse = _states(values, ORDER + LOWER, fine)
    seconds = time.process_time() - start
    rows = []
    for state, other in zip(fine[1:], coarse[1:], strict=True):
        norm = np.sqrt(state.weight @ state.pressure**2)
        apart = other.pressure_at(state.x) - state.pressure, other.traction_at(state.x) - state.traction
        contact, stick, stick_too = (np.diff(edges)[0] for edges in (state.contact, state.stick, other.stick))
        rows.append([*(np.sqrt(state.weight @ d**2) / norm for d in apart), abs(stick_too - stick) / contact])
    energy, lower = (_cycle(states) for states in (fine, coarse))
    largest = [*np.max(rows, axis=0), abs(lower / energy - 1)]
    return dict(zip(DIFFERENCES, map(float, largest))) | {"seconds": seconds}


def _states(values, order, like=()):
    solid = GradedHalfPlane(1.0, values["nu"], values["k"], 1.0)
    Q_A = values["share"] * values["mu"]
    loop = CoupledLoop(solid, PowerProfile(0.5, 2.0), 1.0, values["mu"], order=order)
    return loop.run([(1.0, 0.0), *((1.0, way * Q_A) for way in WAY)], like)


def _cycle(states):
    return states[-1].dissipated_energy - states[WAY.index(1.0) + 1].dissipated_energy


def elements(values: Row) -> Row:
    """Errors of finite elements on their default mesh: p, q and slip in the worst state, energy of the cycle."""
    scene = {"solid.E0": 210e9, "solid.k": values["k"], "solid.nu": values["nu"], "solid.y0_over_a0": 10.0}
    scene |= {"indenter.R": 0.1, "load.P": 1e6, "load.mu": values["mu"], "load.amplitude": values["share"]}
    start = time.process_time()
    simulation = Simulation(MPI.COMM_SELF, make_scene(scene, base=None)).run_to_end()
    seconds = time.process_time() - start
    reference = StepFree(simulation, filled=True)
    errors = compare(simulation.history, reference) | worst(simulation.history, reference)
    return {name: abs(errors[name]) for name in ERRORS} | {"seconds": seconds}


def table(values: list[Row], rows: list[Row]) -> str:
    """Markdown: for every k the loops solved, largest differences of two orders, largest errors of finite elements."""
    lines = ["| k | solved | p | q | c/a | energy | finite elements: p | q | slip | energy |", "|---" * 10 + "|"]
    for k in K:
        here = [(value["kind"], row) for value, row in zip(values, rows, strict=True) if value["k"] == k]
        served, beside = ([r for kind, r in here if kind == one and "seconds" in r] for one in KINDS)
        asked = sum(kind == KINDS[0] for kind, _ in here)
        numbers = [max((row[name] for row in served), default=np.nan) for name in DIFFERENCES]
        numbers += [max((row[name] for row in beside), default=np.nan) for name in ERRORS]
        cells = [f"{number:.1e}" if np.isfinite(number) else "" for number in numbers]
        lines.append("| " + " | ".join([f"{k:g}", f"{len(served)} of {asked}", *cells]) + " |")
    return "\n".join(lines) + "\n"


def main(arguments: list[str]):
    """Solve what is not yet solved, then write the tables."""
    given, items = on_root(lambda: read(arguments))
    with workers(comm) as executor:
        if comm.rank == 0:
            rows = run_all(items, solve, Store(given.output / KEPT), executor, say)
    if comm.rank == 0:
        values = [item.values for item in items]
        found = [row if FAILED not in row else {"why": row[FAILED]} for row in rows]
        numbers = [{name: f"{x:.2e}" if isinstance(x, float) else x for name, x in row.items()} for row in found]
        flat = [dict.fromkeys(COLUMNS, "") | value | row for value, row in zip(values, numbers, strict=True)]
        write_table(given.output / "coupled_loops.csv", [{name: row[name] for name in COLUMNS} for row in flat])
        write_text(given.page, table(values, found))
        say(f"written to {given.output}: coupled_loops.csv; {given.page}")


def read(arguments: list[str]) -> tuple[Namespace, list[Item]]:
    """The checked command line and its runs; SceneError where it is wrong."""
    page = "the table (default: DIR/coupled_loops.md)"
    parser = study_parser("coupled_loops", __doc__, "results/coupled_loops", page)
    parser.add_argument("--only", nargs="+", default=KINDS, choices=KINDS, metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--stored", action="store_true", help="tables of what is solved already")
    given = parser.parse_args(arguments)
    items = [Item(", ".join(f"{name} = {value}" for name, value in one.items()), one) for one in cases(given.only)]
    items = asked_for(given, items, KEPT)
    make_folders(given, "coupled_loops.md")
    return given, items


if __name__ == "__main__":
    run(main)
