"""From a scene to states: mesh, contact problem and load programme put together. No files."""

from collections.abc import Iterator
from functools import cached_property

from analytic import GradedHalfPlane, point_force_displacement

from ..fem.body import HalfPlane, X, Y
from ..fem.contact_problem import ContactProblem, Nitsche
from ..fem.mesh import Grading, columns, half_plane, layers
from ..fem.numbering import Numbering
from ..fem.parallel import on_root
from ..fem.surface import SurfaceSampler
from ..loading.schedule import pressing, rocking, visiting
from ..loading.stepping import LoadProgramme, SolveError
from ..scene.effects import Effects
from ..scene.scaling import Scaled
from ..scene.scene import Scene
from ..solvers.condensed.compliance import Compliance
from ..solvers.condensed.system import CondensedSystem
from ..solvers.full import FullSystem
from . import freeing
from .expected_edges import expected_edges
from .history import Entry, History
from .limits import check_parameters, check_resolution, check_round_off, check_size
from .reuse import reuse_reason
from .timing import Stopwatch

# The far field is known less well where a coating is not in it, or where coupling moves the contact aside and with it
# the line on which P acts (k = -0.5: 8 % of a, which costs 8e-3 in p at 20 a): it is prescribed that much further away.
FARTHER = 5.0


class Plan:
    """What a scene asks for, in scaled units, before anything is meshed.

    ``contact`` and ``loop`` are the closed forms, None where there are none; ``watch`` has the seconds spent in each
    phase.
    """

    def __init__(self, scene: Scene, watch: Stopwatch):
        self.scene, self.effects, self.watch = scene, Effects(scene), watch
        self.scaled = Scaled.of(scene)
        self.contact, self.mu = self.scaled.contact, scene["load.mu"] if scene.friction else 0.0
        self.loop = None
        if scene.is_loop and self.contact:
            self.loop = self.contact.fretting(mu=self.mu, z=1.0 - scene["load.amplitude"])
        self.programme = self._programme()

    def grading(self) -> Grading:
        """Cell sizes of the scene, graded to where contact and stick zone are expected to end."""
        scene = self.scene
        loads = [(increment.P, increment.Q) for increment in self.programme]
        with self.watch("edges"):
            found = expected_edges(scene, self.scaled, self.loop, self.effects, loads)
        sizes = scene.cell_sizes
        if not scene.is_power_law:
            sizes["extent"] *= FARTHER * max(1.0, self.scaled.modulus.thickness)
        elif "coupling" in self.effects and not scene.is_decoupled:
            sizes["extent"] *= FARTHER
        edges = {*found.edges, *(-e for e in found.edges)}
        sweeps = found.sweeps(scene.k, sizes["facet"], sizes["edge_facet"])
        return Grading(edges=tuple(sorted(edges)), sweeps=sweeps, **sizes)

    def _programme(self):
        scene = self.scene
        steps = scene["solver.normal_increments"] if "friction in normal stage" in self.effects else 1
        if "load.points" in scene.values:
            points = [(P / scene.P, Q / scene.P) for P, Q in scene["load.points"]]
            first, *rest = points
            return pressing(first[0], steps) + visiting(first, rest, scene["solver.increments"])
        if not scene.friction:
            return pressing(1.0)
        Q_A = scene["load.amplitude"] * self.mu
        return pressing(1.0, steps) + rocking(1.0, Q_A, scene["load.cycles"], scene["solver.increments"])


