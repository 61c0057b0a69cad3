"""The folder of a run: whose it is, what may be replaced in it, and how a new run begins there.

A folder that holds a run is not written into, but to go on with that run or where its replacement is asked for. A file
that no run wrote is never replaced.
"""

import hashlib
import os
import platform
import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

import dolfinx
import gmsh
import numpy as np
from petsc4py import PETSc

from ..fem.parallel import on_root
from ..scene import Scene, SceneError, shown
from ..version import __version__
from . import checkpoint, field_index, lines
from .checkpoint import SCENE, read_summary
from .files import OutputError, write_text
from .lock import Lock

MOVED = Path("/opt/stack/moved.txt")  # of the image: packages whose recorded version the archive no longer had
FILES = (SCENE, "history.csv", "surface.h5", field_index.XDMF, field_index.VTKHDF, "summary.json", "fretting.png")
REPORT = "report.html"
SWEEP = "sweep.jsonl", "sweep.csv"  # of a sweep: finished runs, and their table
RUNS, ANY_RUN = "run-{:04d}", "run-[0-9]*"  # folder of one of its scenes by its number, and of any
RUN = r"run-\d{4,}"  # the names that RUNS makes
BODY = "body.pdf", "body.png", "body.gif"  # of studies.body_stress
OTHERS = (lines.NAME, REPORT, *BODY)  # where they are asked for
FOLDERS = (checkpoint.FOLDER, field_index.FOLDER)
PROBE = 1 << 18  # bytes that have to fit into the folder before a run begins
HEADER, CHECKSUM = "# graded-fretting ", "# checksum "  # lines of a scene.toml that a run wrote


def files(folder: Path) -> tuple[str, ...]:
    """What a finished run has written."""
    asked_for = [lines.NAME] if (folder / lines.NAME).exists() else []
    return (*FILES, *asked_for, f"{field_index.FOLDER}/")


def versions() -> dict[str, str]:
    """What the numbers were made with; packages of the image that are not the recorded ones too."""
    found = {
        "graded-fretting": __version__,
        "python": platform.python_version(),
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "gmsh": gmsh.__version__,
        "numpy": np.__version__,
    }
    if MOVED.is_file():
        for line in MOVED.read_text(encoding="utf-8").splitlines():
            package, recorded, installed = line.split()
            found[package] = f"{installed} (recorded: {recorded})"
    return found


@contextmanager
def claimed(
    comm, folder: Path, scene_file: Path | None = None, overwrite=False, resume=False, of_sweep=False
) -> Iterator[None]:
    """``folder`` locked for one run, on every rank; SceneError where it may not be written.

    scene_file: the user's, which stays as it is; of_sweep: whether the run is a scene of the sweep in the folder above.
    Nothing is left of a folder in which no run began.
    """
    with ExitStack() as held:
        on_root(comm, lambda: _claim(held, folder, scene_file, overwrite, resume, of_sweep), SceneError)
        yield


def _claim(held: ExitStack, folder: Path, scene_file: Path | None, overwrite: bool, resume: bool, of_sweep: bool):
    """Take the folder until ``held`` ends; nothing is left of a run that was killed while it wrote a file."""
    held.callback(remove_empty, [] if resume else _missing(folder))
    held.callback(locked(folder, "--resume" if resume else "--output").release)
    if not resume:
        _refuse(folder, scene_file, overwrite, of_sweep)
    own = (*FILES, lines.NAME, checkpoint.MEMORY)
    for path in (folder, *(folder / name for name in FOLDERS)):
        for partial in path.glob("part.*"):
            if partial.name.removeprefix("part.") in own or path.name == field_index.FOLDER:
                partial.unlink()


def begin(folder: Path, scene: Scene):
    """Make a claimed ``folder`` that of a new run: nothing of an earlier one, and the scene.

    The scene of an earlier run goes last, in the moment in which the new one takes its place: a folder is always that
    of one run. OutputError where it cannot be written.
    """
    try:
        _remove_results(folder)
        text = scene.to_toml()
        made_with = "".join(f"# {name} {version}\n" for name, version in versions().items())
        write_text(folder / SCENE, f"{made_with}{CHECKSUM}{_checksum(text)}\n{text}")
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {error.strerror or error}; start again") from None


