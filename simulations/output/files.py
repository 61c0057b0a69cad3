"""Files of a run: scene, history, surface and summary. SI units; written by rank 0, each whole or not at all."""

import csv
import io
import json
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py
import numpy as np

from ..runs.history import Entry, History
from ..scene.scaling import Scales

QUANTITIES = {  # of surface.h5: unit and meaning
    "x": ("m", "position along the surface"),
    "weight": ("m", "length of surface that belongs to a node: sum(weight * pressure) = P_carried"),
    "load_parameter": ("–", "length of the load path so far, in the largest P and the largest Q"),
    "pressure": ("Pa", "contact pressure"),
    "gap": ("m", "f(x) - u_y - delta_y with u_y upwards; without coupling u_y is that of the pressure alone"),
    "traction": ("Pa", "tangential traction on the half-plane, positive along +Q"),
    "slip": ("m", "u_x - delta_x since tangential loading began, less elastic slip"),
    "contact_state": ("–", "0 separated, 1 stick (without friction: in contact), 2 slip"),
    "frictional_work": ("J/m²", "energy dissipated per area of surface since the start"),
    "frictional_work_of_cycle": ("J/m²", "w, equation (51): the same of the last full cycle, or since the start"),
    "P_prescribed": ("N/m", "normal line load, as prescribed"),
    "P_carried": ("N/m", "normal line load that the pressure carries"),
    "Q_prescribed": ("N/m", "tangential line load, as prescribed"),
    "Q_carried": ("N/m", "tangential line load that the traction carries"),
}


writing = threading.RLock()  # held while a file is written: a signal's last words wait for it


class OutputError(OSError):
    """The results cannot be written; the message is one line. That of a run says how to go on."""

    def __str__(self):
        return f"{self.filename} cannot be written: {self.strerror}" if self.filename else super().__str__()


@contextmanager
def on_disk(path: Path) -> Iterator[Path]:
    """A neighbour to write ``path`` to; it takes its place once whole and on the disk, or leaves no trace. OutputError
    where it cannot be written.
    """
    partial = path.with_name("part." + path.name)
    with writing:
        try:
            yield partial
            with open(partial, "rb") as file:
                os.fsync(file.fileno())
            os.replace(partial, path)
        except OSError as error:
            error.__traceback__ = None  # it would keep what was to be written in a reference cycle
            raise OutputError(error.errno, error.strerror or str(error), str(path)) from None
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)


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


def write_table(path: Path, rows: list[dict]):
    """A CSV file, a column for each key that any row has, in the order in which they come."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    table = io.StringIO()
    writer = csv.DictWriter(table, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, table.getvalue())


@contextmanager
def reading(path: Path) -> Iterator[Path]:
    """Meanwhile a file is read: ValueError, which names it, where that fails, as for one that is cut short."""
    try:
        yield path
    except (KeyError, OSError, ValueError) as error:
        raise ValueError(f"{path.name}: {error}") from None


def rows_of(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file by column, ``reading`` it."""
    with reading(path):
        text = path.read_text(encoding="utf-8")
        if not text.endswith("\n"):
            raise ValueError("it is empty or cut short")
        return list(csv.DictReader(io.StringIO(text, newline="")))


def write_history(path: Path, history: History, scales: Scales, times: np.ndarray):
    """history.csv, a row a load step; times: load parameters (s,)."""
    write_table(path, [_row(e, t, scales, history.friction) for e, t in zip([*history.entries], times)])


def _loads(entry: Entry, scales: Scales) -> dict[str, float]:
    """Line loads [N/m] by name: as prescribed, and as pressure and traction carry them."""
    prescribed, carried = (entry.step.P, entry.step.Q), entry.carried
    pairs = zip(("P_prescribed", "Q_prescribed", "P_carried", "Q_carried"), (*prescribed, *carried), strict=True)
    return {name: load * scales.line_load for name, load in pairs}


def _row(entry: Entry, time: float, scales: Scales, friction: bool) -> dict:
    """One row by column name; without friction the columns of the tangential problem are absent."""
    step, length = entry.step, scales.length
    delta_x, delta_y = entry.surface.delta * scales.displacement
    loads = {f"{name}[N/m]": load for name, load in _loads(entry, scales).items()}
    normal = {
        "load_parameter": time,
        **_of("P", loads),
        "delta_y[m]": delta_y,
        "a[m]": entry.a * length,
        "contact_left[m]": entry.contact[0] * length,
        "contact_right[m]": entry.contact[1] * length,
        "peak_pressure[Pa]": entry.peak_pressure * scales.stress,
    }
    tangential = {
        **_of("Q", loads),
        "delta_x[m]": delta_x,
        "c[m]": entry.c * length,
        "stick_left[m]": entry.stick[0] * length,
        "stick_right[m]": entry.stick[1] * length,
        "dissipated_energy[J/m]": entry.dissipated * scales.energy,
    }
    quantities = normal | (tangential if friction else {})
    return (
        {"increment": entry.number, "branch": step.branch, "cycle": step.cycle, "state": step.state}
        | {name: f"{value:.12g}" for name, value in quantities.items()}
        | {"iterations": entry.iterations, "cuts": entry.cuts, "unsettled": f"{entry.unsettled:.2e}"}
        | {"states_changed": " ".join(map(str, entry.changes))}  # iteration by iteration
        | {"residual": f"{entry.residual:.2e}", "seconds": f"{entry.seconds:.3f}"}
    )


def _of(load: str, loads: dict) -> dict:
    """Those of P or of Q."""
    return {name: values for name, values in loads.items() if name.startswith(load)}


def write_surface(path: Path, history: History, scales: Scales, times: np.ndarray, height: Callable):
    """surface.h5: the QUANTITIES, of nodes (n,), states (s,) or both (s, n); SI units as attributes.

    times: load parameters (s,); height: the indenter's f(x), dimensionless. Without friction what belongs to the
    tangential problem is absent.
    """
    entries = [*history.entries]
    surfaces = [e.surface for e in entries]
    profile, by_entry = height(surfaces[0].x), [_loads(e, scales) for e in entries]
    loads = {name: np.array([one[name] for one in by_entry]) for name in by_entry[0]}
    data = {
        "x": surfaces[0].x * scales.length,
        "weight": surfaces[0].weight * scales.length,
        "load_parameter": times[: len(entries)],
        "pressure": np.stack([s.pressure for s in surfaces]) * scales.stress,
        "gap": np.stack([profile + s.approach for s in surfaces]) * scales.displacement,
        "contact_state": np.stack([e.contact_states for e in entries]).astype(np.uint8),
        **_of("P", loads),
    }
    if history.friction:
        data |= {
            "traction": np.stack([s.traction for s in surfaces]) * scales.stress,
            "slip": np.stack([e.slip for e in entries]) * scales.displacement,
            "frictional_work": np.stack([e.work for e in entries]) * scales.energy / scales.length,
            "frictional_work_of_cycle": history.work * scales.energy / scales.length,
            **_of("Q", loads),
        }
    with hdf5(path) as file:
        for name, (unit, meaning) in QUANTITIES.items():
            if name in data:
                file[name] = data[name]
                file[name].attrs["unit"], file[name].attrs["meaning"] = unit, meaning
        file["branch"], file["state"] = [e.step.branch for e in entries], [e.step.state for e in entries]


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
