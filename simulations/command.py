"""What every command shares: reading its command line under MPI, and ending well.

Rank 0 alone reads, checks and speaks. Wrong input ends every rank with exit code 2 and one line; a failed
solve with 1; anything unforeseen aborts all ranks, so that none waits for another.
"""

import argparse
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from mpi4py import MPI
from petsc4py import PETSc

from .programme import SolveError
from .language import SceneError
from .scene import Scene, parse

T = TypeVar("T")
comm = MPI.COMM_WORLD


@dataclass(frozen=True)
class Request:
    """A checked command line: the scene, the folder for results, and options for PETSc."""

    scene: Scene
    output: Path
    petsc: tuple[str, ...]
    explain: bool


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise SceneError(f"{message} (see --help)")


def read_request(arguments: list[str], program: str, description: str, default: str) -> Request:
    """The request of a command line ``[SCENE.toml] [--output DIR] [--set KEY=VALUE] [--explain] [-petsc_option ...]``.

    default: text of the scene that runs when none is named.
    """
    parser = _Parser(prog=f"python -m {program}", description=description, allow_abbrev=False)
    parser.add_argument("scene", nargs="?", type=Path, help="scene file (TOML); without one, the default scene")
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder for results (default: results/SCENE)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key of the scene")
    parser.add_argument("--accuracy", metavar="ERROR", help="largest relative error wanted; chooses the mesh")
    parser.add_argument("--explain", action="store_true", help="say which effects are on, and stop")
    parser.epilog = "Options that begin with -fretting_ go to PETSc, for instance -fretting_snes_monitor."
    own, petsc = _split_petsc(arguments)
    given = parser.parse_args(own)
    text = default if given.scene is None else _read(given.scene)
    accuracy = () if given.accuracy is None else (f"solver.accuracy={given.accuracy}",)
    scene = parse(text, (*given.set, *accuracy))
    name = program.rpartition(".")[2] if given.scene is None else given.scene.stem
    output = given.output or Path("results") / name
    return Request(scene, output if given.explain else _writable(output), petsc, given.explain)


def _split_petsc(arguments):
    """Own arguments, and PETSc's: those that begin with -fretting_, each with the value that may follow it."""
    own, petsc = [], []
    awaits_value = False
    for argument in arguments:
        is_option = argument.startswith("-fretting_")
        is_value = awaits_value and not argument.startswith("--") and not argument.endswith(".toml")
        (petsc if is_option or is_value else own).append(argument)
        awaits_value = is_option
    return own, tuple(petsc)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise SceneError(f"scene {path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SceneError(f"scene {path} is not TOML: it is not even text") from None


def _writable(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".write-test"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise SceneError(f"--output {folder} cannot be written: {error.strerror}") from None
    return folder


def on_root(work: Callable[[], T]) -> T:
    """Result of ``work`` done by rank 0, or its exception raised on every rank."""
    result = failure = None
    if comm.rank == 0:
        try:
            result = work()
        except (SceneError, SystemExit) as problem:
            failure = problem
    result, failure = comm.bcast((result, failure))
    if failure is not None:
        raise failure
    return result


def set_petsc_options(options: tuple[str, ...]):
    """Hand a command line's PETSc options to PETSc."""
    PETSc.Options().insertString(" ".join(options))


def run(main: Callable[[list[str]], None]):
    """Run a command's ``main(arguments)`` and exit as its kind of ending asks."""
    try:
        main(sys.argv[1:])
        code = 0
    except SystemExit as end:
        code = end.code or 0
    except SceneError as error:
        say(str(error), file=sys.stderr)
        code = 2
    except SolveError as error:
        say(f"not converged: {error}", file=sys.stderr)
        code = 1
    except KeyboardInterrupt:
        comm.Abort(130)
    except BaseException:
        traceback.print_exc()
        comm.Abort(1)
    comm.Barrier()  # mpirun ends the others as soon as one rank exits with a code
    sys.exit(code)


def say(*words, file=None, **options):
    """Print on rank 0."""
    if comm.rank == 0:
        print(*words, file=file or sys.stdout, flush=True, **options)
