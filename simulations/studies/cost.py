"""What accuracy costs: errors against seconds over meshes, settings, methods and ranks:

    python -m simulations.studies.cost
"""

import importlib.util
import json
import math
from argparse import SUPPRESS, Namespace
from dataclasses import asdict
from pathlib import Path

from ..command.command import comm, on_root, run, say
from ..output.files import on_disk, rows_of, write_table
from ..scene import SceneError, accuracy, shown
from .commandline import make_folders, study_parser
from .costs import sweeps
from .costs.cases import COUPLED, Case, cases
from .engine import Item, Row, run_all
from .store import Store

MARK = "measured: "  # before the line that a case's own process prints
ADOPTED = "adopted"  # key of a row that was in the table before
NAMED = ("study", "problem", "level", "ranks", "tolerance")  # fields of a case, known before it is measured
FIELDS = (
    *NAMED,
    *"unknowns surface_nodes increments iterations wall_s cpu_s factorisation_cpu_s "
    "memory_gib pressure traction slip a c dissipated_energy largest largest_of_states "
    "pressure_of_states traction_of_states slip_of_states failure".split(),
)
TEXTS = ("study", "problem", "level", "failure")


def main(arguments: list[str]):
    """Measure what is not measured yet, each case in a process of its own; then write table and figures."""
    given = on_root(lambda: read(arguments))
    if given.case:
        _one(given.case)
        return
    if comm.rank > 0:  # one case at a time, with the machine for itself
        return
    if given.list:
        say("\n".join(case.name for case in given.cases))
        return
    from .costs.plots import draw

    path, store = given.output / "cost.csv", Store(given.output / "cost.jsonl")
    adopt(path, store)
    run_all([item_of(case) for case in given.cases], measured_apart, store, tell=say)
    kept = store.read()
    everything = [(case, kept.get(item_of(case).key)) for case in cases()]
    write_rows(path, [{name: getattr(case, name) for name in NAMED} | row for case, row in everything if row])
    rows = read_rows(path)
    if given.calibrate:
        measured = {case.name for case, row in everything if row is not None and not row.get(ADOPTED)}
        calibrate([row for row in rows if name_of(row) in measured])
    for figure in draw(rows, given.output):
        say(f"written {figure}")


def read(arguments: list[str]) -> Namespace:
    """The checked command line with its ``cases``; SceneError where it is wrong."""
    parser = study_parser("cost", __doc__, "results/cost")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose name (study/problem/level) contains it")
    parser.add_argument("--list", action="store_true", help="name the cases, and stop")
    parser.add_argument("--peer", action="store_true", help="also GetFEM on the homogeneous loop, if it is installed")
    parser.add_argument("--calibrate", action="store_true", help="renew the table that --accuracy reads")
    parser.add_argument("--case", help=SUPPRESS)
    given = parser.parse_args(arguments)
    has_getfem = importlib.util.find_spec("getfem") is not None
    if given.peer and not has_getfem:
        say("GetFEM is not installed (python3-getfem): no peer")
    given.cases = [case for case in cases(given.peer and has_getfem) if given.only in case.name]
    if not given.cases:
        raise SceneError(f"--only {shown(given.only)} is not allowed: a part of a name that --list shows")
    if not (given.case or given.list):
        make_folders(given)
    return given


def item_of(case: Case) -> Item:
    """The case for the engine."""
    return Item(case.name, asdict(case))


def adopt(path: Path, store: Store):
    """A table without its store, as docs/cost has it, counts as measured: all of its rows, or none after a stop."""
    if store.path.exists() or not path.exists():
        return
    known = {case.name: case for case in cases()}
    with on_disk(store.path) as partial:
        partial.write_bytes(b"")
        for row in read_rows(path):
            if case := known.get(name_of(row)):
                measured = {name: value for name, value in row.items() if value != "" and name not in NAMED}
                item = item_of(case)
                Store(partial).keep(item.key, item.values, measured | {ADOPTED: True})


def name_of(row: Row) -> str:
    """That of the case that a row of the table is of."""
    return f"{row['study']}/{row['problem']}/{row['level']}"


def read_rows(path: Path) -> list[Row]:
    """Rows of a table, numbers as numbers."""
    rows: list[Row] = [*rows_of(path)]
    for row in rows:
        row |= {name: float(text) for name, text in row.items() if text and name not in TEXTS}
    return rows


def calibrate(rows: list[dict]):
    """Renew lines of ``accuracy.csv`` from the study of fineness: the worse of two amplitudes, if both are in ``rows``.

    The other lines stay.
    """
    found: dict[tuple[bool, float, float], list[dict]] = {}
    for row in rows:
        if row["study"] in ("fineness", "half load") and not row["failure"]:
            key = row["problem"] in COUPLED, Case("", row["problem"], "").k, float(row["level"])
            found.setdefault(key, []).append(row)
    lines = {(m.coupled, m.k, m.fineness): (m.error, m.last, m.seconds) for m in accuracy.table()}
    for key, two in found.items():
        if len(two) == 2:
            states = max(r.get("largest_of_states") or math.nan for r in two)
            lines[key] = states, max(r["largest"] for r in two), max(r["cpu_s"] for r in two)
    table = []
    for (coupled, k, t), (states, last, seconds) in sorted(lines.items()):
        row = {"coupled": int(coupled), "k": f"{k:g}", "fineness": f"{t:g}"}
        row |= {"error": "" if math.isnan(states) else f"{states:.2e}", "last": f"{last:.2e}"}
        table.append(row | {"seconds": f"{seconds:.2f}"})
    write_table(accuracy.TABLE, table)


def write_rows(path: Path, rows: list[Row]):
    """The table, numbers to six digits."""
    texts = [{n: f"{v:.6g}" if isinstance(v, float) else v for n, v in row.items()} for row in rows]
    write_table(path, [{name: row.get(name, "") for name in FIELDS} for row in texts])


def measured_apart(values: Row) -> Row:
    """The row of a case, measured in a process (or mpirun) of its own."""
    case = Case(**values)
    if case.study == "sweep":
        return sweeps.measure(case)
    done = sweeps.run_apart(case.ranks, "simulations.studies.cost", "--case", case.name)
    lines = [line for line in done.stdout.splitlines() if line.startswith(MARK)]
    if lines:
        row = json.loads(lines[-1].removeprefix(MARK))
        if row.get("failure"):
            raise RuntimeError(row["failure"])
        numbers = f"{row['cpu_s']:.2f} s CPU" + (f", error {row['largest']:.1e}" if "largest" in row else "")
        say(f"{case.name}: {numbers}")
        return row
    # mpirun may end with a line of nothing but a NUL
    said = [line for line in done.stderr.splitlines() if line.strip("\0 ")]
    raise RuntimeError(f"exit code {done.returncode}: {said[-1] if said else 'nothing said'}"[:200])


def _one(name: str):
    (case,) = (case for case in cases() if case.name == name)
    if case.problem == "GetFEM":
        from .costs.getfem import measure
    else:
        from .costs.model import measure
    row = measure(case)
    if comm.rank == 0:
        print(MARK + json.dumps(row), flush=True)


if __name__ == "__main__":
    run(main)
