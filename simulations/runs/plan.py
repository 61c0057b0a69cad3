"""Plan of a run before anything is meshed: scaled problem, closed forms, load schedule, wanted cell sizes."""

from dataclasses import astuple, replace
from functools import cached_property

import numpy as np

from analytic import PowerProfile, PressingWithFriction, StretchedLoop

from ..fem.edge_place import best_place, vanishing_place
from ..fem.load import Load
from ..fem.mesh import Grading
from ..loading.schedule import LoadStep, pressing, rocking, stretched, visiting
from ..scene import Scene
from ..scene.effects import Effects
from ..scene.scaling import Scaled
from .coupled_loop import grades, loop_edges
from .expected_edges import ROUGH_QUARTER, ExpectedEdges, expected_edges
from .stretched_edges import exact_edges, rough_edges
from .timing import Stopwatch

# The far field is known less well where a coating is not in it, or where coupling moves the contact aside and with it
# the line on which P acts (k = -0.5: 8 % of a, which costs 8e-3 in p at 20 a), or where bulk strain moves the traction
# aside (k = -0.3: 5e-4 in slip and energy): it is prescribed that much further away. What a line aside adds decays like
# distance^-(1+k), so that coupled scenes with k < 0 want more (k = -0.5, slip: 4e-4 at 100 a, 1.3e-4 at 200 a).
FARTHER = 5.0
LARGEST_POWER = 1.43  # of the exponents 1/(1+k) that FARTHER gets: beyond 200 a tractions zigzag at k = -0.9
STUCK_TERMS = 8  # of the exact contact pressed on with friction: 1e-5 of the displacement or better


