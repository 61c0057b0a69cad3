"""The folder of a run: files while it goes, then summary, picture and the table beside the closed form."""

import platform
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import dolfinx
import gmsh
import numpy as np
from petsc4py import PETSc

from .. import __version__
from ..run import checks, comparison, reference
from ..run.history import Entry
from ..run.simulation import Simulation
from ..scene import Scene, SceneError
from . import checkpoint, fields
from . import files as output
from .checkpoint import Checkpoint
from .fields import FieldWriter
from .plots import plot_run

FILES = ("scene.toml", "history.csv", "surface.h5", "fields.xdmf", "summary.json", "fretting.png")
OTHERS = ("report.html",)  # made of the files of a run by other commands
EVERY = 10.0  # seconds between two versions of history.csv and surface.h5 while the run goes on


def files() -> tuple[str, ...]:
    """What a finished run has written."""
    return (*FILES, f"{fields.FOLDER}/")


def versions() -> dict[str, str]:
    """What the numbers were made with."""
    return {
        "graded-fretting": __version__,
        "python": platform.python_version(),
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "gmsh": gmsh.__version__,
        "numpy": np.__version__,
    }


def begin(folder: Path, scene: Scene):
    """Make ``folder`` that of a new run: nothing of an earlier one, and the scene.

    The scene goes first and comes last: a folder with a scene can be resumed. SceneError where it cannot be written.
    """
    try:
        (folder / "scene.toml").unlink(missing_ok=True)
        checkpoint.remove(folder)
        for name in (*FILES, *OTHERS):
            (folder / name).unlink(missing_ok=True)
        if (folder / fields.FOLDER).is_dir():
            for path in (folder / fields.FOLDER).glob("*.h5"):
                path.unlink()
        made_with = "".join(f"# {name} {version}\n" for name, version in versions().items())
        output.write_text(folder / "scene.toml", made_with + scene.to_toml())
    except OSError as error:
        raise SceneError(f"--output {folder} cannot be written: {error.strerror}") from None


