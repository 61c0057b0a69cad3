"""Many scenes, one table: ``sweep(scene, vary)`` runs every combination and returns a row for each.

    from simulations import sweep
    table = sweep(vary={"solid.k": [-0.3, 0.0, 0.3], "load.amplitude": [0.5, 0.9]})
    table.to_csv("sweep.csv")
"""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from ..output.files import write_table
from ..output.folder import RUNS, begin, claimed, has_lost_scene, is_run_of, refuse_changed
from ..output.results import Results
from ..runs import comparison
from ..runs.estimate import judged
from ..runs.report_data import Findings, find
from ..runs.simulation import Simulation
from ..scene import DEFAULT_SCENE, Scene, SceneError, parse, shown
from ..scene.effects import Effects
from ..scene.text import read_keys, written
from .engine import FAILED, Item, Row, run_all
from .store import Store
from .sweep_folder import taken
from .variation import REASON, RESULTS, STATUS, Changes, base_of, check, keys_alone, listed, overrides, product

# Keys that may leave mesh and stiffness as they are, in units of the contact.
SCALES = {"title", "load.P", "load.mu", "solid.E0", "solid.y0", "indenter.R", "solver.gamma0", "reference.kind"}
HOLD = "hold"  # checks of a row


class Table(list[Row]):
    """Rows of a sweep, one a scene: the keys that vary, results, errors, checks, seconds, status and reason."""

    def to_csv(self, path: str | Path):
        """A CSV file with a column for each key of any row; truth values and lists as the scene language has them.

        Where all scenes failed, the columns of their results are there too, and empty.
        """
        words = [{n: written(v) if isinstance(v, (bool, list)) else v for n, v in row.items()} for row in self]
        if all(row.get(STATUS) == FAILED for row in self):
            words = [row | dict.fromkeys(RESULTS, "") for row in words]
        write_table(Path(path), words)

    @property
    def failed(self) -> int:
        """Scenes without results."""
        return sum(row[STATUS] != "done" for row in self)

    @property
    def not_held(self) -> int:
        """Scenes whose results fail a check."""
        return sum(row.get("checks", HOLD) != HOLD for row in self)


def sweep(
    scene: str | Path | Scene | Mapping[str, Any] = DEFAULT_SCENE,
    vary: Mapping[str, Sequence] | Sequence[Mapping[str, Any]] = (),
    executor: Executor | None = None,
    output: str | Path | None = None,
    folders: bool = False,
    sets: Sequence[str] = (),
    tell: Callable[[str], None] | None = None,
    overwrite: bool = False,
) -> Table:
    """Run every combination of ``vary`` on ``scene``; SceneError, before anything is run, where the input is wrong.

    scene: TOML text, a file, a Scene, or all its keys; vary: values by key, or a list of changes; executor: of
    processes that share the scenes with this one, for instance a ProcessPoolExecutor that spawns them; output: folder
    in which finished scenes are kept, so that a sweep that was stopped goes on, and with ``folders`` the results of
    each; sets: ``KEY=VALUE`` for all scenes; tell: called with lines of progress; overwrite: replace another sweep in
    ``output``, which is refused otherwise. A scene that fails is a row with its reason.
    """
    text, sets = base_of(scene), tuple(listed("sets", sets, str, "a list of KEY=VALUE"))
    cases = product(vary)
    check(text, sets, cases)
    if output == "" or not isinstance(output, str | PathLike | None):  # "" would be this folder
        raise SceneError(f"output = {shown(output)} is not allowed: the name of a folder")
    if folders and output is None:
        raise SceneError(f"folders = {shown(folders)} is not allowed without output: the name of a folder")
    if isinstance(executor, ThreadPoolExecutor) or not isinstance(executor, Executor | None):
        threads = "PETSc does not run in several threads at once; " if isinstance(executor, Executor) else ""
        words = f"{threads}a ProcessPoolExecutor that spawns is"
        raise SceneError(f"executor = {type(executor).__name__} is not allowed: {words}")
    items = items_of(text, sets, cases, output if folders else None)
    place = nullcontext() if output is None else taken(MPI.COMM_SELF, Path(output), items, overwrite, "output =")
    with place as store:
        return run_sweep(cases, items, store, executor, tell)