class Plan:
    """A scene in scaled units.

    ``contact``, ``loop`` and, with bulk strain, ``stretched`` are the closed forms, None where there are none;
    ``watch`` has the seconds spent in each phase.
    """

    def __init__(self, scene: Scene, watch: Stopwatch):
        self.scene, self.effects, self.watch = scene, Effects(scene), watch
        self.scaled = Scaled.of(scene)
        scales = self.scaled.scales
        self._strain = scene.bulk_strain * scales.length / scales.displacement  # as a Load has it
        self.contact, self.mu = self.scaled.contact, scene.mu
        self.loop = None
        if scene.is_loop and self.contact:
            self.loop = self.contact.fretting(mu=self.mu, z=1.0 - scene.load.amplitude)
        self.stretched = None
        if self.loop and "bulk strain" in self.effects and scene.stretched_loop:
            self.stretched = StretchedLoop(self.loop, self._strain)
        self.schedule = self._schedule()

    @property
    def is_coupled(self) -> bool:
        """True where coupling is on and does not vanish, as it does at the Holl ratio."""
        return "coupling" in self.effects and not self.scene.is_decoupled

    @cached_property
    def pressing_with_friction(self) -> PressingWithFriction | None:
        """The exact contact under P = 1 where it is pressed on with friction and grows similar to itself, else None."""
        on = self.effects
        alike = "friction in normal stage" in on and "coupling" in on and self.scene.is_power_law
        profile = self.scaled.indenter.analytic() if alike and not on.without_closed_form else None
        if not isinstance(profile, PowerProfile):
            return None
        return PressingWithFriction(self.scaled.solid, profile, self.mu, 1.0, STUCK_TERMS)

    @property
    def graded_for(self) -> tuple | None:
        """What mesh and stiffness of a scene depend on, numbers to 12 digits: where it is equal, these are; None where
        it is not known.

        In the closed forms Q and strain count over mu alone, as slip does: beyond them mu counts too.
        """
        scene, law, mu = self.scene, self.scaled.modulus, self.mu or 1.0
        if scene.indenter.profile != "parabola" or self.effects.works(scene, self.scaled.scales):
            return None
        numbers = [*np.hstack(astuple(law)), scene.solid.nu]  # type: ignore[call-overload]
        for step in self.schedule:
            numbers += [step.P, step.Q / mu, step.load.strain / mu, bool(step.state)]
        if not self.effects.has_closed_form:
            numbers += [mu, self.scaled.elastic_compliance(scene)]
        on = tuple(name for name, verdict in self.effects.verdicts.items() if verdict.on)
        # of a path without friction the load steps do not tell which of them are its points
        kind = type(law), on, scene.is_loop, scene.bulk_phase, scene.is_path and scene.solver.increments
        mesh = scene.mesh.degree, scene.mesh.edges, *scene.cell_sizes.items()
        return *kind, *mesh, *(float(f"{number:.12g}") for number in numbers)

    @property
    def extent(self) -> float:
        """Half-width and depth of the domain."""
        scene = self.scene
        if not scene.is_power_law:
            return scene.mesh.extent * FARTHER * max(1.0, self.scaled.modulus.thickness)
        if self.is_coupled:
            return scene.mesh.extent * FARTHER ** min(max(1.0, 1.0 / (1.0 + scene.k)), LARGEST_POWER)
        return scene.mesh.extent * (FARTHER if "bulk strain" in self.effects else 1.0)

    def grading(self) -> Grading:
        """Cell sizes of the scene, graded to where contact and stick zone are expected to end."""
        scene = self.scene
        with self.watch("edges"):
            found = self._edges()
        sizes = scene.cell_sizes | {"extent": self.extent}
        if found.exact:
            sizes.setdefault("edge_at", best_place(scene.mesh.degree, scene.k))
        elif found.pressed:
            sizes.setdefault("edge_at", vanishing_place(scene.mesh.degree, scene.k))
        edges = {*found.edges, *(-e for e in found.edges)}
        sweeps = found.sweeps(scene.k, sizes["facet"], sizes["edge_facet"])
        return Grading(edges=tuple(sorted(edges)), sweeps=sweeps, unknown=found.unknown, **sizes)

    def _edges(self) -> ExpectedEdges:
        """Where contact and stick zone are expected to end."""
        scene = self.scene
        if "bulk strain" in self.effects:
            if self.stretched and self.effects.has_closed_form:
                return exact_edges(self.stretched, [step.load for step in self.schedule])
            loads = [step.load for step in self._loop(min(scene.cycles, 1), ROUGH_QUARTER, pressing(1.0))]
            return rough_edges(scene, self.scaled, self.effects, loads)
        found = None
        if grades(scene, self.effects):
            found = loop_edges(scene, self.scaled, self.effects, self.schedule)
        found = found or expected_edges(scene, self.scaled, self.loop, self.effects, self.schedule)
        exact = self.pressing_with_friction
        if exact and scene.is_loop and scene.k < 0:  # where contact ends steeply
            normal = (step.P for step in self.schedule if step.branch == "normal")
            found = replace(found, pressed=tuple(replace(exact, P=P).contact_half_width for P in normal))
        return found

    def _schedule(self):
        scene = self.scene
        steps = scene.solver.normal_increments if "friction in normal stage" in self.effects else 1
        exact = self.pressing_with_friction
        power = exact.power if exact else 2.0  # a(P) is not known
        if scene.is_path:
            points = [Load(P / scene.P, Q / scene.P) for P, Q in scene.load.points]
            first, *rest = points
            return pressing(first.P, steps, power) + visiting(first, rest, scene.solver.increments)
        if not scene.friction:
            return pressing(1.0)
        return self._loop(scene.load.cycles, scene.solver.increments, pressing(1.0, steps, power))

    def _loop(self, cycles: int, quarter: int, normal: list[LoadStep]) -> list[LoadStep]:
        """The normal stage and rocking, ``quarter`` load steps per Q_A."""
        scene = self.scene
        strained = "bulk strain" in self.effects
        harmonic = strained and scene.load.strain_lags  # else Q and strain go straight
        schedule = normal + rocking(1.0, scene.load.amplitude * self.mu, cycles, quarter, harmonic)
        return stretched(schedule, self._strain, scene.bulk_phase) if strained else schedule
