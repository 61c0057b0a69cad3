"""Fields of a finished run at its recorded states, read from its folder. For pictures; no solver needed."""

import csv
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from ..scene import SceneError

FIELD = "von Mises stress [Pa]"


@dataclass(frozen=True)
class BodyState:
    """One recorded state, SI units. x (m,), y (n,): cell centres, y the depth; von_mises (n, m) [Pa]."""

    label: str
    x: np.ndarray
    y: np.ndarray
    von_mises: np.ndarray


def read_states(folder: Path) -> list[BodyState]:
    """The states in fields.xdmf, labelled from history.csv; SceneError where the folder holds no run."""
    path = folder / "fields.xdmf"
    if not path.is_file() or not (folder / "history.csv").is_file():
        raise SceneError(f"{folder} holds no results of a run: fields.xdmf and history.csv are needed")
    with (folder / "history.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, cells = reader.read_points_cells()
        place = _Grid(points, cells[0].data)
        states = []
        for step in range(reader.num_steps):
            time, _, at_cells = reader.read_data(step)
            row = rows[round(time)]
            label = "pressed" if row["branch"] == "normal" else f"{row['state']}, {row['branch']}"
            states.append(BodyState(label, place.x, place.y, place.values(at_cells[FIELD][0])))
    return states


class _Grid:
    """The tensor-product mesh as rows and columns of cell centres."""

    def __init__(self, points, quads):
        centres = points[quads][:, :, :2].mean(axis=1)
        columns, rows = (self._ranks(centres[:, i]) for i in (0, 1))
        self._order = np.lexsort((columns, rows))
        self.shape = rows.max() + 1, columns.max() + 1
        self.x = centres[self._order][: self.shape[1], 0]
        self.y = centres[self._order][:: self.shape[1], 1]

    @staticmethod
    def _ranks(values):
        """Index of each value among the distinct ones; values equal to rounding count as one."""
        size = np.abs(values).max()
        order = np.argsort(values)
        steps = np.concatenate([[0], np.cumsum(np.diff(values[order]) > 1e-9 * size)])
        ranks = np.empty(len(values), dtype=int)
        ranks[order] = steps
        return ranks

    def values(self, at_cells):
        return np.asarray(at_cells)[self._order].reshape(self.shape)