def go_on(folder: Path):
    """Take away report and summary of a run that is about to go on: they say that it did not reach its end. A report
    made meanwhile, or after a SIGKILL, would mix that summary with later tables.
    """
    try:
        for name in (REPORT, "summary.json"):
            (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {error.strerror or error}; then --resume goes on") from None


def remove_run(folder: Path):
    """Take away the run in ``folder``, if there is one, and the folder with it where nothing else is in it.

    Also the results of a run that has lost its scene, as an empty file is. Locked where the run is going on.
    """
    is_of_a_run = "graded-fretting" in str(read_summary(folder).get("versions"))
    if _is_of_a_run(folder / SCENE) or (has_lost_scene(folder) and is_of_a_run):
        lock = Lock(folder)
        try:
            _remove_results(folder)
            (folder / SCENE).unlink(missing_ok=True)
        finally:
            lock.release()
        remove_empty((folder / field_index.FOLDER, folder))


def has_lost_scene(folder: Path) -> bool:
    """Whether there is no scene in ``folder``, or an empty one, which a power cut leaves."""
    return not (folder / SCENE).exists() or not (folder / SCENE).read_bytes().strip(b"\0 \n")


def _remove_results(folder):
    """All that a run has written but its scene; first what tells that it is complete."""
    (folder / "summary.json").unlink(missing_ok=True)
    checkpoint.remove(folder)
    for name in (*FILES[1:], *OTHERS):
        (folder / name).unlink(missing_ok=True)
    for path in _state_files(folder):
        path.unlink()


def refuse_changed(folder: Path):
    """SceneError where the scene in ``folder`` is not as the run wrote it: what else is there is not of this scene."""
    if not _is_of_a_run(folder / SCENE):
        why = "is not as the run wrote it; it was changed afterwards, and the results are of another scene"
        raise SceneError(f"{shown(folder)}: {SCENE} {why}")


def is_run_of(folder: Path, scene: Scene) -> bool:
    """Whether a run wrote what is in ``folder``, and of this scene."""
    return _is_of_a_run(folder / SCENE) and checkpoint.read_scene(folder).to_toml() == scene.to_toml()


def is_whole(folder: Path) -> bool:
    """Whether ``folder`` holds a run that reached its end, with its scene as the run wrote it and its tables."""
    return not lost_table(folder) and _is_of_a_run(folder / SCENE) and checkpoint.is_complete(folder)


def lost_table(folder: Path) -> str:
    """The first table that is missing of a run that reached its end; "" for none."""
    return next((name for name in ("history.csv", "surface.h5") if not (folder / name).exists()), "")


def lost_file(folder: Path) -> str:
    """The first file that is missing of a run that has ended, well or not; "" for none.

    The picture is made at the end alone, and the fields with their indices where states are kept.
    """
    names, indices = [SCENE, "history.csv", "surface.h5", "summary.json"], [field_index.XDMF, field_index.VTKHDF]
    if checkpoint.is_complete(folder):
        names.append("fretting.png")
    kept = [path for path in _state_files(folder) if path.name != field_index.MESH]
    if kept or any((folder / name).exists() for name in indices):
        names += indices
    if (folder / field_index.XDMF).exists():
        names += field_index.files_of((folder / field_index.XDMF).read_text(encoding="utf-8", errors="replace"))
    return next((name for name in names if not (folder / name).exists()), "")


def locked(folder: Path, option: str = "--output") -> Lock:
    """The lock of ``folder``, which is made; SceneError where that cannot be, or where another process has it."""
    made = writable(folder, option)
    try:
        return Lock(folder)
    except OSError as error:
        remove_empty(made)
        raise SceneError(f"{option} {shown(folder)} cannot be written: {error.strerror}") from None


def writable(folder: Path, option: str = "--output") -> list[Path]:
    """Make ``folder`` where it is missing; SceneError, and nothing left of it, where results cannot be written.

    Returns the folders that were made.
    """
    missing = _missing(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder) as probe:
            probe.write(bytes(PROBE))
            probe.flush()
            os.fsync(probe.fileno())
    except (OSError, ValueError) as error:
        remove_empty(missing)
        why = getattr(error, "strerror", error)
        if isinstance(error, FileExistsError):
            place = Path(error.filename)
            why = f"{shown(place)} is {'a link to what is not there' if place.is_symlink() else 'a file'}, not a folder"
        raise SceneError(f"{option} {shown(folder)} cannot be written: {why}") from None
    return missing


def _missing(folder):
    """The folder and its parents, as far as they are not there."""
    # os.path, as pathlib raises for a name that is too long
    return [place for place in (folder, *folder.parents) if not os.path.exists(place)]


def remove_empty(folders: Iterable[Path]):
    """Remove the folders that hold nothing, in this order."""
    for folder in folders:
        with suppress(OSError, ValueError):
            folder.rmdir()


def _refuse(folder: Path, scene_file: Path | None, overwrite: bool, of_sweep: bool):
    """SceneError where a run in ``folder`` would replace something that it must not."""
    start = f"--output {shown(folder)} is not allowed: "
    sweep = next((name for name in SWEEP if (folder / name).exists()), None)
    if sweep:
        raise SceneError(f"{start}it holds {sweep}, of a sweep; choose another folder")
    place = folder.resolve()
    if not of_sweep and re.fullmatch(RUN, place.name) and (place.parent / SWEEP[0]).exists():
        raise SceneError(f"{start}it is a scene's folder of the sweep around it; choose another folder")
    names = [name for name in (*FILES, *OTHERS, checkpoint.FOLDER) if (folder / name).exists()]
    names += [field_index.FOLDER + "/"] if any(True for _ in _state_files(folder)) else []
    if not names:
        return
    if scene_file and (folder / SCENE).exists() and os.path.samefile(scene_file, folder / SCENE):
        raise SceneError(f"{start}the scene {shown(scene_file)} is in it, under a name of a run's own; choose another")
    stranger = None if _is_of_a_run(folder / SCENE) else SCENE if (folder / SCENE).exists() else names[0]
    if stranger:
        raise SceneError(f"{start}it holds {stranger}, which is not as a run wrote it; choose another folder")
    if overwrite:
        return
    where = shlex.quote(str(folder))
    if checkpoint.is_complete(folder):
        raise SceneError(f"{start}it holds a finished run; --overwrite replaces it, --output DIR keeps both")
    raise SceneError(f"{start}it holds a run that was stopped; go on with --resume {where}, or replace it: --overwrite")


def _state_files(folder):
    return (p for p in (folder / field_index.FOLDER).glob("*.h5") if re.fullmatch(r"\d{6,}|mesh", p.stem))


def _is_of_a_run(path: Path) -> bool:
    """Whether a run wrote this scene.toml, and nobody has changed it."""
    try:
        written = path.read_text(encoding="utf-8").splitlines(keepends=True)
    except (OSError, UnicodeDecodeError):
        return False
    if not written or not written[0].startswith(HEADER):
        return False
    kept = [line.removeprefix(CHECKSUM).strip() for line in written if line.startswith(CHECKSUM)]
    return kept == [_checksum("".join(line for line in written if not line.startswith("# ")))]


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
