"""Files of a run: scene, history, surface and summary. SI units; written by rank 0, each whole or not at all."""

import csv
import io
import json
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py
import numpy as np

from ..runs.history import Entry, History
from ..scene.scaling import Scales

UNITS = {
    "x": "m",
    "weight": "m",
    "pressure": "Pa",
    "traction": "Pa",
    "slip": "m",
    "P": "N/m",
    "Q": "N/m",
}
MEANING = {
    "x": "position along the surface",
    "weight": "length of surface that belongs to a node: sum(weight * pressure) = P",
    "pressure": "contact pressure",
    "traction": "tangential traction on the half-plane, positive along +Q",
    "slip": "u_x - delta_x since tangential loading began",
    "P": "normal line load, as prescribed",
    "Q": "tangential line load, as prescribed",
}


writing = threading.RLock()  # held while a file is written: a signal's last words wait for it


class OutputError(RuntimeError):
    """The results cannot be written; the message is one line and says how to go on."""


@contextmanager
def on_disk(path: Path) -> Iterator[Path]:
    """A neighbour to write ``path`` to; it takes its place once whole and on the disk, or leaves no trace."""
    partial = path.with_name("part." + path.name)
    with writing:
        try:
            yield partial
            with open(partial, "rb") as file:
                os.fsync(file.fileno())
            os.replace(partial, path)
        except BaseException:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
            raise


@contextmanager
def hdf5(path: Path) -> Iterator[h5py.File]:
    """A new HDF5 file, made in memory: the library cannot close one on a disk that is full."""
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        yield file
    with on_disk(path) as partial:
        partial.write_bytes(content.getbuffer())


def write_text(path: Path, text: str):
    """Write a file whole."""
    with on_disk(path) as partial:
        partial.write_text(text, encoding="utf-8")


def write_table(path: Path, rows: list[dict], left_out: tuple[str, ...] = ()):
    """A CSV file, a column for each key that any row has, in the order in which they come, but those ``left_out``."""
    names = [name for name in dict.fromkeys(name for row in rows for name in row) if name not in left_out]
    table = io.StringIO()
    writer = csv.DictWriter(table, names, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, table.getvalue())


def write_history(path: Path, history: History, scales: Scales):
    """history.csv, a row an increment."""
    write_table(path, [_row(entry, scales, history.friction) for entry in [*history.entries]])


def _row(entry: Entry, scales: Scales, friction: bool) -> dict:
    """One row by column name; without friction the columns of the tangential problem are absent."""
    increment = entry.increment
    delta_x, delta_y = entry.surface.delta * scales.displacement
    normal = {"P[N/m]": increment.P * scales.line_load, "delta_y[m]": delta_y, "a[m]": entry.a * scales.length}
    tangential = {
        "Q[N/m]": increment.Q * scales.line_load,
        "delta_x[m]": delta_x,
        "c[m]": entry.c * scales.length,
        "dissipated_energy[J/m]": entry.dissipated * scales.energy,
    }
    quantities = normal | (tangential if friction else {})
    return (
        {"increment": entry.number, "branch": increment.branch, "cycle": increment.cycle, "state": increment.state}
        | {name: f"{value:.12g}" for name, value in quantities.items()}
        | {"iterations": entry.iterations, "cuts": entry.cuts}
        | {"states_changed": " ".join(map(str, entry.changes))}  # iteration by iteration
        | {"residual": f"{entry.residual:.2e}", "seconds": f"{entry.seconds:.3f}"}
    )


def write_surface(path: Path, history: History, scales: Scales):
    """surface.h5: x (n,), weight (n,); pressure, traction, slip (s, n); P, Q (s,); SI units as attributes.

    Without friction traction, slip and Q are absent.
    """
    entries = [*history.entries]
    data = {
        "x": entries[0].surface.x * scales.length,
        "weight": entries[0].surface.weight * scales.length,
        "pressure": np.stack([e.surface.pressure for e in entries]) * scales.stress,
        "traction": np.stack([e.surface.traction for e in entries]) * scales.stress,
        "slip": np.stack([e.slip for e in entries]) * scales.displacement,
        "P": np.array([e.increment.P for e in entries]) * scales.line_load,
        "Q": np.array([e.increment.Q for e in entries]) * scales.line_load,
    }
    if not history.friction:
        data = {name: data[name] for name in ("x", "weight", "pressure", "P")}
    with hdf5(path) as file:
        for name, values in data.items():
            dataset = file.create_dataset(name, data=values)
            dataset.attrs["unit"] = UNITS[name]
            dataset.attrs["meaning"] = MEANING[name]
        file.create_dataset("branch", data=[e.increment.branch for e in entries])
        file.create_dataset("state", data=[e.increment.state for e in entries])


def write_summary(path: Path, summary: dict):
    """summary.json; numbers that do not exist are null."""
    write_text(path, json.dumps(_plain(summary), indent=2) + "\n")


def _plain(value):
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
