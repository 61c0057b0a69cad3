"""Solve the hard cases and lay out how each ended:  mpirun -n 2 python -m simulations.studies.stability [--output DIR].

The cases are data (stability.toml); each differs from one coarse base scene. What is solved is kept in the folder, so
that a study that was stopped goes on where it was; under mpirun the ranks share the cases. After a change of the code
use another folder: a case is solved again only where its values changed.
"""

import itertools
import time
import tomllib
from argparse import Namespace
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from mpi4py import MPI

from ..command.command import comm, on_root, run, say
from ..loading.stepping import SolveError
from ..output.files import write_table, write_text
from ..runs import critical_friction
from ..runs.checks import LARGE, Check, drift
from ..runs.comparison import compare_all
from ..runs.energy import EnergyMeter, worst_defect
from ..runs.reference import NoReference, of_same_physics
from ..runs.report_data import checked, checked_errors
from ..runs.simulation import Simulation
from ..scene import Scene, SceneError, make_scene
from .commandline import make_folders, study_parser
from .engine import FAILED as NO_ROW
from .engine import Item, run_on
from .stability_report import FAILED, FAILING, GREEN, REFUSED, UNJUDGED, WRONG, picture, summary, table
from .store import Store

CASES = Path(__file__).with_suffix(".toml")
ENERGY = 1e-6  # of what a load step turns over, or where that is more ...
ENERGY_ROUND_OFF = 10.0  # ... this many times Newton's tolerance, of P²/E(a)
CONSISTENCY = 1e-3  # theta != 0 adds forces that do work through the error of discretisation
SEED = 20260116  # of the draw
EVERY_STATE = "every state"  # key of a case whose errors are the largest of all states; no key of a scene
DRIFT = 1e-6  # of the steady loop from cycle to cycle, over the largest pressure


def read_cases(only: Sequence[str] = ()) -> dict[str, dict]:
    """Scene keys by name of the case; ``only`` the studies of these names, else of all."""
    document = tomllib.loads(CASES.read_text(encoding="utf-8"))
    studies, cases = {study["name"]: study for study in document["study"]}, {}
    if set(only) - set(studies):
        raise SceneError(f"--only {' '.join(only)} is not allowed: {', '.join(studies)}")
    for name, study in studies.items():
        if only and name not in only:
            continue
        base = {key: value for key, value in document["base"].items() if key not in study.get("without", ())}
        keys, each = study.get("keys", {}), study.get("each", [])
        products = itertools.product(*keys.values()) if keys else ()
        for changes in [*(dict(zip(keys, values)) for values in products), *each]:
            said = [f"{key.partition('.')[2]} {value}" for key, value in changes.items() if not isinstance(value, list)]
            cases[f"{name}: {', '.join(said)}"] = base | changes
    return cases


def drawn_cases(count: int) -> dict[str, dict]:
    """The first ``count`` of a seeded draw over what a scene admits, on the default mesh, each judged at every state:
    scene keys by name."""
    base = next(iter(read_cases(["Holl ratio"]).values()))
    base = {key: value for key, value in base.items() if not key.startswith("mesh.")}
    random, cases = np.random.default_rng(SEED), {}
    for number in range(count):
        coupled = bool(random.random() < 0.7)
        changes = {
            "solid.k": round(float(random.uniform(-0.9, 0.9)), 3),
            "solid.nu": round(float(random.uniform(-0.5, 0.5)), 3),
            "load.mu": float(f"{np.exp(random.uniform(*np.log((0.01, 4.0)))):.3g}"),
            "load.amplitude": round(float(random.uniform(0.1, 0.99)), 3),
            "solver.increments": int(random.integers(2, 7)),
            "effects.friction_in_normal_stage": coupled and bool(random.random() < 0.2),
            "effects.coupling": coupled,
        }
        shown = ", ".join(f"{key.partition('.')[2]} {value}" for key, value in changes.items())
        kind = "half-plane" if coupled else "closed form"
        cases[f"drawn: {number + 1}, {shown}"] = base | changes | {"reference.kind": kind, EVERY_STATE: True}
    return cases


def solve(values: dict) -> dict:
    """One case: how it ended (``outcome``, ``why``) and its numbers."""
    start, values = time.perf_counter(), dict(values)
    every_state = values.pop(EVERY_STATE, False)
    side = ""
    try:
        scene = make_scene(values, base=None)
        side = critical_friction.side(scene)
        row = _measure(scene, every_state)
    except SceneError as reason:
        row = {"outcome": REFUSED, "why": str(reason)}
    except SolveError as reason:
        row = {"outcome": FAILED, "why": str(reason)}
    return row | {"friction": side, "seconds": round(time.perf_counter() - start, 3)}


