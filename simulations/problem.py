"""The discrete contact problem: fields on the half-plane, its forms, residual and Jacobian.

Everything is dimensionless (``simulations.scaling``). Unknowns are the displacement ``u`` and the rigid cylinder's two
displacements ``delta = (delta_x, delta_y)``, which the two line loads (Q, P) determine:

    K u - f(u, delta) = 0  in the body,     sum of the contact tractions in f = (Q, P).
"""

from dataclasses import dataclass

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from forms import contact, elasticity

from .mesh import FAR, STRIP, SURFACE, SYMMETRY

X, Y = 0, 1  # components: along the surface, into the body
BULK_QUADRATURE_DEGREE = 5  # 3 Gauss points a direction: the square of a degree-2 gradient, in graded layers


@dataclass(frozen=True)
class Nitsche:
    """Parameters of the contact terms: gamma = gamma0 * 4 E/((1-nu^2) h), and the variant theta."""

    gamma0: float = 10.0
    theta: float = 0.0


class HalfPlane:
    """Mesh, function spaces, fields and stiffness of the graded half-plane.

    far_field: function ``(x, y, P, Q) -> (2, n)`` with the displacement far from the loads; it is prescribed on
    the outer boundary, so that the domain's size is felt only beyond the resultant loads. A mesh with SYMMETRY facets is
    the half x > 0 of a symmetric problem.
    """

    def __init__(self, mesh, facets, modulus, nu: float, far_field):
        self.mesh, self.modulus, self.nu = mesh, modulus, nu
        self.depth = modulus.depth_map()
        self.space = fem.functionspace(mesh, ("Lagrange", 2, (2,)))
        self.point_space = fem.functionspace(mesh, ("DG", 2))  # of what surface points remember, cell by cell
        self.u = fem.Function(self.space, name="displacement")
        self.delta = fem.Constant(mesh, np.zeros(2))
        self.position = ufl.SpatialCoordinate(mesh)
        self.cell_height = self._cell_height()
        self.translations = [self._translation(i) for i in (X, Y)]

        far = fem.locate_dofs_topological(self.space, 1, facets.find(FAR))
        self.far_value = fem.Function(self.space)
        self.boundary_conditions = [fem.dirichletbc(self.far_value, far)]
        self.is_half = bool(mesh.comm.allreduce(facets.find(SYMMETRY).size))
        if self.is_half:
            axis = fem.locate_dofs_topological(self.space.sub(X), 1, facets.find(SYMMETRY))
            self.boundary_conditions.append(fem.dirichletbc(0.0, axis, self.space.sub(X)))
        self._far_dofs = np.stack([2 * far, 2 * far + 1])
        x, s, _ = self.space.tabulate_dof_coordinates()[far].T
        y = self.depth.y(np.maximum(s, 0.0))  # gmsh may place the surface at -1e-17
        self._far_field = [far_field(x, y, Q=1.0), far_field(x, y, P=1.0)]

        v, du = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        dx = ufl.dx(metadata={"quadrature_degree": BULK_QUADRATURE_DEGREE})
        work = elasticity.virtual_work(du, v, modulus, nu, self.depth, self.position[1], self._correction()) * dx
        form = fem.form(work)
        self.stiffness = fem_petsc.assemble_matrix(form)
        self.stiffness.assemble()
        self.constrained_stiffness = fem_petsc.assemble_matrix(form, bcs=self.boundary_conditions)
        self.constrained_stiffness.assemble()

        middle = dolfinx.mesh.compute_midpoints(mesh, 1, facets.find(SURFACE))[:, 0]
        self.strip = facets.find(SURFACE)[np.abs(middle) < STRIP]
        tags = dolfinx.mesh.meshtags(mesh, 1, np.sort(self.strip), np.full(len(self.strip), SURFACE, np.int32))
        # Integration at the displacement nodes makes each node carry its own contact force; with Gauss
        # points between them the semismooth Newton diverges on thin layers.
        rule = {"quadrature_rule": "GLL", "quadrature_degree": 3}
        self.surface_measure = ufl.Measure("ds", mesh, subdomain_data=tags, metadata=rule)(SURFACE)
        mesh.topology.create_connectivity(1, 2)
        to_cell = mesh.topology.connectivity(1, 2)
        self.strip_cells = np.unique([to_cell.links(facet)[0] for facet in self.strip]).astype(np.int32)

    @property
    def fixed_dofs(self) -> np.ndarray:
        """Local dofs whose displacement is prescribed."""
        return np.unique(np.concatenate([bc.dof_indices()[0] for bc in self.boundary_conditions]))

    @property
    def unknowns(self) -> int:
        """Global number of displacement unknowns."""
        return 2 * self.space.dofmap.index_map.size_global

    def traction(self, u):
        """UFL traction (2,) of ``u`` on the surface, dimensionless."""
        return elasticity.surface_traction(u, self.modulus, self.nu, self.depth, self.cell_height)

    def set_far_field(self, load):
        """Prescribe the displacement of the loads ``(Q, P)`` on the outer boundary."""
        value = load[X] * self._far_field[X] + load[Y] * self._far_field[Y]
        self.far_value.x.array[self._far_dofs] = value

    def apply_far_field(self, load):
        """``set_far_field``, and the same values in ``u``."""
        self.set_far_field(load)
        self.u.x.array[self._far_dofs] = self.far_value.x.array[self._far_dofs]

    def _cell_height(self):
        height = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        cells = self.mesh.geometry.x[self.mesh.geometry.dofmap][..., 1]
        height.x.array[:] = np.ptp(cells, axis=1)
        return height

    def _correction(self):
        """Exact mean of E over each cell, divided by its quadrature.

        For k < 0 the modulus is infinite on the surface, and Gauss points miss part of the stiff skin: 13 % of the first
        layer's at k = -0.5, an error of order first_layer^(1+k) in everything.
        """
        if self.modulus.k >= 0:
            return 1.0
        points, weights = np.polynomial.legendre.leggauss(BULK_QUADRATURE_DEGREE // 2 + 1)
        depths = self.mesh.geometry.x[self.mesh.geometry.dofmap][..., 1]
        top, bottom = np.maximum(depths.min(axis=1), 0.0), depths.max(axis=1)
        at_points = self.modulus.young(top[:, None] + (bottom - top)[:, None] * (1.0 + points) / 2.0)
        factor = fem.Function(self.cell_height.function_space)
        factor.x.array[:] = self.modulus.layer_mean(top, bottom) / (at_points @ weights / 2.0)
        return factor

    def _translation(self, direction):
        field = fem.Function(self.space)
        field.x.array[direction::2] = 1.0
        return field


class ContactProblem:
    """Contact of a half-plane with the cylinder as residual and Jacobian, with the effects it is asked for.

    profile: UFL function of x, the cylinder's shape f(x). ``directions`` lists the contact tractions in the forms, each
    with its rigid displacement: (Y,) without friction; (X, Y) with; (X,) for the tangential problem uncoupled from the
    normal one, whose pressure and displacement ``hold_pressure`` then keeps.
    """

    def __init__(self, body: HalfPlane, profile, nitsche: Nitsche, directions: tuple[int, ...]):
        self.body, self.directions = body, directions
        self.friction = X in directions
        self.all_stick = fem.Constant(body.mesh, 0.0)  # 1 in the predictor
        self.held_forces = None
        ds = body.surface_measure
        u, v, du = body.u, ufl.TestFunction(body.space), ufl.TrialFunction(body.space)
        if Y not in directions:
            self._held_displacement = fem.Function(body.space)
            u = body.u - self._held_displacement

        into = body.modulus.surface_moduli(body.cell_height, body.depth)[1]
        gamma = nitsche.gamma0 * 4.0 * into / ((1.0 - body.nu**2) * body.cell_height)
        traction = body.traction(u)
        tractions = {}
        if Y in directions:
            gap = contact.gap(u, profile(body.position[0]), body.delta)
            pressure = tractions[Y] = contact.contact_pressure(traction, gap, gamma)
            self._pressure = self._expression(pressure)
        else:
            pressure = self._held_pressure = self._point_values("pressure")
        if self.friction:
            self.mu = fem.Constant(body.mesh, 0.0)
            self.anchor = self._point_values("anchor")
            self.lagged = fem.Constant(body.mesh, 0.0)  # 1: friction is limited by a pressure that is kept
            if Y in directions:
                self._lagged_pressure = self._point_values("lagged pressure")
                pressure = ufl.conditional(ufl.gt(self.lagged, 0.5), self._lagged_pressure, pressure)
            s = contact.relative_displacement(u, body.delta)
            trial = contact.trial_traction(traction, s, self.anchor, gamma)
            self._slid = self._point_values("slid")
            limit = self.mu * pressure
            sliding = contact.slides(trial, limit, self._slid)
            self._sliding = self._expression(sliding)
            tractions[X] = contact.coulomb(trial, pressure, limit, sliding, self.all_stick)
            self._rest = self._expression(contact.rest_position(traction, s, tractions[X], gamma))
            self._released = self._expression(contact.rest_position(traction, s, 0.0, gamma))

        work = {i: contact.work(tractions[i], v, i) * ds for i in directions}
        forces = sum(work.values())
        if nitsche.theta:
            for i in directions:
                test = ufl.derivative(traction[i], body.u, v)
                forces += contact.consistency(traction[i], tractions[i], test, nitsche.theta, gamma) * ds
        sides = 2.0 if body.is_half else 1.0
        resultants = [sides * tractions[i] * ds for i in directions]
        along = [body.translations[i] for i in directions]
        # The cylinder enters through u - delta alone, so d/d(delta_i) is minus the derivative along a translation.
        self._forces = fem.form(forces)
        self._force_tangent = fem.form(ufl.derivative(-forces, body.u, du))
        self._strip_tangent = fem.create_matrix(self._force_tangent)
        self._resultants = [fem.form(r) for r in resultants]
        self._columns = [fem.form(ufl.derivative(forces, body.u, e)) for e in along]
        self._rows = [fem.form(ufl.derivative(r, body.u, v)) for r in resultants]
        self._corner = [[fem.form(-ufl.derivative(r, body.u, e)) for e in along] for r in resultants]
        self._nodal = {i: fem.form(w) for i, w in work.items()}
        self._tributary = fem.form(v[Y] * ds)

    # --- residual and Jacobian -----------------------------------------------------------------------------

    def create_matrix(self) -> PETSc.Mat:
        """A matrix for ``assemble_jacobian``."""
        return self.body.constrained_stiffness.copy()

    def residual(self, load) -> tuple[PETSc.Vec, np.ndarray]:
        """Force residual (owned dofs) and load imbalance, one per direction, at line loads ``(Q, P)``."""
        internal = self.body.stiffness.createVecLeft()
        self.body.stiffness.mult(self.body.u.x.petsc_vec, internal)
        internal.axpy(-1.0, self._vector(self._forces))
        if self.held_forces is not None:
            internal.array[Y::2] -= self.held_forces
        fem_petsc.set_bc(internal, self.body.boundary_conditions, x0=self.body.u.x.petsc_vec, alpha=-1.0)
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
        corner = np.array([[self._sum(form) for form in row] for row in self._corner])
        columns = [self._vector(form) for form in self._columns]
        for column in columns:
            fem_petsc.set_bc(column, self.body.boundary_conditions, alpha=0.0)
        return columns, [self._vector(form) for form in self._rows], corner

    def nodal_forces(self, direction: int) -> np.ndarray:
        """Contact force along x (0) or y (1) on every owned dof of that direction, (n,)."""
        if direction not in self._nodal:
            nothing = np.zeros(self.body.space.dofmap.index_map.size_local)
            return nothing if direction == X or self.held_forces is None else self.held_forces.copy()
        return self._vector(self._nodal[direction]).array[direction::2].copy()

    def tributary_lengths(self) -> np.ndarray:
        """Length of surface that belongs to every owned node, (n,); zero off the strip."""
        return self._vector(self._tributary).array[Y::2].copy()

    def lag_pressure(self):
        """Keep the present pressure as the limit of friction while ``lagged`` is 1."""
        self._interpolate(self._lagged_pressure, self._pressure)

    def note_sliding(self):
        """Remember where points slide now: until ``forget_sliding`` none turns round without sticking in between."""
        self._interpolate(self._slid, self._sliding)

    def forget_sliding(self):
        """Coulomb's law as it is."""
        self._slid.x.array[:] = 0.0

    # --- memory of the slip --------------------------------------------------------------------------------

    def release(self):
        """Start friction here: no tangential traction, and none of the present displacement is slip."""
        self._move_anchor(self._released)

    def come_to_rest(self):
        """End an increment: anchor every point where it stopped (return mapping)."""
        self._move_anchor(self._rest)

    def hold_pressure(self, normal: "ContactProblem"):
        """Keep the pressure and the displacement of the normal problem as they are now."""
        self.held_forces = normal.nodal_forces(Y)  # all of them for theta = 0
        self._held_displacement.x.array[:] = self.body.u.x.array
        self._interpolate(self._held_pressure, normal._pressure)

    def _move_anchor(self, expression):
        self._interpolate(self.anchor, expression)

    def _interpolate(self, field, expression):
        field.interpolate(expression, cells0=self.body.strip_cells)
        field.x.scatter_forward()

    def _point_values(self, name):
        """A field with a value of its own at every surface node of every cell."""
        return fem.Function(self.body.point_space, name=name)

    def _expression(self, value):
        return fem.Expression(value, self.body.point_space.element.interpolation_points())

    def _vector(self, form) -> PETSc.Vec:
        vector = fem_petsc.assemble_vector(form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return vector

    def _sum(self, form) -> float:
        return self.body.mesh.comm.allreduce(fem.assemble_scalar(form), MPI.SUM)
