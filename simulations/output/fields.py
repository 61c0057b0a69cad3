"""Displacement and stress inside the body: a file a state, with indices for ParaView and other readers, and lines."""

from pathlib import Path

import numpy as np

from ..fem.body_sample import BodySample, BodySampler
from ..fem.lagrange import gauss
from ..fem.numbering import with_nodes_between
from ..loading.schedule import LoadStep, load_parameter
from ..runs.simulation import Simulation
from ..scene.output import NORMAL, Output
from .body_quantities import DOWN_TO_UP, MEANING, UNITS, from_stress
from .field_index import FOLDER, MESH, FieldIndex, file_name, local_nodes
from .files import hdf5
from .lines import Lines


def kept(schedule: list[LoadStep], output: Output) -> dict[int, str]:
    """The load steps whose fields are kept, and the names of their states; "" for one without a name."""
    found, wanted = {}, output.states
    for number, step in enumerate(schedule):
        pressing = number + 1 < len(schedule) and schedule[number + 1].branch == NORMAL
        name = NORMAL if step.branch == NORMAL and not pressing else step.state
        if wanted == "all" or name and (wanted == "named" or name in wanted):
            found[number] = name
    return found


def first_lost(folder: Path, schedule: list[LoadStep], output: Output, done: int) -> str | None:
    """The first file that is missing of the fields of the first ``done`` load steps."""
    files = [file_name(number) for number in kept(schedule, output) if number < done]
    names = [f"{FOLDER}/{name}" for name in ([MESH, *files] if files else [])]
    return next((name for name in names if not (folder / name).is_file()), None)


class FieldWriter:
    """fields/*.h5 with their indices, and lines.csv, of the states and fields that the scene asks for; SI units.

    x along +Q, y upwards. Displacement at the nodes of a mesh of straight cells in physical coordinates, of the degree
    of the run; stresses as means over cells. A file a state; the numbering is that of the columns and layers, whatever
    the ranks. Every rank calls ``write``; rank 0 writes.
    """

    def __init__(self, folder: Path, simulation: Simulation):
        scene, numbering = simulation.scene, simulation.numbering
        self.folder, self.scaled, self.schedule = folder, simulation.scaled, simulation.schedule
        self.nu, self.names = scene.solid.nu, scene.output.kept
        self.times = load_parameter(self.schedule)
        self._kept = kept(self.schedule, scene.output)
        self._sampler = BodySampler(numbering)
        nodes = numbering.shape[0] * numbering.shape[1]
        self._index = FieldIndex(folder, numbering.body.degree, nodes, numbering.cells, self.names)
        self._lines = Lines(folder, scene.output, self.names)

    def wants(self, number: int) -> bool:
        """Whether the fields of a load step are kept."""
        return number in self._kept

    def write(self, number: int):
        """Keep the present state as that of load step ``number``."""
        sample = self._sampler.sample()
        if sample is None:
            return
        (self.folder / FOLDER).mkdir(exist_ok=True)
        mesh = self.folder / FOLDER / MESH
        nodes = _nodes(sample)
        if not mesh.exists():
            self._write_mesh(mesh, sample, *nodes)
        x, y = (a.ravel() for a in np.meshgrid(*nodes))
        fields = {"displacement": self._displacement(sample, x, y)}
        fields |= self._stresses(sample.mean_stress(), self._cell_moduli(sample)[:, None])
        with hdf5(self.folder / FOLDER / file_name(number)) as file:
            step, scales = self.schedule[number], self.scaled.scales
            file.attrs["load_step"], file.attrs["state"] = number, self._kept[number]
            file.attrs["branch"], file.attrs["load_parameter"] = step.branch, self.times[number]
            file.attrs["P"], file.attrs["Q"] = step.P * scales.line_load, step.Q * scales.line_load
            for name in self.names:
                values = fields[name]
                file[name] = values if name == "displacement" else values.ravel()
                file[name].attrs["unit"], file[name].attrs["meaning"] = UNITS[name], MEANING[name]
            if self._lines.x.size:
                self._lines.keep(file, self._along_lines(sample))

    def write_series(self, done: int):
        """The indices and lines.csv, of the states kept so far among ``done`` load steps. On rank 0.

        Each has all states: a run that wrote them at every state would spend its time on them.
        """
        numbers = [number for number in self._kept if number < done]
        if numbers:
            self._index.write(numbers, [float(self.times[n]) for n in numbers])
            self._lines.write(numbers)

    def _along_lines(self, sample):
        length = self.scaled.scales.length
        x, y = self._lines.x / length, self._lines.y / length
        found = {"displacement": self._displacement(sample, x, y)}
        with np.errstate(divide="ignore"):  # E is infinite on the surface where k < 0
            young = np.broadcast_to(self.scaled.modulus.young(y), y.shape)
        return found | self._stresses(sample.stress_at(x, y), young)

    def _displacement(self, sample, x, y):
        """(n, 3) [m], as a vector has three components to ParaView."""
        u = sample.displacement_at(x, y) * self.scaled.scales.displacement
        return np.column_stack([u[:, 0], -u[:, 1], np.zeros(len(u))])

    def _cell_moduli(self, sample):
        """E of each layer of cells that gives their energy.

        Where E is infinite on the surface strains are smooth: the mean of E. Elsewhere stresses are: 1/(mean of 1/E).
        """
        modulus, depth, s = self.scaled.modulus, sample.depth, sample.s
        y = depth.y(s)
        if modulus.is_singular:
            return modulus.layer_mean(y[:-1], y[1:])  # type: ignore[attr-defined]  # singular
        points, weights = gauss(3)
        at = s[:-1, None] + np.diff(s)[:, None] * points
        flexibility = depth.stretch(at) / modulus.young(depth.y(at))  # in ds: constant for a power law
        return np.diff(y) / np.diff(s) / (np.broadcast_to(flexibility, at.shape) @ weights)

    def _stresses(self, stress, young):
        scales = self.scaled.scales
        return from_stress(stress * DOWN_TO_UP * scales.stress, young * scales.modulus, self.nu)

    def _write_mesh(self, path, sample, columns, layers):
        """points (n, 3); cells (m, (d + 1)²) in VTK's order, and their corners (m, 4); x and depth of the vertices."""
        d, length = sample.degree, self.scaled.scales.length
        x, y = (a.ravel() for a in np.meshgrid(columns, layers))
        rows, across = len(sample.s) - 1, len(sample.x) - 1
        below_left = (d * np.arange(1, rows + 1)[:, None] * len(columns) + d * np.arange(across)).ravel()
        cells = np.stack([below_left + i - j * len(columns) for i, j in local_nodes(d)], axis=1)
        with hdf5(path) as file:
            file.attrs["degree"] = d
            file["points"] = np.column_stack([x, 0.0 - y, np.zeros(len(x))]) * length
            file["cells"], file["connectivity"], file["corners"] = cells, cells.ravel(), cells[:, :4]
            file["x"], file["depth"] = sample.x * length, sample.depth.y(sample.s) * length


def _nodes(sample: BodySample):
    """Columns and depths of nodes at equal distances in the straight cells of the physical mesh."""
    shares = np.arange(sample.degree) / sample.degree
    return [with_nodes_between(vertices, shares) for vertices in (sample.x, sample.depth.y(sample.s))]
