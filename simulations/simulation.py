"""From a scene to states: mesh, contact problem and load programme put together. No files."""

from collections.abc import Iterator

from analytic import CylinderContact, FrettingLoop
from analytic.point_force import point_force_displacement
from forms.modulus import PowerLaw

from .condensed import Compliance, CondensedSystem
from .full import FullSystem
from .history import Entry, History
from .mesh import Grading, columns, half_plane, layers
from .observables import SurfaceSampler
from .problem import Y, ContactProblem, HalfPlane, Nitsche
from .programme import LoadProgramme, fretting_programme
from .scaling import Scales, scaled_solid
from .scene import Scene
from .timing import Stopwatch


def dimensionless_loop(scene: Scene) -> FrettingLoop:
    """The closed-form loop of a scene in scaled units: a = 1, R = 1, E = y^k."""
    P = scene["load.P"] / Scales.of(scene).line_load
    contact = CylinderContact(scaled_solid(scene), R=1.0, P=P)
    return contact.fretting(mu=scene["load.mu"], z=1.0 - scene["load.amplitude"])


def grading(scene: Scene, loop: FrettingLoop) -> Grading:
    """Cell sizes of a scene, graded to the contact and stick edges that the closed form expects."""
    return Grading(edges=(-loop.a, -loop.c, loop.c, loop.a), **scene.section("mesh"))


def parabola(x):
    """The cylinder (41) in scaled units, f = x²/2."""
    return x**2 / 2


class Simulation:
    """A scene on a communicator, ready to run.

    ``history`` grows by one entry an increment while ``run`` is iterated; ``body`` then carries that entry's fields.
    ``watch`` has the seconds spent in each phase.
    """

    def __init__(self, comm, scene: Scene, cells: Grading | None = None):
        self.scene, self.loop = scene, dimensionless_loop(scene)
        self.watch = Stopwatch()
        with self.watch("mesh"):
            modulus = PowerLaw(scene["solid.k"])
            cells = cells or grading(scene, self.loop)
            bottom = modulus.depth_map().s(cells.extent)
            mesh, facets = half_plane(comm, columns(cells), layers(cells, bottom))
        with self.watch("forms"):  # compiles them the first time
            self.body = HalfPlane(mesh, facets, modulus, scene["solid.nu"], self._far_field(cells.extent))
            nitsche = Nitsche(scene["solver.gamma0"], scene["solver.theta"])
            stages = [ContactProblem(self.body, parabola, nitsche, friction) for friction in (False, True)]
        with self.watch("solve"):
            self._solver = LoadProgramme(*stages, self._choose_system(), mu=scene["load.mu"])
        self.body.delta.value[Y] = 0.5  # overlap on |x| < a: where Newton starts
        self._sampler = SurfaceSampler(self.body, stages[0])
        self.history = History(k=scene["solid.k"], mu=scene["load.mu"])
        P, Q_A = self.loop.contact.P, self.loop.Q_A
        self.programme = fretting_programme(P, Q_A, scene["load.cycles"], scene["solver.increments"])

    def run(self) -> Iterator[Entry]:
        """Solve increment after increment; SolveError where one fails."""
        outcomes = self._solver.run(self.programme)
        while True:
            with self.watch("solve"):
                outcome = next(outcomes, None)
            if outcome is None:
                return
            state = self._sampler.sample(self._solver.problem)
            yield self.history.append(outcome, state, self.watch.last)

    def _choose_system(self):
        if self.scene["solver.method"] == "full":
            return FullSystem
        compliance = Compliance(self.body)
        return lambda problem: CondensedSystem(problem, compliance)

    def _far_field(self, extent):
        solid = scaled_solid(self.scene)
        fixed_depth = None if solid.k > 0 else extent

        def displacement(x, y, **load):
            return point_force_displacement(solid, x, y, fixed_depth=fixed_depth, **load)

        return displacement
