"""Checkpoint of a run: the states so far and the memory that the next load step needs, for going on after a kill.

Two files in ``checkpoint/``. ``states.bin`` has a record of fixed size for every load step, each written once at its
own place; ``memory.npz`` is replaced whole after every load step and says how many records count, with the checksum of
each. Whatever was half written when the run ended is overwritten by the run that goes on.
"""

import io
import json
import os
import shutil
import zipfile
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ..fem.mesh import Grading
from ..fem.surface import SurfaceState
from ..loading import present_state
from ..loading.stepping import Outcome
from ..runs.history import Entry
from ..runs.plan import Plan
from ..runs.simulation import Simulation
from ..runs.timing import Stopwatch
from ..scene import Scene, SceneError, one_line, parse, shown
from ..solvers.newton import NewtonResult
from ..version import __version__
from .fields import first_lost
from .files import on_disk

FOLDER, STATES, MEMORY, SCENE = "checkpoint", "states.bin", "memory.npz", "scene.toml"
AGAIN = "start again, in another folder or with --overwrite"
SURFACE = ("pressure", "traction", "u", "delta", "neglected", "elastic")  # of a SurfaceState
SCALARS = ("iterations", "cuts", "unsettled", "residual", "seconds", "tolerance")


def record(n: int) -> np.dtype:
    """One load step: a SurfaceState of n nodes and what it took."""
    fields: list[tuple] = [("pressure", "f8", n), ("traction", "f8", n), ("u", "f8", (2, n)), ("delta", "f8", 2)]
    fields += [("neglected", "f8", (2, n)), ("elastic", "f8")]
    return np.dtype(fields + [(name, "f8") for name in SCALARS])


@dataclass(frozen=True)
class Saved:
    """A run as it was left: its mesh grading, states (s,) of dtype ``record``, memory and seconds by phase.

    changes: of contact states, iteration by iteration, for each of the states.
    """

    cells: Grading | None = None
    states: np.ndarray | None = None
    memory: dict[str, np.ndarray] | None = None
    seconds: dict[str, float] | None = None
    changes: tuple[tuple[int, ...], ...] = ()
    resumed: int = 0  # how many times, this one included


class Checkpoint:
    """Writes the checkpoint of a run into ``folder``. Every rank calls ``save``; rank 0 writes."""

    def __init__(self, folder: Path, simulation: Simulation):
        self.simulation, self._folder = simulation, folder / FOLDER
        self._checksums: list[int] = []  # of the records

    def save(self, entry: Entry):
        """Keep the state just reached, and the memory that goes with it."""
        simulation, stepping = self.simulation, self.simulation.stepping
        kept = present_state.gather(stepping.system, simulation.numbering) | stepping.save()
        if simulation.body.mesh.comm.rank > 0:
            return
        self._folder.mkdir(exist_ok=True)
        surface, entries = entry.surface, simulation.history.entries
        number = len(entries)
        self._checksums += [zlib.crc32(_row(e)) for e in entries[len(self._checksums) : -1]]  # of an earlier part
        row = _row(entry)
        self._checksums.append(zlib.crc32(row))
        descriptor = os.open(self._folder / STATES, os.O_RDWR | os.O_CREAT, 0o666)
        with os.fdopen(descriptor, "r+b") as file:
            file.seek((number - 1) * len(row))
            file.write(row)
            file.flush()
            os.fsync(descriptor)
        with on_disk(self._folder / MEMORY) as partial:
            partial.write_bytes(self._packed(number, surface.x.size, kept))

    def _packed(self, number, n, kept):
        simulation, archive = self.simulation, io.BytesIO()
        watch = simulation.watch.seconds | {"total": simulation.watch.total}
        np.savez(
            archive,
            version=__version__,
            scene=simulation.scene.to_toml(),
            checksums=np.array(self._checksums, dtype=np.uint32),
            changes=json.dumps([e.changes for e in simulation.history.entries]),
            number=[number, n, simulation.resumed],
            phases=list(watch),
            seconds=list(watch.values()),
            **{f"cells {name}": value for name, value in asdict(simulation.cells).items()},
            **{f"memory {name}": value for name, value in kept.items()},
        )
        return archive.getvalue()


def remove(folder: Path):
    """Take away the checkpoint of the run in ``folder``, if there is one: first what makes it count."""
    (folder / FOLDER / MEMORY).unlink(missing_ok=True)
    if (folder / FOLDER).exists():
        shutil.rmtree(folder / FOLDER)