class Results:
    """Writes what a Simulation yields into ``folder``. Every rank calls every method; rank 0 writes.

    again: the command that goes on with the run if it stops.
    """

    def __init__(self, folder: Path, simulation: Simulation, again: str = ""):
        self.folder, self.simulation = folder, simulation
        self._again = again or f"--resume {folder}"
        self.scales = simulation.scaled.scales
        self.comm = simulation.body.mesh.comm
        self.summary: dict = {}
        self._fields = FieldWriter(folder, simulation.numbering, self.scales)
        self._checkpoint = Checkpoint(folder, simulation)
        self._reference: reference.Reference | None = None
        self._neglecting: reference.ClosedForm | None = None
        self._no_reference = "none"
        self._written = time.monotonic()

    def __enter__(self):
        return self

    def record(self, entry: Entry):
        """Keep a state: its fields if it matters, the memory to go on from it, and now and then the tables."""
        last = len(self.simulation.history.entries) - 1
        with self.simulation.watch("output"):
            if self._matters(last):
                kept = [number for number in range(last + 1) if self._matters(number)]
                self._everywhere(lambda: self._fields.write(last, kept))
            self._everywhere(lambda: self._checkpoint.save(entry))
            if self.comm.rank == 0 and time.monotonic() - self._written > EVERY:
                with suppress(OSError):  # the next ones, or the last, will do
                    self._write_tables()

    def _matters(self, number):
        """True for the end of the normal stage and the states A ... E or 1, 2, ..., whose fields are kept."""
        programme = self.simulation.programme
        normal = programme[number].branch == "normal"
        pressing = number + 1 < len(programme) and programme[number + 1].branch == "normal"
        return bool(programme[number].state) or (normal and not pressing)

    def _everywhere(self, write: Callable[[], None]):
        """``write``, in which rank 0 may fail: OutputError on every rank."""
        failure = None
        try:
            write()
        except OSError as error:
            failure = f"{self.folder} cannot be written: {error.strerror or error}; go on with {self._again}"
        failure = self.comm.bcast(failure)
        if failure:
            raise output.OutputError(failure)

    def _write_tables(self):
        history = self.simulation.history
        output.write_history(self.folder / "history.csv", history, self.scales)
        output.write_surface(self.folder / "surface.h5", history, self.scales)
        self._written = time.monotonic()

    def __exit__(self, kind, error, trace):
        """Write what there is, after a failure too; then ranks may not be in step, and rank 0 does what it can."""
        if kind is None:
            self._everywhere(self._finish)
        elif self.comm.rank == 0:
            with suppress(OSError):
                if self.simulation.history.entries:
                    self._write_tables()
                self.summary = self._summarise(failure=(str(error) or kind.__name__).splitlines()[0])
                output.write_summary(self.folder / "summary.json", self.summary)

    def _finish(self):
        """The tables, the comparison and the picture, after which there is nothing left to go on with."""
        if self.comm.rank == 0:
            with self.simulation.watch("output"):
                self._write_tables()
            self._find_references()
            self._plot()
            self.summary = self._summarise(failure=None)
            output.write_summary(self.folder / "summary.json", self.summary)
            checkpoint.remove(self.folder)

    def _plot(self):
        simulation, scene = self.simulation, self.simulation.scene
        values = [f"k = {scene.k:g}", f"ν = {scene.solid.nu:.4g}"]
        if scene.friction:
            values.append(f"μ = {scene.load.mu:g}")
        title = f"{scene.title}  ({', '.join(values)})".strip()
        lines = {}
        if self._reference:
            lines[self._reference.name] = self._reference
        if self._neglecting:
            lines["closed form (no coupling)"] = self._neglecting
        plot_run(self.folder / "fretting.png", title, simulation, lines)

    def _summarise(self, failure) -> dict:
        simulation = self.simulation
        history, scene, watch = simulation.history, simulation.scene, simulation.watch
        summary = {
            "title": scene.title,
            "converged": failure is None,
            "failure": failure,
            "effects": {name: verdict.on for name, verdict in simulation.effects.verdicts.items()},
            "increments": len(history.entries),
            "resumed": simulation.resumed,
            "newton_iterations": sum(e.iterations for e in history.entries),
            "cuts": sum(e.cuts for e in history.entries),
            "largest_residual": max((e.residual for e in history.entries), default=None),
            "dofs": simulation.body.unknowns,
            "ranks": self.comm.size,
        }
        if failure is None:
            height, coupled = simulation.scaled.indenter.height, "coupling" in simulation.effects
            self._checks = checks.check(history, height, coupled or not scene.friction)
            found = {name: vars(c) | {"holds": c.holds} for name, c in self._checks.items()}
            summary |= self._quantities() | {"checks": found} | self._deviations()
        summary["seconds"] = watch.seconds | {"total": watch.total}
        summary["versions"] = versions()
        return summary

    def _quantities(self) -> dict:
        """Scalars of the last state and cycle, SI."""
        history, scales = self.simulation.history, self.scales
        last = history.entries[-1]
        quantities = {
            "a": last.a * scales.length,
            "a_over_a0": last.a * scales.length / self.simulation.scene.a0,
            "indentation": float(last.surface.delta[1]) * scales.displacement,
        }
        if history.friction:
            quantities["c_over_a"] = last.c / last.a
            quantities["dissipated_energy"] = history.dissipated_energy * scales.energy
        return quantities

    def _deviations(self) -> dict:
        """Errors against what has the same physics; differences from a closed form that neglects some of it."""
        history = self.simulation.history
        deviations: dict = {"reference": self._no_reference, "errors": None}
        if self._reference:
            deviations["reference"] = reference.describe(self._reference, self.simulation)
            deviations["errors"] = comparison.compare(history, self._reference)
            if history.has_cycle:
                deviations["errors_worst_in_cycle"] = comparison.worst(history, self._reference)
        if self._neglecting:
            neglected = ", ".join(self.simulation.effects.without_reference) or "the coupling"
            deviations["differences_from"] = f"closed form, which neglects {neglected} of this run: another problem"
            deviations["differences"] = comparison.compare(history, self._neglecting)
            if history.has_cycle:
                deviations["differences_worst_in_cycle"] = comparison.worst(history, self._neglecting)
        return deviations

    def _find_references(self):
        simulation = self.simulation
        with simulation.watch("reference"):
            try:
                self._reference = reference.of_same_physics(simulation)
            except reference.NoReference as reason:
                self._no_reference = f"none: {reason}"
        if not simulation.effects.has_closed_form and simulation.scene.reference.kind != "none":
            self._neglecting = reference.closed_form(simulation)

    def table(self) -> str:
        """The results beside the reference, for reading."""
        summary, lines = self.summary, []
        if summary["errors"]:
            lines += self._rows(self._reference, summary["errors"], "error")
            lines.append(f"reference: {summary['reference']}")
        else:
            lines.append(f"no errors: reference {summary['reference']}")
        if self._neglecting:
            lines += ["", *self._rows(self._neglecting, summary["differences"], "difference")]
            lines.append(f"differences from the {summary['differences_from']}")
        lines.append(checks.describe(self._checks))
        return "\n".join(lines)

    def _rows(self, other, deviation, kind):
        summary, scales = self.summary, self.scales
        last = self.simulation.history.entries[-1]
        left, right = other.contact(last)
        half_width = (right - left) / 2
        rows = [("contact half-width a [m]", summary["a"], half_width * scales.length, deviation["a"])]
        if "c" in deviation:
            c = other.stick_half_width(last) / half_width
            rows.append(("stick half-width c/a [-]", summary["c_over_a"], c, deviation["c"]))
        if "dissipated_energy" in deviation:
            name = "energy per cycle [J/m]" if self.simulation.history.has_cycle else "dissipated energy [J/m]"
            energy = other.dissipated_energy() * scales.energy
            rows.append((name, summary["dissipated_energy"], energy, deviation["dissipated_energy"]))
        lines = [f"{'':28s}{'computed':>16s}{other.name[-16:]:>17s}{'relative ' + kind:>21s}"]
        lines += [f"{name:28s}{value:16.8g}{theirs:17.8g}{d:21.1e}" for name, value, theirs, d in rows]
        for name in ("pressure", "traction", "slip"):
            if f"{name}_l2" in deviation:
                lines.append(f"{name + ', L2 over the contact, last state':61s}{deviation[name + '_l2']:21.1e}")
        return lines
