"""The folder of a run: files while it goes, then summary, picture and the table beside the closed form."""

import platform
from pathlib import Path

import dolfinx
import gmsh
import numpy as np
from petsc4py import PETSc

from . import __version__, comparison, output, reference
from .fields import FieldWriter
from .plots import plot_run
from .scaling import Scales
from .simulation import Simulation

FILES = ("scene.toml", "history.csv", "surface.h5", "fields.xdmf", "fields.h5", "summary.json", "fretting.png")


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


class Results:
    """Writes what a Simulation yields into ``folder``. Every rank calls every method; rank 0 writes."""

    def __init__(self, folder: Path, simulation: Simulation):
        self.folder, self.simulation = folder, simulation
        self.scales = Scales.of(simulation.scene)
        self.comm = simulation.body.mesh.comm
        self.summary: dict = {}
        self._fields = None

    def __enter__(self):
        if self.comm.rank == 0:
            for name in FILES:  # of an earlier run
                (self.folder / name).unlink(missing_ok=True)
            made_with = "".join(f"# {name} {version}\n" for name, version in versions().items())
            output.write_text(self.folder / "scene.toml", made_with + self.simulation.scene.to_toml())
        self._fields = FieldWriter(self.folder / "fields.xdmf", self.simulation.body, self.scales)
        return self

    def record(self, entry):
        """Keep the fields of a state that matters: the normal stage and the states A ... E."""
        number = len(self.simulation.history.entries)
        pressed = entry.increment.branch == "normal" and not self._is_pressing(number)
        if pressed or entry.increment.state:
            with self.simulation.watch("output"):
                self._fields.write(float(number - 1))

    def _is_pressing(self, number):
        """True while increment ``number`` still belongs to the normal stage."""
        programme = self.simulation.programme
        return number < len(programme) and programme[number].branch == "normal"

    def __exit__(self, kind, error, trace):
        """Write what there is, after a failure too."""
        history = self.simulation.history
        with self.simulation.watch("output"):
            self._fields.close()
            if self.comm.rank == 0 and history.entries:
                output.write_history(self.folder / "history.csv", history, self.scales)
                output.write_surface(self.folder / "surface.h5", history, self.scales)
        if self.comm.rank == 0:
            self.summary = self._summarise(failure=None if kind is None else str(error) or kind.__name__)
            output.write_summary(self.folder / "summary.json", self.summary)
            if kind is None:
                self._plot()

    def _plot(self):
        simulation, scene = self.simulation, self.simulation.scene
        values = [f"k = {scene['solid.k']:g}", f"ν = {scene['solid.nu']:.4g}"]
        if simulation.loop:
            values.append(f"μ = {scene['load.mu']:g}")
        title = f"{scene['title']}  ({', '.join(values)})".strip()
        png = self.folder / "fretting.png"
        plot_run(png, title, simulation.history, simulation.contact, simulation.loop, scene.has_closed_form)

    def _summarise(self, failure) -> dict:
        simulation = self.simulation
        history, scene, watch = simulation.history, simulation.scene, simulation.watch
        summary = {
            "title": scene["title"],
            "converged": failure is None,
            "failure": failure,
            "effects": {effect.name: effect.on for effect in simulation.effects.listed},
            "increments": len(history.entries),
            "newton_iterations": sum(e.iterations for e in history.entries),
            "cuts": sum(e.cuts for e in history.entries),
            "largest_residual": max((e.residual for e in history.entries), default=None),
            "dofs": simulation.body.unknowns,
            "ranks": self.comm.size,
        }
        if failure is None:
            summary |= self._quantities() | self._deviations()
        summary["seconds"] = watch.seconds | {"total": watch.total}
        summary["versions"] = versions()
        return summary

    def _quantities(self) -> dict:
        """Scalars of the last state and cycle, SI."""
        history, contact = self.simulation.history, self.simulation.scene.contact
        last, scales = history.entries[-1], self.scales
        quantities = {
            "a": last.a * scales.length,
            "a_over_a0": last.a * scales.length / contact.a0,
            "indentation": float(last.surface.delta[1]) * scales.displacement,
        }
        if history.friction:
            quantities["c_over_a"] = last.c / last.a
            if history.has_cycle:
                quantities["dissipated_energy"] = history.dissipated_per_cycle * scales.energy
        return quantities

    def _deviations(self) -> dict:
        """Errors where the closed form describes the same problem, differences otherwise."""
        simulation = self.simulation
        history, contact, loop = simulation.history, simulation.contact, simulation.loop
        exact = simulation.scene.has_closed_form
        kind = "errors" if exact else "differences"
        deviations = {"reference": self._reference(), "errors": None, kind: comparison.compare(history, contact, loop)}
        if not exact:
            deviations |= self._errors_of_coupled_run()
        if loop and history.has_cycle:
            deviations[f"{kind}_worst_in_cycle"] = comparison.worst(history, contact, loop)
        return deviations

    def _errors_of_coupled_run(self) -> dict:
        if self.simulation.scene["reference.kind"] == "closed form":
            return {}
        try:
            with self.simulation.watch("reference"):
                states = reference.solve(self.simulation)
            return {"reference": reference.NAME, "errors": reference.errors(self.simulation.history, states)}
        except reference.NoReference as failure:
            return {"reference": f"none: the {reference.NAME} failed: {failure}"}

    def _reference(self) -> str:
        effects, scene = self.simulation.effects, self.simulation.scene
        if not effects.friction:
            return "closed form of the frictionless contact"
        if not effects.coupling:
            return "closed form, which neglects coupling as this run does"
        if scene.is_decoupled:
            return "closed form, exact at the Holl ratio"
        return "closed form, which neglects the coupling of normal and tangential effects: a different problem"

    def table(self) -> str:
        """The results beside the closed form, for reading."""
        contact, loop, scales = self.simulation.contact, self.simulation.loop, self.scales
        summary = self.summary
        kind, deviation = "error", summary["errors"]
        if "differences" in summary:
            kind, deviation = "difference", summary["differences"]
        rows = [("contact half-width a [m]", summary["a"], contact.a * scales.length, deviation["a"])]
        if "c" in deviation:
            rows.append(("stick half-width c/a [-]", summary["c_over_a"], loop.c / loop.a, deviation["c"]))
        if "dissipated_energy" in deviation:
            theory = loop.dissipated_energy * scales.energy
            computed = summary["dissipated_energy"]
            rows.append(("energy per cycle [J/m]", computed, theory, deviation["dissipated_energy"]))
        lines = [f"{'':28s}{'computed':>16s}{'closed form':>16s}{'relative ' + kind:>22s}"]
        lines += [f"{name:28s}{value:16.8g}{theory:16.8g}{d:22.1e}" for name, value, theory, d in rows]
        for name in ("pressure", "traction", "slip"):
            if f"{name}_l2" in deviation:
                lines.append(f"{name + ', L2 over the contact, last state':60s}{deviation[name + '_l2']:22.1e}")
        if summary["errors"] and kind == "difference":
            lines.append("The closed form neglects the coupling that this run has. Errors against the reference:")
            lines += [f"{name:60s}{value:22.1e}" for name, value in summary["errors"].items()]
        lines.append(f"reference: {summary['reference']}")
        return "\n".join(lines)
