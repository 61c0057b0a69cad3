"""The command line of a run: read and checked before anything is solved or written."""

import argparse
import difflib
import json
import os
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from petsc4py import PETSc

from ..output import checkpoint
from ..output.folder import refuse_changed
from ..scene import Scene, SceneError, one_line, parse, shown
from ..scene.text import read_text
from ..solvers.bulk_solver import bulk_solver
from ..solvers.newton import read_options
from ..version import __version__

EPILOG = """\
A folder that holds a run is not written into: --resume DIR goes on with that run, --overwrite replaces it, and while a
run is going on nobody else gets its folder. Files that no run wrote are never replaced.
Options with a single - go to PETSc, for instance -fretting_snes_monitor or -log_view.

exit code: 0 done, and all checks of the results hold; 2 wrong input, nothing was run; 3 no solution was found;
4 the run is done, but checks of its results fail; 5 results cannot be written; 1 an error of the program itself;
128 + N stopped by signal N (130 Ctrl-C, 143 kill), with the command that goes on; mpirun itself stopped: 1
"""


@dataclass(frozen=True)
class Request:
    """A checked command line: the scene, the folder for results, options for PETSc, and the command itself."""

    scene: Scene
    output: Path
    command: str
    scene_file: Path | None
    petsc: tuple[str, ...]
    explain: bool
    quiet: bool
    resume: bool = False
    overwrite: bool = False


class Parser(argparse.ArgumentParser):
    """Takes a wrong command line for wrong input: one line, exit code 2. Knows --version; no path is empty."""

    def __init__(self, prog: str, description: str | None, epilog: str = ""):
        as_written = argparse.RawDescriptionHelpFormatter  # a command in a description keeps its own line
        super().__init__(prog, None, description, epilog, formatter_class=as_written, allow_abbrev=False)
        self.register("type", Path, _path)
        self.add_argument("--version", action="version", version=f"graded-fretting {__version__}")

    def error(self, message) -> NoReturn:
        raise SceneError(f"{message} (see --help)")


def _path(text: str) -> Path:
    """Path("") would be this folder, and an unset variable of the shell leaves the empty text."""
    if not text:
        raise argparse.ArgumentTypeError("'' is not allowed: the name of a file or folder")
    return Path(text)


def read_request(arguments: list[str], program: str, description: str | None, default: str) -> Request:
    """The request of a command line; see ``--help``. default: text of the scene that runs when none is named."""
    parser = _parser(program, description)
    own, petsc = _split_petsc(arguments, [name for action in parser._actions for name in action.option_strings])
    given = parser.parse_args(own)
    command = command_line(program, *arguments)
    if given.resume is not None:
        if vars(given) != vars(parser.parse_args([])) | {"resume": given.resume, "quiet": given.quiet}:
            names = "scene, --output, --set, --reference, --accuracy, --explain or --overwrite"
            raise SceneError(f"--resume takes no {names}: its folder has the scene")
        if (given.resume / checkpoint.SCENE).is_file():
            refuse_changed(given.resume)
        scene = checkpoint.read_scene(given.resume)
        return Request(scene, given.resume, command, None, petsc, False, given.quiet, resume=True)
    text = default if given.scene is None else read_text(given.scene, "scene")
    if given.scene is None:
        _check_values(petsc)
    reference = [] if given.reference is None else [f"reference.kind={json.dumps(given.reference)}"]
    accuracy = [] if given.accuracy is None else [f"solver.accuracy={given.accuracy}"]
    called = "the scene" if given.scene is None else f"scene {shown(given.scene)}"
    scene = parse(text, (*given.set, *reference, *accuracy), called)
    name = program.rpartition(".")[2] if given.scene is None else given.scene.stem
    output = Path("results") / name if given.output is None else given.output
    return Request(
        scene, output, command, given.scene, petsc, given.explain, given.quiet, overwrite=given.overwrite
    )


def command_line(program: str, *words: str) -> str:
    """What to type for a command: by docker/run, where that has started this one."""
    around = os.environ.get("GRADED_FRETTING_RUN")
    return shlex.join([*([around] if around else []), "python", "-m", program, *words])


def set_petsc_options(options: tuple[str, ...]):
    """Hand a command line's options to PETSc, which names those that nothing asked for when it ends. SceneError, before
    anything is solved, where it cannot read them.
    """
    try:
        PETSc.Options().insertString(" ".join(options))
        read_options(PETSc.SNES().create(PETSc.COMM_SELF))
        smallest = PETSc.Mat().createAIJ(1, nnz=1, comm=PETSc.COMM_SELF)
        smallest.setValue(0, 0, 1.0)
        smallest.assemble()
        bulk_solver(smallest, "lu")  # MUMPS reads its options when it factorises
    except PETSc.Error as error:
        why = str(error).rpartition("] ")[2]  # below the functions that it came through
        raise SceneError(f"PETSc's options {shown(' '.join(options))} are not allowed: {one_line(why)}") from None
    if "log_view" in PETSc.Options():  # also from a file of options
        _, _, file = PETSc.Options().getString("log_view", "").partition(":")
        place = Path(file.partition(":")[0])  # PETSc opens it once the run is done, and then may only complain
        if not place.absolute().parent.is_dir():
            PETSc.Options().delValue("log_view")
            raise SceneError(f"-log_view: {shown(place)} cannot be written: there is no such folder")
        PETSc.Log.begin()


def _parser(program, description):
    parser = Parser(prog=f"python -m {program}", description=description, epilog=EPILOG)
    parser.add_argument("scene", nargs="?", type=Path, help="scene file (TOML); without one, the default scene")
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder for results (default: results/SCENE)")
    parser.add_argument("--overwrite", action="store_true", help="replace the run that the folder for results holds")
    parser.add_argument("--resume", type=Path, metavar="DIR", help="go on with the run that was stopped in DIR")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key of the scene")
    parser.add_argument("--reference", metavar="KIND", help="what to compare with: auto, closed form, half-plane, none")
    parser.add_argument("--accuracy", metavar="ERROR", help="largest relative error wanted; chooses the mesh")
    parser.add_argument("--explain", action="store_true", help="say which effects are on, and stop")
    parser.add_argument("--quiet", action="store_true", help="say nothing but warnings and errors")
    return parser


def _split_petsc(arguments, options):
    """Own arguments, and PETSc's: those that begin with a single -, each with the value that may follow it."""
    own: list[str] = []
    petsc: list[str] = []
    awaits_value = False
    for argument in arguments:
        is_option = argument.startswith("-") and argument[1:2].isalpha() and argument != "-h"
        begun = [name for name in options if len(argument) == 2 and name.startswith("-" + argument)]
        if is_option and (close := begun or difflib.get_close_matches("-" + argument, options, n=1, cutoff=0.8)):
            raise SceneError(f"option {shown(argument)} is not known: did you mean {close[0]}?")
        is_value = awaits_value and not argument.startswith("--") and not argument.endswith(".toml")
        (petsc if is_option or is_value else own).append(argument)
        awaits_value = is_option
    return own, tuple(petsc)


def _check_values(petsc):
    """SceneError for a file that PETSc would get as the value of an option: a scene without a name in .toml."""
    for option, value in zip(petsc, petsc[1:]):
        if not value.startswith("-") and not option.startswith("-options_file") and Path(value).is_file():
            raise SceneError(f"scene {shown(Path(value))} stands after the PETSc option {shown(option)}: put it first")
