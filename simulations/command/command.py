"""What every command shares: reading its command line under MPI, and ending well.

Rank 0 alone reads, checks and speaks. Wrong input ends every rank with exit code 2 and one line; a failed solve or
results that cannot be written with 1; a signal with 128 and its number. Anything unforeseen aborts all ranks, so that
none waits for another.
"""

import argparse
import difflib
import json
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn, TypeVar

from mpi4py import MPI
from petsc4py import PETSc

from ..fem import parallel
from ..loading.stepping import SolveError
from ..output import checkpoint
from ..output.files import OutputError
from ..scene import Scene, SceneError, parse, shown

T = TypeVar("T")
comm = MPI.COMM_WORLD
LARGEST_SCENE = 1_000_000
PROBE = 1 << 18  # bytes that have to fit into the folder for results before a run begins
STOPPING = (signal.SIGTERM, signal.SIGXCPU, signal.SIGUSR1)  # of batch systems whose time limit is near


class Stopped(KeyboardInterrupt):
    """A signal asked the run to end."""

    def __init__(self, number: int):
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.number = number


@dataclass(frozen=True)
class Request:
    """A checked command line: the scene, the folder for results, options for PETSc, and what an earlier run left."""

    scene: Scene
    output: Path
    petsc: tuple[str, ...] = ()
    explain: bool = False
    quiet: bool = False
    saved: checkpoint.Saved | None = None


class Parser(argparse.ArgumentParser):
    """Takes a wrong command line for wrong input: one line, exit code 2."""

    def error(self, message) -> NoReturn:
        raise SceneError(f"{message} (see --help)")


def read_request(arguments: list[str], program: str, description: str | None, default: str) -> Request:
    """The request of a command line; see ``--help``. default: text of the scene that runs when none is named."""
    parser = Parser(prog=f"python -m {program}", description=description, allow_abbrev=False)
    parser.add_argument("scene", nargs="?", type=Path, help="scene file (TOML); without one, the default scene")
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder for results (default: results/SCENE)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key of the scene")
    parser.add_argument("--reference", metavar="KIND", help="what to compare with: auto, closed form, half-plane, none")
    parser.add_argument("--accuracy", metavar="ERROR", help="largest relative error wanted; chooses the mesh")
    parser.add_argument("--explain", action="store_true", help="say which effects are on, and stop")
    parser.add_argument("--resume", type=Path, metavar="DIR", help="go on with the run that was stopped in DIR")
    parser.add_argument("--quiet", action="store_true", help="say nothing but warnings and errors")
    parser.epilog = "Options with a single - go to PETSc, for instance -fretting_snes_monitor or -log_view."
    own, petsc = _split_petsc(arguments, [name for action in parser._actions for name in action.option_strings])
    given = parser.parse_args(own)
    if given.resume is not None:
        others = (given.scene, given.set, given.output, given.explain, given.reference, given.accuracy)
        if any(other is not None and other != [] and other is not False for other in others):
            names = "scene, --output, --set, --reference, --accuracy or --explain"
            raise SceneError(f"--resume takes no {names}: its folder has the scene")
        saved = checkpoint.load(given.resume)
        folder = given.resume if saved.complete else writable(given.resume, "--resume")
        return Request(saved.scene, folder, petsc, False, given.quiet, saved)
    text = default if given.scene is None else _read(given.scene)
    reference = [] if given.reference is None else [f"reference.kind={json.dumps(given.reference)}"]
    accuracy = [] if given.accuracy is None else [f"solver.accuracy={given.accuracy}"]
    scene = parse(text, (*given.set, *reference, *accuracy))
    name = program.rpartition(".")[2] if given.scene is None else given.scene.stem
    output = Path("results") / name if given.output is None else given.output
    return Request(scene, output if given.explain else writable(output), petsc, given.explain, given.quiet)


