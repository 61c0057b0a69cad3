"""The discrete contact problem: its forms, residual and Jacobian on the half-plane.

Unknowns are the state ``u`` of the body and the rigid indenter's two displacements ``delta = (delta_x, delta_y)``,
which the two line loads (Q, P) determine:

    K u - f(u, delta) = 0  in the body,     sum of the contact tractions in f = (Q, P).
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from dolfinx.la import InsertMode
from mpi4py import MPI
from petsc4py import PETSc

from forms import contact

from .body import HalfPlane, X, Y

NO_CELLS = np.array([], dtype=np.int32)  # for dolfinx: the cells of the source are those of the target
OPEN, BACKWARD, CLOSED, FORWARD = 0, 1, 2, 3  # contact states: sliding along -x, closed or stuck, sliding along +x


@dataclass(frozen=True)
class Nitsche:
    """Parameters of the contact terms: gamma = gamma0 degree^2 E/((1-nu^2) h), and the variant theta."""

    gamma0: float = 10.0
    theta: float = 0.0


class ContactProblem:
    """Contact of a half-plane with the indenter as residual and Jacobian, with the effects it is asked for.

    height: numpy function of x, the indenter's profile f(x). ``directions`` lists the contact tractions in the forms,
    each with its rigid displacement: (Y,) without friction; (X, Y) with; (X,) for the tangential problem uncoupled
    from the normal one, whose pressure and displacement ``hold_pressure`` then keeps.
    """

    def __init__(self, body: HalfPlane, height, nitsche: Nitsche, directions: tuple[int, ...]):
        self.body, self.directions = body, directions
        self.friction = X in directions
        self.all_stick = fem.Constant(body.mesh, 0.0)  # 1 in the predictor
        self.held_forces = self.held_state = None
        ds = body.surface_measure
        test, du = ufl.TestFunction(body.space), ufl.TrialFunction(body.space)
        v, _ = body.split(test)
        u, pi = body.u, body.pi
        if Y not in directions:
            self.held_state = fem.Function(body.space)
            held_u, held_pi = body.split(self.held_state)
            u, pi = u - held_u, None if pi is None else pi - held_pi

        gamma = body.constant(nitsche.gamma0 * body.degree**2) * body.surface_modulus() / body.cell_height
        traction = body.traction(u, pi)
        tractions = {}
        if Y in directions:
            # of the displacements' degree: the contact terms live at their nodes
            profile = fem.Function(fem.functionspace(body.mesh, ("Lagrange", body.degree)))
            profile.interpolate(lambda x: height(x[0]), body.strip_cells)  # it may end beyond
            gap = contact.gap(u, profile, body.delta)
            pressure = tractions[Y] = contact.contact_pressure(traction, gap, gamma)
            self._pressure = self._expression(pressure)
            self._clearance = self._expression(contact.clearance(traction, gap, gamma))
            self._clearances = self._point_values("clearance")
        else:
            pressure = self._held_pressure = self._point_values("pressure")
            self._clearances = self._point_values("clearance")
        closed = ufl.conditional(ufl.gt(pressure, 0.0), float(CLOSED), float(OPEN))
        if self.friction:
            self.mu = fem.Constant(body.mesh, 0.0)
            self.anchor = self._point_values("anchor")
            self.at_rest = self._point_values("contact state at rest")
            self.lagged = fem.Constant(body.mesh, 0.0)  # 1: friction is limited by a pressure that is kept
            if Y in directions:
                self._lagged_pressure = self._point_values("lagged pressure")
                pressure = ufl.conditional(ufl.gt(self.lagged, 0.5), self._lagged_pressure, pressure)
            s = contact.relative_displacement(u, body.delta)
            trial = contact.trial_traction(traction, s, self.anchor, gamma)
            self._slid, self._scratch = self._point_values("slid"), self._point_values("scratch")
            limit = self.mu * pressure
            sliding = contact.slides(trial, limit, self._slid)
            self._sliding = self._expression(sliding)
            self._beyond = self._expression(contact.slip_beyond_limit(trial, limit, gamma))
            closed = ufl.conditional(ufl.gt(closed, 1.0), closed + sliding, 0.0)
            tractions[X] = contact.coulomb(trial, pressure, limit, sliding, self.all_stick)
            self._rest = self._expression(contact.rest_position(traction, s, tractions[X], gamma))
            self._released = self._expression(contact.rest_position(traction, s, 0.0, gamma))

        work = sum(contact.work(tractions[i], v, i) * ds for i in directions)
        forces = work
        if nitsche.theta:
            for i in directions:
                traction_test = ufl.derivative(traction[i], body.state, test)
                theta = body.constant(nitsche.theta)
                forces += contact.consistency(traction[i], tractions[i], traction_test, theta, gamma) * ds
        sides = 2.0 if body.is_half else 1.0
        self._forces_form = forces
        self._resultant_forms = [sides * tractions[i] * ds for i in directions]
        self._forces = fem.form(forces)
        self._force_tangent = fem.form(ufl.derivative(-forces, body.state, du))
        self._strip_tangent = fem.create_matrix(self._force_tangent)
        self._nodal = fem.form(work) if nitsche.theta else self._forces
        self._tributary = fem.form(v[Y] * ds)
        self._work = fem.Function(body.space)
        self._contact_state = self._expression(closed)
        self._state_values = self._point_values("contact state")
        self._surface_points = self._owned_surface_points()
        # A displacement's last digit, times gamma and a node's length of surface, is a contact force.
        self.force_per_digit = np.finfo(float).eps * self._vector(fem.form(gamma * v[Y] * ds)).norm()

    @cached_property
    def _resultants(self):
        return [fem.form(r) for r in self._resultant_forms]

    @cached_property
    def _borders(self):
        """Columns, rows and corner of the rigid displacements as forms; only the full method needs them."""
        body, test = self.body, ufl.TestFunction(self.body.space)
        along = [body.translations[i] for i in self.directions]
        # The indenter enters through u - delta alone, so d/d(delta_i) is minus the derivative along a translation.
        columns = [fem.form(ufl.derivative(self._forces_form, body.state, e)) for e in along]
        rows = [fem.form(ufl.derivative(r, body.state, test)) for r in self._resultant_forms]
        corner = [[fem.form(-ufl.derivative(r, body.state, e)) for e in along] for r in self._resultant_forms]
        return columns, rows, corner

    # --- residual and Jacobian -----------------------------------------------------------------------------

    def create_matrix(self) -> PETSc.Mat:
        """A matrix for ``assemble_jacobian``."""
        return self.body.constrained_stiffness.copy()

    def residual(self, load) -> tuple[PETSc.Vec, np.ndarray]:
        """Force residual (owned dofs) and load imbalance, one per direction, at line loads ``(Q, P)``."""
        self.body.complete()
        internal = self.body.stiffness.createVecLeft()
        self.body.stiffness.mult(self.body.state.x.petsc_vec, internal)
        internal.axpy(-1.0, self._vector(self._forces))
        if self.held_forces is not None:
            internal.array[self._owned(Y)] -= self.held_forces
        fem_petsc.set_bc(internal, self.body.boundary_conditions, x0=self.body.state.x.petsc_vec, alpha=-1.0)
        total = np.array([self._sum(form) for form in self._resultants])
        return internal, total - np.array([load[i] for i in self.directions])

    def assemble_jacobian(self, matrix: PETSc.Mat):
        """Overwrite ``matrix`` with d(force residual)/du."""
        self.body.constrained_stiffness.copy(matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        fem_petsc.assemble_matrix(matrix, self._force_tangent, bcs=self.body.boundary_conditions)
        matrix.assemble()

    def force_tangent(self):
        """Minus d(contact forces)/du as a scipy matrix of local (owned and ghost) dofs: this rank's facets only.

        Not summed over ranks: a row of another rank has columns here that this rank does not know.
        """
        self._strip_tangent.set_value(0.0)
        fem.assemble_matrix(self._strip_tangent, self._force_tangent)
        return self._strip_tangent.to_scipy(ghosted=True)

    def borders(self):
        """Columns and rows (lists of Vec) and corner (m, m) that the rigid displacements add to the Jacobian."""
        columns, rows, corner = self._borders
        columns = [self._vector(form) for form in columns]
        for column in columns:
            fem_petsc.set_bc(column, self.body.boundary_conditions, alpha=0.0)
        corner = np.array([[self._sum(form) for form in row] for row in corner])
        return columns, [self._vector(form) for form in rows], corner

    def contact_forces(self, nodes=slice(None)) -> np.ndarray:
        """Contact forces along x and y on owned ``nodes``, (n, 2); zero along a direction without a term."""
        return self._on_strip(self._nodal)[self.body.dofs[: self.body.owned_nodes][nodes]]

    def nodal_forces(self, direction: int, nodes=slice(None)) -> np.ndarray:
        """Contact force along x (0) or y (1) on owned ``nodes``, (n,), that of a pressure held included."""
        if direction == Y and self.held_forces is not None:
            return self.held_forces[nodes]
        return self.contact_forces(nodes)[:, direction]

    def contact_states(self) -> np.ndarray:
        """At the surface points of this rank's cells (m,): OPEN, CLOSED, FORWARD or BACKWARD."""
        self._interpolate(self._state_values, self._contact_state)
        return self._state_values.x.array[self._surface_points]

    def round_off(self) -> float:
        """Norm of the contact forces that the last digits of the present displacement make: no residual gets below."""
        u = self.body.state.x.array[self._surface_dofs]
        size = max(np.abs(u).max(initial=0.0), np.abs(self.body.delta.value).max())
        return self.force_per_digit * self.body.mesh.comm.allreduce(size, MPI.MAX)

    def tributary_lengths(self) -> np.ndarray:
        """Length of surface that belongs to every owned node, (n,); zero off the strip."""
        return self._on_strip(self._tributary)[self._owned(Y)]

    def lag_pressure(self):
        """Keep the present pressure as the limit of friction while ``lagged`` is 1."""
        self._interpolate(self._lagged_pressure, self._pressure)

    def note_sliding(self):
        """Remember where points slide now: until ``forget_sliding`` none turns round without sticking in between."""
        self._interpolate(self._slid, self._sliding)

    def slip_beyond_limit(self) -> np.ndarray:
        """How far the surface points of this rank's cells slide beyond where friction stops them (m,) [length]."""
        self._interpolate(self._scratch, self._beyond)
        return self._scratch.x.array[self._surface_points]

    def hold(self, which: np.ndarray):
        """Let those surface points of this rank's cells (bool (m,)) not slide until ``note_`` or ``forget_sliding``."""
        self._slid.x.array[self._surface_points[which]] = contact.HELD
        self._slid.x.scatter_forward()

    def forget_sliding(self):
        """Coulomb's law as it is."""
        self._slid.x.array[:] = 0.0

    # --- memory of the slip --------------------------------------------------------------------------------

    def release(self):
        """Start friction here: no tangential traction, and none of the present displacement is slip."""
        self._move_anchor(self._released)

    def come_to_rest(self):
        """End an increment: anchor every point where it stopped (return mapping)."""
        self.contact_states()
        self.at_rest.x.array[:] = self._state_values.x.array
        self._move_anchor(self._rest)

    def states_at_rest(self) -> np.ndarray:
        """``contact_states`` when the last increment ended; OPEN before the first."""
        return self.at_rest.x.array[self._surface_points]

    def rest_positions(self) -> np.ndarray:
        """Where the surface points of this rank's cells would be anchored now (m,)."""
        self._interpolate(self._scratch, self._rest)
        return self._scratch.x.array[self._surface_points]

    def anchors(self) -> np.ndarray:
        """Anchors of the surface points of this rank's cells (m,)."""
        return self.anchor.x.array[self._surface_points]

    def clearances(self) -> np.ndarray:
        """How far the surface points of this rank's cells are from touching (m,), zero in contact [length]."""
        if Y in self.directions:
            self._interpolate(self._clearances, self._clearance)
        return self._clearances.x.array[self._surface_points]

    def move_anchors(self, which: np.ndarray, positions: np.ndarray):
        """Anchor those surface points of this rank's cells (bool (m,)) at these positions (m,)."""
        self.anchor.x.array[self._surface_points[which]] = positions[which]
        self.anchor.x.scatter_forward()

    def surface_abscissae(self) -> tuple[np.ndarray, np.ndarray]:
        """x of the surface points of this rank's cells (m,), and of the middles of their cells."""
        body = self.body
        cells = body.strip_cells[body.strip_cells < body.mesh.topology.index_map(2).size_local]
        dofs = body.point_space.dofmap.list[cells]
        x = body.point_space.tabulate_dof_coordinates()[dofs, X]
        middle = np.broadcast_to(x.mean(axis=1)[:, None], x.shape)
        return x[self._at_surface], middle[self._at_surface]

    def hold_pressure(self, normal: "ContactProblem"):
        """Keep the pressure and the displacement of the normal problem as they are now."""
        self.held_forces = normal.nodal_forces(Y)  # all of them for theta = 0
        self.held_state.x.array[:] = self.body.state.x.array
        self._interpolate(self._held_pressure, normal._pressure)
        self._interpolate(self._clearances, normal._clearance)

    def held(self) -> tuple[fem.Function, fem.Function, np.ndarray | None]:
        """What ``hold_pressure`` keeps: state, pressure and nodal forces."""
        return self.held_state, self._held_pressure, self.held_forces

    def without_held(self) -> np.ndarray:
        """Take the tangential problem's part out of the state, which is then that of the normal problem."""
        tangential = self.body.state.x.array - self.held_state.x.array
        self.body.state.x.array[:] = self.held_state.x.array
        return tangential

    def _owned_surface_points(self):
        """Dofs of the point space on the strip, those of cells that this rank owns."""
        body = self.body
        cells = body.strip_cells[body.strip_cells < body.mesh.topology.index_map(2).size_local]
        dofs = body.point_space.dofmap.list[cells]
        depth = body.point_space.tabulate_dof_coordinates()[dofs, Y]
        height = body.cell_height.x.array[body.cell_height.function_space.dofmap.list[cells]]
        nodes = fem.locate_dofs_topological(body.displacements, 1, body.strip)
        self._surface_dofs = body.dofs[nodes].ravel()
        self._at_surface = depth < height / 4
        return dofs[self._at_surface]

    def _owned(self, direction):
        """Local dofs of one displacement of the nodes that this rank owns."""
        return self.body.dofs[: self.body.owned_nodes, direction]

    def _move_anchor(self, expression):
        self._interpolate(self.anchor, expression)

    def _interpolate(self, field, expression):
        # past the wrapper in Python (as of dolfinx 0.9), which is dearer than what it wraps
        field._cpp_object.interpolate(expression()._cpp_object, self.body.strip_cells, NO_CELLS)
        field.x.scatter_forward()

    def _point_values(self, name):
        """A field with a value of its own at every surface node of every cell."""
        return fem.Function(self.body.point_space, name=name)

    def _expression(self, value):
        """``value`` at the surface points, compiled when first wanted: most runs do not want all of them."""
        return cache(lambda: fem.Expression(value, self.body.point_space.element.interpolation_points()))

    def _on_strip(self, form) -> np.ndarray:
        """A linear form on the strip, assembled in place: owned dofs hold the sum over ranks."""
        array = self._work.x.array
        array[:] = 0.0
        fem.assemble_vector(array, form)
        self._work.x.scatter_reverse(InsertMode.add)
        return array

    def _vector(self, form) -> PETSc.Vec:
        vector = fem_petsc.assemble_vector(form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return vector

    def _sum(self, form) -> float:
        return self.body.mesh.comm.allreduce(fem.assemble_scalar(form), MPI.SUM)