def items_of(text: str, sets: tuple[str, ...], cases: list[Changes], folder) -> list[Item]:
    """The run of each checked case; folder: None, or where folders of the runs go."""
    text = keys_alone(read_keys(text))  # comments make no other sweep
    items = []
    for number, changes in enumerate(cases, start=1):
        values = {"text": text, "set": [*sets, *overrides(changes)]}
        if folder is not None:
            # whole, as a process that was there before may work in another folder than this one
            values["folder"] = str(Path(folder).absolute() / RUNS.format(number))
        items.append(Item(", ".join(f"{key} = {value}" for key, value in changes.items()), values))
    return items


def run_sweep(cases: list[Changes], items: list[Item], store: Store | None, executor, tell) -> Table:
    """The table of checked cases and their ``items``; see ``sweep``."""
    if executor is not None:
        compile_forms(items)
    # neighbours in this order may share a body
    order = sorted(range(len(cases)), key=lambda number: _solid(cases[number]))
    try:
        found = run_all([items[number] for number in order], run_scene, store, executor, tell)
    finally:
        _kept.clear()
    rows = dict(zip(order, found, strict=True))
    return Table(cases[number] | _with_status(rows[number]) for number in range(len(cases)))


def _with_status(row: Row) -> Row:
    failed = row.get(FAILED)
    return {STATUS: "done" if failed is None else FAILED, REASON: failed or ""} | ({} if failed else row)


def _solid(changes: Changes) -> str:
    """Cases that may share a body are neighbours when sorted by it; ``Plan.graded_for`` decides."""
    return json.dumps({key: value for key, value in sorted(changes.items()) if key not in SCALES})


_kept: list[Simulation] = []  # the last simulation of this process, whose body the next may take over


def run_scene(values: Row) -> Row:
    """Results of one scene, on this process alone."""
    start = time.perf_counter()
    scene = parse(values["text"], tuple(values["set"]))
    previous = _kept.pop() if _kept else None
    simulation = Simulation(MPI.COMM_SELF, scene, like=previous)
    del previous
    if "folder" in values:
        folder = Path(values["folder"])
        if not has_lost_scene(folder):
            refuse_changed(folder)
        with claimed(MPI.COMM_SELF, folder, overwrite=is_run_of(folder, scene), of_sweep=True):
            begin(folder, scene)
            with Results(folder, simulation, "the same sweep") as results:
                for entry in simulation.run():
                    results.record(entry)
                results.write_tables()
                findings = find(simulation)
                results.end(findings)
            if scene.solver.accuracy is not None:
                results.judge(*judged(simulation, findings.exact))
    else:
        findings = find(simulation.run_to_end())
        if scene.solver.accuracy is not None:
            findings.checks["accuracy"], _ = judged(simulation, findings.exact)
    row = numbers(simulation, findings)
    _kept.append(simulation)
    return row | {"seconds": round(time.perf_counter() - start, 3)}


def compile_forms(items: list[Item]):
    """Compile the forms of all scenes once, before several processes want them at the same time."""
    seen = set()
    for item in items:
        try:
            scene = parse(item.values["text"], tuple(item.values["set"]))
            keys, effects = scene.to_keys(), Effects(scene)
            names = ("mesh.degree", "solid.modulus", "indenter.profile", "solver.theta")
            kind = (*(keys[name] for name in names), np.sign(scene.k), *(v.on for v in effects.verdicts.values()))
            if kind not in seen:
                Simulation(MPI.COMM_SELF, scene)
                seen.add(kind)
        except SceneError:  # a row of the table
            continue


def numbers(simulation: Simulation, findings: Findings) -> Row:
    """What the table says of a finished scene; SI units."""
    history, found, exact = simulation.history, findings.quantities, findings.exact
    row: Row = {"a[m]": found["a"]}
    if history.friction:
        shift = history.entries[-1].surface.delta[0] * simulation.scaled.scales.displacement
        row |= {"c_over_a": found["c_over_a"], "delta_x[m]": shift}
        row |= {"dissipated_energy[J/m]": found["dissipated_energy"]}
    row |= {"indentation[m]": found["indentation"], "peak_pressure[Pa]": found["peak_pressure"]}
    if exact:
        row |= {f"error_{name}": value for name, value in exact.deviations.items() if name in comparison.QUANTITIES}
    row["reference"] = exact.words if exact else findings.why_none
    broken = [name for name, one in findings.checks.items() if not one.holds]
    row |= {"checks": HOLD if not broken else "not held: " + "; ".join(broken)}
    if simulation.warnings:
        row["warnings"] = "; ".join(simulation.warnings)
    row |= {"unknowns": simulation.body.unknowns, "increments": len(history.entries)}
    row["newton_iterations"] = sum(entry.iterations for entry in history.entries)
    return {key: float(value) if isinstance(value, float) else value for key, value in row.items()}
