"""From a scene to states: mesh, contact problem and load programme put together. No files."""

from collections.abc import Iterator
from functools import cached_property

from analytic import CylinderContact, FrettingLoop, point_force_displacement
from forms.modulus import PowerLaw

from .condensed import Compliance, CondensedSystem
from .effects import Effects
from .full import FullSystem
from .history import Entry, History
from .mesh import STRIP, Grading, columns, half_plane, layers
from .observables import SurfaceSampler
from .problem import ContactProblem, HalfPlane, Nitsche, X, Y
from .programme import LoadProgramme, SolveError, pressing, rocking
from .scaling import Scales, scaled_solid
from .scene import Scene
from .timing import Stopwatch


def dimensionless_contact(scene: Scene) -> CylinderContact:
    """The closed-form normal contact of a scene in scaled units: a = 1, R = 1, E = y^k."""
    P = scene["load.P"] / Scales.of(scene).line_load
    return CylinderContact(scaled_solid(scene), R=1.0, P=P)


def grading(scene: Scene, contact: CylinderContact, loop: FrettingLoop | None) -> Grading:
    """Cell sizes of a scene, graded to the contact and stick edges that the closed form expects."""
    edges = (contact.a,) if loop is None else (loop.c, contact.a)
    return Grading(edges=(*(-e for e in reversed(edges)), *edges), **scene.section("mesh"))


def parabola(x):
    """The cylinder (41) in scaled units, f = x²/2."""
    return x**2 / 2


class Simulation:
    """A scene on a communicator, ready to run.

    ``history`` grows by one entry an increment while ``run`` is iterated; ``body`` then carries that entry's fields.
    ``contact`` and ``loop`` are the closed forms in scaled units; ``watch`` has the seconds spent in each phase.
    """

    def __init__(self, comm, scene: Scene, cells: Grading | None = None):
        self.scene, self.effects, self.watch = scene, Effects(scene), Stopwatch()
        self.contact = dimensionless_contact(scene)
        self.loop = None
        if self.effects.friction:
            self.loop = self.contact.fretting(mu=scene["load.mu"], z=1.0 - scene["load.amplitude"])
        with self.watch("mesh"):
            modulus = PowerLaw(scene["solid.k"])
            cells = cells or grading(scene, self.contact, self.loop)
            x = columns(cells)
            if self.effects.symmetry:
                middle = len(x) // 2
                x = x[middle:] - x[middle]
            mesh, facets = half_plane(comm, x, layers(cells, modulus.depth_map()))
        with self.watch("forms"):  # compiles them the first time
            self.body = HalfPlane(mesh, facets, modulus, scene["solid.nu"], self._far_field(cells.extent))
            nitsche = Nitsche(scene["solver.gamma0"], scene["solver.theta"])
            normal = ContactProblem(self.body, parabola, nitsche, (Y,))
            frictional = None
            if self.effects.friction:
                directions = (X, Y) if self.effects.coupling else (X,)
                frictional = ContactProblem(self.body, parabola, nitsche, directions)
        mu = self.loop.mu if self.loop else 0.0
        first = self.effects.friction_in_normal_stage
        self.solver = LoadProgramme(normal, frictional, self._system, mu, first)
        self.body.delta.value[Y] = 0.5  # overlap on |x| < a: where Newton starts
        self.sampler = SurfaceSampler(self.body, normal)
        self.history = History(k=scene["solid.k"], mu=mu)
        self.programme = self._programme()

    def _programme(self):
        scene, P = self.scene, self.contact.P
        if self.loop is None:
            return pressing(P)
        stage = pressing(P, scene["solver.normal_increments"] if self.effects.friction_in_normal_stage else 1)
        return stage + rocking(P, self.loop.Q_A, scene["load.cycles"], scene["solver.increments"])

    def run(self) -> Iterator[Entry]:
        """Solve increment after increment; SolveError where one fails."""
        outcomes = self.solver.run(self.programme)
        while True:
            with self.watch("solve"):
                outcome = next(outcomes, None)
            if outcome is None:
                return
            state = self.sampler.sample(self.solver.problem)
            if state.pressure[0] > 0 or state.pressure[-1] > 0:
                raise SolveError(f"the contact reaches the end of the strip |x| < {STRIP} a in which it is looked for")
            yield self.history.append(outcome, state, self.watch.last)

    def _system(self, problem):
        if self.scene["solver.method"] == "full":
            return FullSystem(problem)
        return CondensedSystem(problem, self._compliance)

    @cached_property
    def _compliance(self):
        return Compliance(self.body)

    def _far_field(self, extent):
        solid = scaled_solid(self.scene)
        fixed_depth = None if solid.k > 0 else extent

        def displacement(x, y, **load):
            return point_force_displacement(solid, x, y, fixed_depth=fixed_depth, **load)

        return displacement
