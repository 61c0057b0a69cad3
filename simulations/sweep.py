"""Run a scene for many values of its keys, and make one table:

    mpirun -n 2 python -m simulations.sweep SCENE.toml --vary solid.k=-0.5:0.9:15 --vary load.amplitude=0.1,0.5,0.9

Every rank solves scenes of its own. What is finished is kept in the folder: the same command goes on where it was.
"""

import sys
from argparse import Namespace
from pathlib import Path
from types import ModuleType

from .command.arguments import Parser
from .command.command import NO_SOLUTION, comm, on_root, run, say
from .runs.checks import ChecksFailed
from .scene import DEFAULT_SCENE, SceneError, shown
from .scene.text import read_keys, read_text
from .studies.engine import workers
from .studies.sweep_folder import TABLE, taken
from .studies.sweeping import Table, items_of, run_sweep, sweep
from .studies.variation import check, product, read_table, read_vary


def main(arguments: list[str]):
    """Run all scenes and write sweep.csv; exit code 3 where some of them failed, else 4 where checks of some do."""
    given = on_root(lambda: read(arguments))
    table = Table()
    tell = (lambda line: None) if given.quiet else say
    place = taken(comm, given.output, given.items, given.overwrite)
    with place as store, workers(comm) as executor:
        if comm.rank == 0:
            tell(f"{len(given.cases)} scenes on {comm.size} rank(s)")
            table = run_sweep(given.cases, given.items, store, executor, tell)
            table.to_csv(given.output / TABLE)
    failed, not_held = comm.bcast((table.failed, table.not_held))
    tell(f"written to {given.output}: {TABLE}, {len(table)} rows")
    of_all = f"of {len(given.cases)} scenes"
    if failed:
        say(f"{failed} {of_all} failed: see status and reason in {TABLE}", file=sys.stderr)
        raise SystemExit(NO_SOLUTION)
    if not_held:
        raise ChecksFailed(f"{not_held} {of_all} fail their checks: see checks in {TABLE}")


def read(arguments: list[str]) -> Namespace:
    """The checked command line with ``cases`` and ``items``; SceneError where anything is wrong."""
    parser = Parser(prog="python -m simulations.sweep", description=__doc__)
    parser.add_argument("scene", nargs="?", type=Path, help="scene file (TOML); without one, the default scene")
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=VALUES",
        help="FIRST:LAST:COUNT, or VALUE,VALUE,...; all combinations of several",
    )
    parser.add_argument("--csv-in", type=Path, metavar="FILE", help="scenes from a table whose columns are keys")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key of all scenes")
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder (default: results/sweep-SCENE)")
    parser.add_argument("--folders", action="store_true", help="also the results folder of every scene")
    parser.add_argument("--overwrite", action="store_true", help="replace another sweep in the folder")
    parser.add_argument("--quiet", action="store_true", help="say nothing but warnings and errors")
    given = parser.parse_args(arguments)
    if not (given.vary or given.csv_in):
        raise SceneError("nothing varies: --vary KEY=FIRST:LAST:COUNT, --vary KEY=VALUE,VALUE,... or --csv-in FILE")
    given.text = DEFAULT_SCENE if given.scene is None else read_text(given.scene, "scene")
    read_keys(given.text, f"scene {shown(given.scene)}")
    given.sets = tuple(given.set)
    rows = read_table(given.csv_in) if given.csv_in else [{}]
    given.cases = product(read_vary(given.vary), rows)
    check(given.text, given.sets, given.cases)
    name = "default" if given.scene is None else given.scene.stem
    given.output = given.output or Path("results") / f"sweep-{name}"
    given.items = items_of(given.text, given.sets, given.cases, given.output if given.folders else None)
    return given


class _Command(ModuleType):
    """This module once imported is also what ``from simulations import sweep`` finds: it can be called like it."""

    def __call__(self, *arguments, **options):
        return sweep(*arguments, **options)


sys.modules[__name__].__class__ = _Command

if __name__ == "__main__":
    run(main)