def _split_petsc(arguments, options):
    """Own arguments, and PETSc's: those that begin with a single -, each with the value that may follow it."""
    own: list[str] = []
    petsc: list[str] = []
    awaits_value = False
    for argument in arguments:
        is_option = argument.startswith("-") and argument[1:2].isalpha() and argument != "-h"
        if is_option and difflib.get_close_matches("-" + argument, options, n=1, cutoff=0.8):
            close = difflib.get_close_matches("-" + argument, options, n=1)[0]
            raise SceneError(f"option {shown(argument)} is not known: did you mean {close}?")
        is_value = awaits_value and not argument.startswith("--") and not argument.endswith(".toml")
        (petsc if is_option or is_value else own).append(argument)
        awaits_value = is_option
    return own, tuple(petsc)


def _read(path: Path) -> str:
    try:
        if path.exists() and not path.is_dir() and not (path.is_file() and path.stat().st_size <= LARGEST_SCENE):
            raise SceneError(f"scene {shown(path)} cannot be read: not a text file of at most {LARGEST_SCENE} bytes")
        return path.read_text(encoding="utf-8-sig")
    except SceneError:
        raise
    except (OSError, ValueError) as error:
        if isinstance(error, UnicodeDecodeError):
            raise SceneError(f"scene {shown(path)} is not TOML: it is not even text") from None
        raise SceneError(f"scene {shown(path)} cannot be read: {getattr(error, 'strerror', error)}") from None


def writable(folder: Path, option: str = "--output") -> Path:
    """``folder``, made where it is missing; SceneError, and nothing left of it, where results cannot be written."""
    try:
        missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
        try:
            folder.mkdir(parents=True, exist_ok=True)
            probe = folder / ".write-test"
            try:
                with open(probe, "wb") as file:
                    file.write(bytes(PROBE))
                    file.flush()
                    os.fsync(file.fileno())
            finally:
                probe.unlink(missing_ok=True)
        except (OSError, ValueError):
            for parent in missing:
                if parent.is_dir():
                    parent.rmdir()
            raise
    except (OSError, ValueError) as error:
        raise SceneError(f"{option} {shown(folder)} cannot be written: {getattr(error, 'strerror', error)}") from None
    return folder


def on_root(work: Callable[[], T]) -> T:
    """Result of ``work`` done by rank 0, or what is wrong with its input raised on every rank."""
    return parallel.on_root(comm, work, (SceneError, SystemExit))


def set_petsc_options(options: tuple[str, ...]):
    """Hand a command line's options to PETSc, which names those that nothing asked for when it ends."""
    PETSc.Options().insertString(" ".join(options))
    if any(option.startswith("-log_view") for option in options):
        PETSc.Log.begin()


def run(main: Callable[[list[str]], None]):
    """Run a command's ``main(arguments)`` and exit as its kind of ending asks."""
    _listen()
    code: int | str = 0
    try:
        main(sys.argv[1:])
    except SystemExit as end:
        code = end.code or 0
    except SceneError as error:
        say(str(error), file=sys.stderr)
        code = 2
    except SolveError as error:
        say(f"not converged: {error}", file=sys.stderr)
        code = 1
    except OutputError as error:
        say(str(error), file=sys.stderr)
        code = 1
    except KeyboardInterrupt as stop:  # the ranks are not in step: none can wait for another
        _abort(128 + (stop.number if isinstance(stop, Stopped) else signal.SIGINT))
    except BaseException:
        traceback.print_exc()
        _abort(1)
    comm.Barrier()  # mpirun ends the others as soon as one rank exits with a code
    sys.exit(code)


def _abort(code):
    if comm.size == 1:
        sys.exit(code)
    comm.Abort(code)


def _listen():
    """Signals end the run where it can say so; warnings come once, in one line, from rank 0."""

    def stop(number, frame):
        raise Stopped(number)

    for number in STOPPING:
        signal.signal(number, stop)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)  # which PETSc would take for a crash
    said = set()

    def show(message, category, *where, **more):
        if str(message) not in said:
            said.add(str(message))
            say(f"warning: {message}", file=sys.stderr)

    warnings.showwarning = show


def say(*words, file=None, **options):
    """Print on rank 0. Where nobody can listen any more (a closed pipe, a full disk) the run goes on silently."""
    if comm.rank == 0:
        stream = file or sys.stdout
        try:
            print(*words, file=stream, flush=True, **options)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
