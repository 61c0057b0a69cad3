"""What accuracy costs: errors against seconds over meshes, settings, methods and ranks:  python -m simulations.studies.cost."""

import argparse
import csv
import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from ..command.command import comm, run, say
from ..scene import SceneError, accuracy
from .costs.cases import Case, cases

MARK = "measured: "  # before the line that a case's own process prints
FIELDS = (
    "study problem level ranks tolerance unknowns surface_nodes increments iterations wall_s cpu_s factorisation_cpu_s "
    "memory_gib pressure traction slip a c dissipated_energy largest failure"
).split()
TEXTS = ("study", "problem", "level", "failure")


def main(arguments: list[str]):
    """Measure what is not in the table yet, each case in a process of its own; then draw the figures."""
    parser = argparse.ArgumentParser(prog="python -m simulations.studies.cost", description=__doc__)
    parser.add_argument(
        "--output", type=Path, default=Path("results/cost"), metavar="DIR", help="folder for cost.csv and figures"
    )
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose name (study/problem/level) contains it")
    parser.add_argument("--list", action="store_true", help="name the cases, and stop")
    parser.add_argument(
        "--peer", action="store_true", help="also GetFEM on the homogeneous loop, where it is installed"
    )
    parser.add_argument(
        "--calibrate", action="store_true", help="renew the table that --accuracy reads from what is measured"
    )
    parser.add_argument("--case", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.case:
        return _one(given.case)
    has_getfem = importlib.util.find_spec("getfem") is not None
    if given.peer and not has_getfem:
        say("GetFEM is not installed (python3-getfem): no peer")
    wanted = [case for case in cases(given.peer and has_getfem) if given.only in case.name]
    if not wanted:
        raise SceneError(f"--only {given.only}: no such case; --list names them")
    if given.list:
        return say("\n".join(case.name for case in wanted))
    from .costs.plots import draw

    given.output.mkdir(parents=True, exist_ok=True)
    path = given.output / "cost.csv"
    done = {name_of(row) for row in read(path)}
    for number, case in enumerate(wanted, start=1):
        if case.name not in done:
            row = _measured_apart(case)
            _append(path, row)
            said = row.get("failure")
            said = said or f"{row['unknowns']} unknowns, {row['cpu_s']:.2f} s CPU, error {row['largest']:.1e}"
            say(f"{number:4d}/{len(wanted)}  {case.name}: {said}")
    rows = read(path)
    if given.calibrate:
        calibrate(rows)
    for figure in draw(rows, given.output):
        say(f"written {figure}")


def read(path: Path) -> list[dict]:
    """Rows of a table, numbers as numbers."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return [{name: _number(name, value) for name, value in row.items()} for row in csv.DictReader(file)]


def name_of(row: dict) -> str:
    """study/problem/level, as of a case."""
    return f"{row['study']}/{row['problem']}/{row['level']}"


def calibrate(rows: list[dict]):
    """Renew ``accuracy.csv`` from the study of fineness: the worse of the two amplitudes, where both were measured."""
    found: dict[tuple[float, float], list[dict]] = {}
    for row in rows:
        if row["study"] in ("fineness", "half load") and not row["failure"]:
            key = Case("", row["problem"], "").k, float(row["level"])
            found.setdefault(key, []).append(row)
    lines = {(m.k, m.fineness): (m.error, m.seconds) for m in accuracy.table()}
    for key, two in found.items():
        if len(two) == 2:
            lines[key] = max(r["largest"] for r in two), max(r["cpu_s"] for r in two)
    with accuracy.TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("k", "fineness", "error", "seconds"))
        writer.writerows(
            (f"{k:g}", f"{t:g}", f"{error:.2e}", f"{seconds:.2f}") for (k, t), (error, seconds) in sorted(lines.items())
        )


def _number(name: str, text: str):
    return text or "" if name in TEXTS or not text else float(text)


def _append(path: Path, row: dict):
    new = not path.exists()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerow({name: f"{v:.6g}" if isinstance(v, float) else v for name, v in row.items()})


def _measured_apart(case: Case) -> dict:
    """The row of a case, measured in a process (or mpirun) of its own."""
    command = [sys.executable, "-m", "simulations.studies.cost", "--case", case.name]
    if case.ranks > 1:
        command = [shutil.which("mpirun"), "-n", str(case.ranks), *command]
    done = subprocess.run(
        command, text=True, capture_output=True, stdin=subprocess.DEVNULL, env=os.environ | {"OMP_NUM_THREADS": "1"}
    )
    row = {
        "study": case.study,
        "problem": case.problem,
        "level": case.level,
        "ranks": case.ranks,
        "tolerance": case.tolerance,
    }
    lines = [line for line in done.stdout.splitlines() if line.startswith(MARK)]
    if lines:
        return row | json.loads(lines[-1].removeprefix(MARK))
    # mpirun may end with a line of nothing but a NUL
    said = [line for line in done.stderr.splitlines() if line.strip("\0 ")]
    return row | {"failure": f"exit code {done.returncode}: {said[-1] if said else 'nothing said'}"[:200]}


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