class Simulation(Plan):
    """A scene on a communicator, ready to run.

    ``history`` grows by one entry an increment while ``run`` is iterated; ``body`` then carries that entry's fields.
    """

    planned = staticmethod(lambda scene: Plan(scene, Stopwatch()))

    def __init__(
        self,
        comm,
        scene: Scene,
        cells: Grading | None = None,
        like: "Simulation | None" = None,
        watch: Stopwatch | None = None,
    ):
        """cells: of the mesh, where they are not those of the scene; like: a simulation of the same solid, whose
        mesh, stiffness and compliance this one takes over where they do (``reuse_reason``), whatever its loads, friction
        and cylinder: it then ends that one; watch: what measures the phases.
        """
        super().__init__(scene, watch or Stopwatch())
        check_parameters(scene)
        if like is None:
            freeing.earlier(comm)
            with self.watch("mesh"):
                self.cells = cells or on_root(comm, self.grading)
                check_resolution(scene, self.cells, self.loop)
                self.ordinates = self._ordinates()
                check_size(scene, self.cells, *(len(nodes) - 1 for nodes in self.ordinates))
                mesh, facets = half_plane(comm, *self.ordinates)
        with self.watch("forms"):  # compiles them the first time
            if like is None:
                self.body = self._body(mesh, facets)
                freeing.later(self.body)
            else:
                self._take_over(like)
            nitsche = Nitsche(scene["solver.gamma0"], scene["solver.theta"])
            indenter = self.scaled.indenter
            normal = ContactProblem(self.body, indenter.height, nitsche, (Y,))
            check_round_off(scene, self.cells, normal)
            frictional = None
            if scene.friction:
                directions = (X, Y) if "coupling" in self.effects else (X,)
                frictional = ContactProblem(self.body, indenter.height, nitsche, directions)
        self.solver = LoadProgramme(
            normal, frictional, self._system, self.mu, "friction in normal stage" in self.effects
        )
        self.body.delta.value[Y] = indenter.height(1.0)  # overlap on |x| < a: where Newton starts
        self.sampler = SurfaceSampler(self.body, normal, scene.friction and "coupling" not in self.effects)
        self.resumed = 0  # times
        self.history = History(k=scene.k, mu=self.mu)

    def _ordinates(self):
        """Columns and layers of the mesh."""
        law, x = self.scaled.modulus, columns(self.cells)
        if "symmetry" in self.effects:
            middle = len(x) // 2
            x = x[middle:] - x[middle]
        return x, layers(self.cells, law.depth_map(), law.thickness)

    def _body(self, mesh, facets):
        scene = self.scene
        return HalfPlane(
            mesh,
            facets,
            self.scaled.modulus,
            scene["solid.nu"],
            self._far_field(),
            self.cells.strip,
            "incompressibility" in self.effects,
            self.effects.works(scene, self.scaled.scales),
            scene["mesh.degree"],
        )

    def _take_over(self, other: "Simulation"):
        """The body of ``other``, at rest; ValueError where this scene cannot be run on it."""
        reason = reuse_reason(other, self.scene)
        if reason:
            raise ValueError(f"the body cannot be taken over: {reason}")
        self.cells, self.ordinates, self.body = other.cells, other.ordinates, other.body
        self.body.reset()
        if other.scene["solver.method"] == "condensed":
            self._compliance = other._compliance

    def run(self) -> Iterator[Entry]:
        """Solve increment after increment, from where the history ends; SolveError where one fails."""
        outcomes = self.solver.run(self.programme, len(self.history.entries))
        while True:
            try:
                with self.watch("solve"):
                    outcome = next(outcomes, None)
            except SolveError as error:
                raise SolveError(failure_in_si(self, error)) from None
            if outcome is None:
                return
            state = self.sampler.sample(self.solver.problem)
            if state.pressure[0] > 0 or state.pressure[-1] > 0:
                strip = f"|x| < {self.cells.strip * self.scaled.scales.length:.3g} m"
                raise SolveError(
                    failure_in_si(self, f"the contact reaches the end of {strip}, in which it is looked for")
                )
            yield self.history.append(outcome, state, self.watch.last)

    def run_to_end(self) -> "Simulation":
        """``run``, for those who look at the end alone; the simulation itself."""
        for _ in self.run():
            pass
        return self

    @cached_property
    def numbering(self) -> Numbering:
        """Places of the nodes on the mesh, for files."""
        return Numbering(self.body, *self.ordinates)

    def _system(self, problem):
        if self.scene["solver.method"] == "full":
            return FullSystem(problem)
        return CondensedSystem(problem, self._compliance)

    @cached_property
    def _compliance(self):
        return Compliance(self.body)

    def _far_field(self):
        """Displacement of line loads: far away a coating is not seen."""
        solid, extent = self.scaled.solid, self.cells.extent
        if not self.scene.is_power_law:
            below = self.scaled.modulus.young(extent)
            solid = GradedHalfPlane(E0=float(below), nu=solid.nu, k=0.0, y0=1.0)
        fixed_depth = None if solid.k > 0 else extent

        def displacement(x, y, **load):
            return point_force_displacement(solid, x, y, fixed_depth=fixed_depth, **load)

        return displacement


def failure_in_si(simulation: Simulation, reason) -> str:
    """Why the next increment failed, with its loads in SI units and the keys of the scene that they come from."""
    scene, unit, number = simulation.scene, simulation.scaled.scales.line_load, len(simulation.history.entries)
    increment = simulation.programme[number]
    Q, P = getattr(reason, "load", None) or increment.load
    loads = f"P = {P * unit:.4g} N/m, Q = {Q * unit:.4g} N/m"
    keys = ", ".join(f"{k} = {scene[k]:g}" for k in ("load.P", "load.amplitude", "load.mu") if k in scene.values)
    place = f"increment {number + 1} of {len(simulation.programme)}, {increment.branch}"
    return f"{loads} ({place}; {keys or 'load.points'}): {reason}"
