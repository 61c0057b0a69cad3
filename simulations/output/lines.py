"""Fields along lines and at points of the body: lines.csv, a row a point and state."""

from pathlib import Path

import h5py
import numpy as np

from ..scene.output import Output
from .body_quantities import UNITS
from .field_index import FOLDER, file_name
from .files import write_table

NAME, GROUP = "lines.csv", "lines"  # of the table; of what the file of a state keeps for it


class Lines:
    """The points x, depth y (n,) [m] that ``output`` asks for, and their table in ``folder``."""

    def __init__(self, folder: Path, output: Output, names: tuple[str, ...]):
        self.folder, self.names = folder, names
        lines = [np.linspace((x0, y0), (x1, y1), count) for x0, y0, x1, y1, count in output.lines]
        parts = [(f"line {i}", line) for i, line in enumerate(lines, start=1)]
        parts += [(f"point {i}", np.array([point])) for i, point in enumerate(output.points, start=1)]
        self.x, self.y = np.concatenate([np.empty((0, 2)), *(part for _, part in parts)]).T
        self._along = [name for name, part in parts for _ in part]

    def keep(self, file: h5py.File, fields: dict[str, np.ndarray]):
        """Put the ``fields`` at the points into the file of a state."""
        for name in self.names:
            file[f"{GROUP}/{name}"] = fields[name]

    def write(self, numbers: list[int]):
        """The table of the states of these load steps."""
        rows = []
        for number in numbers if self.x.size else ():
            with h5py.File(self.folder / FOLDER / file_name(number)) as file:
                state = {"increment": number, "branch": file.attrs["branch"], "state": file.attrs["state"]}
                columns = {"load_parameter": np.full(len(self.x), file.attrs["load_parameter"])}
                columns |= {"x[m]": self.x, "depth[m]": self.y}
                for name in self.names:
                    columns |= _columns(name, file[f"{GROUP}/{name}"][...])
            for i, along in enumerate(self._along):
                rows.append(state | {"along": along} | {name: f"{values[i]:.10g}" for name, values in columns.items()})
        if rows:
            write_table(self.folder / NAME, rows)


def _columns(name, values):
    if name != "displacement":
        return {f"{name}[{UNITS[name]}]": values}
    return {f"displacement_{axis}[m]": values[:, i] for i, axis in enumerate("xy")}