def _measure(scene: Scene, every_state: bool) -> dict:
    simulation = Simulation(MPI.COMM_SELF, scene)
    meter = EnergyMeter(simulation.body)
    for entry in simulation.run():
        meter.read(entry)
    history = simulation.history
    tolerance = max(entry.tolerance for entry in history.entries)
    checks = checked(simulation)
    defects = {name: c.value for name, c in checks.items() if not c.holds}
    balance = worst_defect(meter.steps, ENERGY_ROUND_OFF * tolerance / ENERGY)
    if balance > (CONSISTENCY if scene.solver.theta else ENERGY):
        defects["energy balance"] = balance
    drifting = drift(history) if scene.cycles > 1 else 0.0
    if drifting > max(DRIFT, 10 * tolerance):
        defects["drift"] = drifting
    errors, beside = _errors(simulation, every_state)
    off = {name: c for name, c in beside.items() if not c.holds}
    outcome, why = GREEN, ""
    if defects:
        outcome, why = FAILING, _told(defects, checks.values())
    elif off:
        why = _told({name: c.value for name, c in off.items()}, off.values())
        outcome = WRONG if LARGE in why else UNJUDGED
    return {
        "outcome": outcome,
        "why": why,
        "unknowns": simulation.body.unknowns,
        "increments": len(history.entries),
        "iterations": sum(entry.iterations for entry in history.entries),
        "most_iterations": max(entry.iterations for entry in history.entries),
        "cuts": sum(entry.cuts for entry in history.entries),
        "residual": max(entry.residual for entry in history.entries),
        "tolerance": tolerance,
        "residual_over_tolerance": max(entry.residual / entry.tolerance for entry in history.entries),
        "energy_defect": balance,
        "drift": drifting,
        **{f"check {name}": c.value for name, c in checks.items()},
        **{f"error {name}": value for name, value in errors.items()},
    }


def _told(values: dict[str, float], checks: Iterable[Check]) -> str:
    """Numbers by name, and the causes that checks know."""
    numbers = ", ".join(f"{name} {value:.1e}" for name, value in values.items())
    return "; ".join([numbers, *(c.cause for c in checks if c.cause)])


def _errors(simulation: Simulation, every_state: bool) -> tuple[dict[str, float], dict[str, Check]]:
    """Of the last state, or the largest of all states of the last cycle, and their checks; none without reference."""
    try:
        reference = of_same_physics(simulation)
    except NoReference:
        return {}, {}
    last, worst, own = compare_all(simulation.history, reference)
    found = last | worst if every_state else last
    return found, checked_errors(simulation, reference, found, own)


def main(arguments: list[str]):
    """Solve what is not yet solved, then write the tables and the picture of all."""
    given, cases = on_root(lambda: read(arguments))
    items = [Item(name, values) for name, values in cases.items()]
    found = run_on(comm, items, solve, Store(given.output / "cases.jsonl"), say)
    if found is None:
        return
    # what ends a case in a way that nobody foresaw is no answer
    found = [{"outcome": FAILED, "why": row[NO_ROW], "seconds": 0.0} if NO_ROW in row else row for row in found]
    rows = [{"name": item.name} | row for item, row in zip(items, found, strict=True)]
    write_table(given.output / "stability.csv", rows)
    write_text(given.page, table(rows))
    picture(given.output / "stability.png", rows)
    say(summary(rows) + f"\nwritten to {given.output}: stability.csv, stability.png; {given.page}")


def read(arguments: list[str]) -> tuple[Namespace, dict[str, dict]]:
    """The checked command line and its cases; SceneError where it is wrong."""
    parser = study_parser("stability", __doc__, "results/stability", "the table (default: DIR/stability.md)")
    parser.add_argument("--only", nargs="+", default=[], metavar="STUDY", help="studies of stability.toml")
    parser.add_argument("--drawn", type=int, default=0, metavar="N", help="cases of a seeded draw beside them (0)")
    given = parser.parse_args(arguments)
    cases = read_cases(given.only)
    if given.drawn < 0:
        raise SceneError(f"--drawn {given.drawn} is not allowed: an integer ≥ 0")
    cases |= drawn_cases(given.drawn)
    make_folders(given, "stability.md")
    return given, cases


if __name__ == "__main__":
    run(main)
