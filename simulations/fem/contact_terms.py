"""The contact terms of the weak form, assembled: residual, tangent, nodal forces and resultants.

Unknowns are the state ``u`` of the body and the rigid indenter's two displacements ``delta = (delta_x, delta_y)``,
which the two line loads (Q, P) determine:

    K u - f(u, delta) = 0  in the body,     sum of the contact tractions in f = (Q, P).
"""

from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from dolfinx.la import InsertMode
from mpi4py import MPI
from petsc4py import PETSc

from forms import weak_form
from forms.contact import X, Y

from .body import ElasticBody
from .point_fields import HeldPressure
from .surface_points import PointExpression, SurfacePoints


class ContactTerms:
    """Residual and Jacobian of the body in contact.

    directions: of the contact tractions; held: pressure of the uncoupled tangential problem. ``forces`` is the form of
    f, and ``forces_form`` the compiled one; ``pressure`` and ``clearance`` (None where p is held) evaluate these at the
    surface points; ``force_per_digit`` is the norm of the forces that the last digits of a displacement of 1 make.
    """

    def __init__(self, points: SurfacePoints, law: weak_form.Contact, held: HeldPressure | None):
        body = points.body
        test, ds = ufl.TestFunction(body.space), body.surface_measure
        v, _ = body.split(test)
        forces = weak_form.contact_forces(law, body.state, test, v, ds)
        tangent = weak_form.contact_tangent(forces, body.state, ufl.TrialFunction(body.space))

        self.body: ElasticBody = body
        self.directions = tuple(sorted(law.tractions))
        self.held, self._points = held, len(points.dofs)
        self.pressure = PointExpression(points, law.tractions[Y]) if Y in law.tractions else None
        self.forces_form = fem.form(forces)
        self.forces, self._loads = forces, weak_form.resultants(law, ds, body.symmetry_factor)
        self._tangent_form = fem.form(tangent)
        self._strip_tangent = fem.create_matrix(self._tangent_form)
        self._work_form = fem.form(weak_form.contact_work(law, v, ds)) if law.nitsche.theta else self.forces_form
        self._tributary_form = fem.form(v[Y] * ds)
        self._vector_on_strip = fem.Function(body.space)
        self.clearance = None if law.clearance is None else PointExpression(points, law.clearance)
        self._state = PointExpression(points, law.state)
        self._trials = {i: PointExpression(points, trial) for i, trial in law.trials.items()}
        self._surface_dofs = body.dofs[body.surface_nodes.touched].ravel()
        # A displacement's last digit, times gamma and a node's length of surface, is a contact force.
        self.force_per_digit = np.finfo(float).eps * _vector(fem.form(law.nitsche.gamma * v[Y] * ds)).norm()

    @cached_property
    def resultant_forms(self):
        """Compiled forms of the resultants, one a direction; only the full method needs them."""
        return [fem.form(load) for load in self._loads]

    @cached_property
    def _border_forms(self):
        """Columns, rows and corner of the rigid displacements; only the full method needs them."""
        body, test = self.body, ufl.TestFunction(self.body.space)
        along = [body.translations[i] for i in self.directions]
        borders = weak_form.rigid_borders(self.forces, self._loads, body.state, test, along)
        return [fem.form(forms) for forms in borders]

    def residual(self, load) -> tuple[PETSc.Vec, np.ndarray]:
        """Force residual (owned dofs) and load imbalance, one per direction, at the line ``load``."""
        body = self.body
        body.complete()
        internal = body.stiffness.createVecLeft()
        body.stiffness.mult(body.state.x.petsc_vec, internal)
        internal.axpy(-1.0, _vector(self.forces_form))
        if self.held is not None:
            internal.array[body.dofs[: body.owned_nodes, Y]] -= self.held.forces
        fem_petsc.set_bc(internal, body.boundary_conditions, x0=body.state.x.petsc_vec, alpha=-1.0)
        total = np.array([self._sum(form) for form in self.resultant_forms])
        return internal, total - np.array([load.components[i] for i in self.directions])

    def assemble_jacobian(self, matrix: PETSc.Mat):
        """Overwrite ``matrix``, of the pattern of the stiffness, with d(force residual)/du."""
        self.body.constrained_stiffness.copy(matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        fem_petsc.assemble_matrix(matrix, self._tangent_form, bcs=self.body.boundary_conditions)
        matrix.assemble()

    def force_tangent(self):
        """Minus d(contact forces)/du as a scipy matrix of local (owned and ghost) dofs: this rank's facets only.

        Not summed over ranks: a row of another rank has columns here that this rank does not know.
        """
        self._strip_tangent.set_value(0.0)
        fem.assemble_matrix(self._strip_tangent, self._tangent_form)
        return self._strip_tangent.to_scipy(ghosted=True)

    def borders(self):
        """Columns and rows (lists of Vec) and corner (m, m) that the rigid displacements add to the Jacobian."""
        columns, rows, corner = self._border_forms
        columns = [_vector(form) for form in columns]
        for column in columns:
            fem_petsc.set_bc(column, self.body.boundary_conditions, alpha=0.0)
        corner = np.array([[self._sum(form) for form in row] for row in corner])
        return columns, [_vector(form) for form in rows], corner

    def contact_forces(self, nodes=slice(None)) -> np.ndarray:
        """Contact forces along x and y on owned ``nodes``, (n, 2); zero along a direction without a term."""
        return self._on_strip(self._work_form)[self.body.dofs[: self.body.owned_nodes][nodes]]

    def nodal_forces(self, direction: int, nodes=slice(None)) -> np.ndarray:
        """Contact force along x (0) or y (1) on owned ``nodes``, (n,), that of a held pressure included."""
        if direction == Y and self.held is not None:
            return self.held.forces[nodes]
        return self.contact_forces(nodes)[:, direction]

    def contact_states(self) -> np.ndarray:
        """At this rank's surface points (m,): OPEN, CLOSED, FORWARD or BACKWARD of ``forms.contact``."""
        return self._state.values()

    def trials(self) -> np.ndarray:
        """Trial traction and pressure (2, m) of this rank's surface points, linear in the displacements; 0 for none."""
        zero = np.zeros(self._points)
        return np.array([self._trials[i].values() if i in self._trials else zero for i in (X, Y)])

    def round_off(self) -> float:
        """Norm of the contact forces that the last digits of the present displacement make: no residual gets below."""
        u = self.body.state.x.array[self._surface_dofs]
        size = max(np.abs(u).max(initial=0.0), np.abs(self.body.delta.value).max())
        return self.force_per_digit * self.body.mesh.comm.allreduce(size, MPI.MAX)

    def tributary_lengths(self) -> np.ndarray:
        """Length of surface that belongs to every owned node, (n,); zero off the strip."""
        return self._on_strip(self._tributary_form)[self.body.dofs[: self.body.owned_nodes, Y]]

    def _on_strip(self, form) -> np.ndarray:
        """A linear form on the strip, assembled in place: owned dofs hold the sum over ranks."""
        array = self._vector_on_strip.x.array
        array[:] = 0.0
        fem.assemble_vector(array, form)
        self._vector_on_strip.x.scatter_reverse(InsertMode.add)
        return array

    def _sum(self, form) -> float:
        return self.body.mesh.comm.allreduce(fem.assemble_scalar(form), MPI.SUM)


def _vector(form) -> PETSc.Vec:
    vector = fem_petsc.assemble_vector(form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    return vector
