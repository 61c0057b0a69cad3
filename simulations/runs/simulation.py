"""From a scene to states: mesh, contact problem and load schedule put together. No files."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from mpi4py import MPI

from analytic import GradedHalfPlane, PressingWithFriction, normal_contact, point_force_displacement
from analytic.edge_exponents import edge_exponents
from forms.contact import X, Y

from ..fem.body import ElasticBody
from ..fem.contact_problem import ContactProblem, Nitsche
from ..fem.mesh import Grading, columns, create_mesh, layers
from ..fem.numbering import Numbering
from ..fem.parallel import on_root
from ..fem.surface import SurfaceSampler
from ..loading.stepping import LoadStepping, SolveError
from ..scene import Scene, SceneError, shown
from ..solvers.bulk_solver import FactorisationError
from ..solvers.condensed.surface_compliance import SurfaceCompliance
from ..solvers.condensed.system import CondensedSystem
from ..solvers.full import FullSystem
from ..solvers.newton import FORCE_TOLERANCE
from . import freeing, limits, warnings
from .checks import ZIGZAGS, largest_zigzag
from .critical_friction import why_no_answer
from .history import Entry, History
from .plan import Plan
from .timing import Stopwatch

# The far field that vanishes at infinity is a rigid translation of order 1/k and little else where k > 0 is small: its
# last digits would be contact forces. Below this k the field is measured from the depth of the domain, as for k <= 0.
SMALLEST_K_AT_INFINITY = 0.01


class Simulation(Plan):
    """A scene on a communicator, ready to run.

    ``history`` grows by one entry a load step while ``run`` is iterated; ``body`` then carries that entry's fields.
    """

    def __init__(
        self,
        comm,
        scene: Scene,
        cells: Grading | None = None,
        like: "Simulation | None" = None,
        watch: Stopwatch | None = None,
        tolerance: float = FORCE_TOLERANCE,
    ):
        """cells: of the mesh, where they are not those of the scene; like: a simulation whose mesh, stiffness and
        compliance this one takes over where its own would be equal (``graded_for``): it then ends that one; watch:
        what measures the phases; tolerance: Newton's, of forces and loads over P.
        """
        if not isinstance(comm, MPI.Comm) or comm == MPI.COMM_NULL:
            what = "an MPI communicator that this process is in, such as MPI.COMM_WORLD"
            raise SceneError(f"comm = {shown(comm)} is not allowed: {what}")
        super().__init__(scene, watch or Stopwatch())
        self.mesh_of = None if cells else self.graded_for  # what the mesh was graded for, where that is known
        shared = like if like and self.mesh_of and self.mesh_of == like.mesh_of else None
        limits.check_parameters(scene)
        limits.check_loads(scene, self.schedule)
        limits.check_output(scene, self.schedule, self.extent)
        if shared is None:
            freeing.earlier(comm)
            with self.watch("mesh"):
                self.cells = cells or on_root(comm, self.grading)
                mesh, facets = self._mesh(comm)
        with self.watch("forms"):  # compiles them the first time
            if shared is None:
                self.body = self._body(mesh, facets)
                freeing.later(self.body)
            else:
                self._take_over(shared)
            normal, frictional = self._problems()
        pressing, indenter = self.pressing_with_friction, self.scaled.indenter
        self.stepping = LoadStepping(
            normal,
            frictional,
            self._system,
            "friction in normal stage" in self.effects,
            tolerance,
            _stuck(pressing) if pressing else None,
            self.scaled.solid,
            self._zigzag,
        )
        self.body.delta.value[Y] = indenter.height(self._first_half_width())  # overlap there: where Newton starts
        self.sampler = SurfaceSampler(normal, self.mu, scene.friction and "coupling" not in self.effects)
        self.resumed = 0  # times
        # beside the edges of contact: the substrate's where a coating is thinner than the facets there
        k = scene.k if self.scaled.modulus.thickness > self.cells.edge_facet else 0.0
        order = indenter.order if pressing else None
        self.history = History(k, self.mu, order, self._exponents(k), self.is_coupled)

    @property
    def warnings(self) -> list[str]:
        """What theory or mesh show badly, one line each."""
        found = warnings.warnings_of(self.scene, self.cells, self.loop, self.scaled)
        return [*found, self.hidden_peak] if self.hidden_peak else found

    @cached_property
    def hidden_peak(self) -> str:
        """What to say of a peak of the pressure that is too narrow for the mesh; "" where it has none."""
        x, _ = self.ordinates
        middle = np.searchsorted(x, 0.0)
        spacing = float(x[middle + 1] - x[middle]) / self.scene.mesh.degree
        peak = warnings.hidden_peak(self.pressing_with_friction, spacing, self.scaled)
        return peak or warnings.hidden_tip(spacing, self.scaled)

    def _first_half_width(self) -> float:
        """Of the frictionless contact under the first load; of a coating not more than a, nearly."""
        load = self.schedule[0].P
        if load >= 1.0:
            return 1.0
        return min(normal_contact(self.scaled.solid, self.scaled.indenter.analytic(), load).a, 1.0)

    def _mesh(self, comm):
        """The mesh of the cells with its facet tags; ``ordinates`` are its columns and layers.

        SceneError where it would not do or would be too large.
        """
        limits.check_resolution(self.scene, self.cells, self.loop)
        limits.check_depth(self.scene, self.cells)
        law, x = self.scaled.modulus, columns(self.cells)
        if "symmetry" in self.effects:
            middle = len(x) // 2
            x = x[middle:] - x[middle]
        self.ordinates = x, layers(self.cells, law.depth_map(), law.kink_depths)
        self._check_size()
        return create_mesh(comm, *self.ordinates)

    def _check_size(self):
        limits.check_size(self.scene, self.cells, *(len(nodes) - 1 for nodes in self.ordinates))

    def _problems(self) -> tuple[ContactProblem, ContactProblem | None]:
        """The contact problems of the normal stage and of the stage with friction, if there is one."""
        scene, height = self.scene, self.scaled.indenter.height
        nitsche = Nitsche(scene.solver.gamma0, scene.solver.theta)
        normal = ContactProblem(self.body, height, nitsche, (Y,))
        limits.check_round_off(scene, self.cells, normal)
        if not scene.friction:
            return normal, None
        directions = (X, Y) if "coupling" in self.effects else (X,)
        elastic = self.scaled.elastic_compliance(scene)
        return normal, ContactProblem(self.body, height, nitsche, directions, self.mu, elastic)

    def _body(self, mesh, facets):
        scene = self.scene
        return ElasticBody(
            mesh,
            facets,
            self.scaled.modulus,
            scene.solid.nu,
            self._far_field(),
            self.cells.strip,
            "incompressibility" in self.effects,
            self.effects.works(scene, self.scaled.scales),
            scene.mesh.degree,
            "bulk strain" in self.effects,
        )

    def _take_over(self, other: "Simulation"):
        """The body of ``other``, at rest."""
        self.cells, self.ordinates, self.body = other.cells, other.ordinates, other.body
        self._check_size()  # the other one may have no dense matrices
        self.body.reset()
        if other.scene.solver.method == "condensed":
            self._compliance = other._compliance

    def run(self) -> Iterator[Entry]:
        """Solve load step after load step, from where the history ends; SolveError where one fails."""
        outcomes = self.stepping.run(self.schedule, len(self.history.entries))
        while True:
            try:
                with self.watch("solve"):
                    outcome = next(outcomes, None)
            except (SolveError, FactorisationError) as error:
                cause = why_no_answer(self) if self.stepping.problem.friction else limits.too_stiff(self.scene)
                raise SolveError("; ".join(filter(None, (failure_in_si(self, error), cause)))) from None
            freeing.between_steps(self.body)
            if outcome is None:
                return
            state = self.sampler.sample(self.stepping.problem)
            if state.pressure[0] > 0 or state.pressure[-1] > 0:
                raise SolveError(failure_in_si(self, limits.too_wide(self.scene, self.cells.strip)))
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
        try:
            if self.scene.solver.method == "full":
                return FullSystem(problem)
            return CondensedSystem(problem, self._compliance)
        except FactorisationError as error:
            raise SolveError(str(error)) from None

    @cached_property
    def _compliance(self):
        return SurfaceCompliance(self.body)

    def _zigzag(self) -> float:
        return largest_zigzag(self.sampler.sample(self.stepping.problem)) / ZIGZAGS

    def _exponents(self, k):
        """Of tractions at edges where coupling changes them, see ``History``; k: beside these edges."""
        if "coupling" not in self.effects:
            return None
        solid = replace(self.scaled.solid, k=k)
        return partial(edge_exponents, solid)

    def _far_field(self):
        """Displacement of line loads: far away a coating is not seen."""
        solid, extent = self.scaled.solid, self.cells.extent
        if not self.scene.is_power_law:
            below = self.scaled.modulus.young(extent)
            solid = GradedHalfPlane(E0=float(below), nu=solid.nu, k=0.0, y0=1.0)
        fixed_depth = None if solid.k >= SMALLEST_K_AT_INFINITY else extent
        return partial(point_force_displacement, solid, fixed_depth=fixed_depth)


def _stuck(pressing: PressingWithFriction):
    """Where points stick while P grows, as a function of P and x; None where it is not known."""
    # for k < 0 the mesh's own edge of stick lies further inside than the exact one, and points between would zigzag
    if pressing.solid.k < 0:
        return None
    return lambda P, x: replace(pressing, P=P).stick_displacement(x)


def failure_in_si(simulation: Simulation, reason) -> str:
    """Why the next load step failed, with its loads in SI units and the keys of the scene that they come from."""
    scene, unit, number = simulation.scene, simulation.scaled.scales.line_load, len(simulation.history.entries)
    step = simulation.schedule[number]
    P, Q, _ = getattr(reason, "after", None) or step.load
    loads = f"P = {P * unit:.4g} N/m, Q = {Q * unit:.4g} N/m"
    keys = ", ".join(f"load.{name} = {value:g}" for name, value in scene.load if name in ("P", "amplitude", "mu"))
    place = f"load step {number + 1} of {len(simulation.schedule)}, {step.branch}"
    return f"{loads} ({place}; {keys or 'load.points'}): {reason}"