def load(folder: Path) -> Saved:
    """The run in ``folder``, which may have no checkpoint yet. SceneError where none is or it does not fit."""
    scene = read_scene(folder)
    if not (folder / FOLDER / MEMORY).exists():
        return Saved(resumed=1)
    try:
        content = io.BytesIO((folder / FOLDER / MEMORY).read_bytes())  # numpy leaves a damaged file open
        with np.load(content, allow_pickle=False) as archive:
            kept = dict(archive)
        version = str(kept.get("version", "before 0.1"))
        if version != __version__:
            raise _refusal(folder, f"graded-fretting {version} made it, and this is {__version__}")
        number, n, resumed = map(int, kept["number"])
        states = np.fromfile(folder / FOLDER / STATES, record(n), count=number)
        changes = tuple(map(tuple, json.loads(str(kept["changes"]))))
        checksums = kept["checksums"].tolist()
    except (OSError, ValueError, KeyError, EOFError, TypeError, zipfile.BadZipFile) as error:
        raise _refusal(folder, str(error)) from None
    if len(states) != number:
        raise _refusal(folder, f"{STATES} is too short")
    if checksums != [zlib.crc32(row.tobytes()) for row in states] or len(changes) != number:
        raise _refusal(folder, f"{STATES} is not as it was written")
    if str(kept["scene"]) != scene.to_toml():
        raise SceneError(f"--resume {folder}: {SCENE} is not the scene of the checkpoint; it was changed afterwards")
    lost = first_lost(folder, Plan(scene, Stopwatch()).schedule, scene.output, number)
    if lost:
        raise SceneError(f"--resume {folder}: {lost} is missing; {AGAIN}")
    cells = {name: value.tolist() for name, value in _part(kept, "cells").items()}
    return Saved(
        Grading(**cells | {"edges": tuple(cells["edges"]), "sweeps": tuple(map(tuple, cells["sweeps"]))}),
        states,
        _part(kept, "memory"),
        dict(zip(kept["phases"].tolist(), kept["seconds"].tolist())),
        changes,
        resumed + 1,
    )


def read_scene(folder: Path) -> Scene:
    """The scene of the run in ``folder``; SceneError where there is none."""
    try:
        return parse((folder / SCENE).read_text(encoding="utf-8"), name=f"scene {shown(folder / SCENE)}")
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", "it is not text")
        raise SceneError(f"--resume {folder} is not the folder of a run: {SCENE}: {why}") from None


def _refusal(folder, why) -> SceneError:
    return SceneError(f"--resume {folder}: the checkpoint cannot be read: {one_line(why)}; {AGAIN}")


def restore(saved: Saved, simulation: Simulation):
    """Take a new Simulation to where ``saved`` was left."""
    simulation.resumed = saved.resumed
    if saved.states is None or saved.memory is None or saved.seconds is None:
        return
    sampler, stepping, done = simulation.sampler, simulation.stepping, simulation.schedule[: len(saved.states)]
    for step, row, changes in zip(done, saved.states, saved.changes, strict=True):
        surface = SurfaceState(sampler.x, sampler.weight, mu=sampler.mu, **{name: row[name].copy() for name in SURFACE})
        iterations, residual, tolerance = int(row["iterations"]), float(row["residual"]), float(row["tolerance"])
        result = NewtonResult(True, iterations, residual, "", tolerance, changes)
        outcome = Outcome(step, (result,), int(row["cuts"]), float(row["unsettled"]))
        simulation.history.append(outcome, surface, float(row["seconds"]))
    stepping.skip(done)
    present_state.scatter(stepping.system, saved.memory, simulation.numbering)
    stepping.restore(saved.memory)
    simulation.watch.go_on(saved.seconds)


def is_complete(folder: Path) -> bool:
    """Whether the run in ``folder`` reached its end."""
    return bool(read_summary(folder).get("converged")) and not (folder / FOLDER / MEMORY).exists()


def failing_checks(folder: Path) -> list[str]:
    """Names of the checks that a complete run does not pass, with their causes; SceneError where its summary does not
    tell.
    """
    try:
        checks = read_summary(folder)["checks"]
        return [f"{name} ({c['cause']})" if c["cause"] else name for name, c in checks.items() if not c["holds"]]
    except (AttributeError, KeyError, TypeError):
        why = "the checks in summary.json are not as the run wrote them; it was changed afterwards"
        raise SceneError(f"--resume {folder}: {why}") from None


def read_summary(folder) -> dict:
    """What the run says of itself; {} where there is nothing, or it cannot be read."""
    try:
        found = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        return found if isinstance(found, dict) else {}
    except (OSError, ValueError):
        return {}


def _row(entry: Entry) -> bytes:
    """The record of a load step."""
    row = np.zeros((), record(entry.surface.x.size))
    for name in SURFACE:
        row[name] = getattr(entry.surface, name)
    for name in SCALARS:
        row[name] = getattr(entry, name)
    return row.tobytes()


def _part(kept, name):
    return {key.removeprefix(name + " "): value for key, value in kept.items() if key.startswith(name + " ")}
