"""The discrete half-plane: spaces, fields, stiffness, and what is prescribed far from the contact.

Everything is dimensionless (``simulations.scene.scaling``). Parameters are constants of the forms, not numbers in their code:
all scenes with the same effects share one compiled form.
"""

import basix.ufl
import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from forms import elasticity

from .mesh import FAR, SURFACE, SYMMETRY

X, Y = 0, 1  # components: along the surface, into the body
# Integration at the displacement nodes makes each node carry its own contact force; with Gauss points between
# them the semismooth Newton diverges on thin layers.
SURFACE_RULE = {"quadrature_rule": "GLL"}


class HalfPlane:
    """Mesh, function spaces, fields and stiffness of the graded half-plane.

    far_field: function ``(x, y, P, Q) -> (2, n)`` with the displacement far from the loads; it is prescribed on
    the outer boundary, so that the domain's size is felt only beyond the resultant loads. strip: half-width of the
    surface on which contact is looked for. mixed: the mean stress is a field of its own. works: further terms of the
    virtual work, functions ``(body, v) -> form`` linear in ``body.u``. degree: of the displacements, 1 to 3. A mesh
    with SYMMETRY facets is the half x > 0 of a symmetric problem.

    ``state`` holds all unknowns; ``u`` and ``pi`` (None unless mixed) are its parts in forms, and ``dofs[n, i]`` is the
    index in ``state`` of displacement i of node n.
    """

    def __init__(self, mesh, facets, modulus, nu: float, far_field, strip: float, mixed=False, works=(), degree=2):
        self.degree = degree
        self.bulk_quadrature = 2 * degree + 1  # the square of a gradient, in graded layers
        self.mesh, self.modulus, self.facets, self.mixed = mesh, modulus, facets, mixed
        self.depth = modulus.depth_map()
        self._form_modulus = modulus.with_parameters(self.constant)
        self._form_depth = self._form_modulus.depth_map()
        self.nu = self.constant(nu)
        self._make_spaces()
        self.delta = fem.Constant(mesh, np.zeros(2))
        self.position = ufl.SpatialCoordinate(mesh)
        self.cell_height = self._cell_height()
        self.translations = [self._translation(i) for i in (X, Y)]

        far = fem.locate_dofs_topological(self.displacements, 1, facets.find(FAR))
        self.far_value = fem.Function(self.space)
        self._far_dofs = self.dofs[far]
        self.boundary_conditions = [fem.dirichletbc(self.far_value, self._far_dofs.ravel() if mixed else far)]
        self.is_half = bool(mesh.comm.allreduce(facets.find(SYMMETRY).size))
        if self.is_half:
            component = (self.space.sub(0) if mixed else self.space).sub(X)
            axis = fem.locate_dofs_topological(component, 1, facets.find(SYMMETRY))
            self.boundary_conditions.append(fem.dirichletbc(0.0, axis, component))
        x, s, _ = self.displacements.tabulate_dof_coordinates()[far].T
        y = self.depth.y(np.maximum(s, 0.0))  # gmsh may place the surface at -1e-17
        self._far_field = [far_field(x, y, Q=1.0), far_field(x, y, P=1.0)]

        self._make_strip(strip)
        self.stiffness_form = fem.form(self._stiffness_form(works))
        self.stiffness = fem_petsc.assemble_matrix(self.stiffness_form)
        self.stiffness.assemble()
        self.constrained_stiffness = self.stiffness.copy()
        owned = self.fixed_dofs[self.fixed_dofs < self.stiffness.getLocalSize()[0]]
        first, _ = self.stiffness.getOwnershipRange()
        self.constrained_stiffness.zeroRowsColumns((first + owned).astype(PETSc.IntType), 1.0)
        self.recover = None  # function that brings ``state`` beyond the strip up to date, None where it is

    @property
    def fixed_dofs(self) -> np.ndarray:
        """Local dofs whose displacement is prescribed."""
        return np.unique(np.concatenate([bc.dof_indices()[0] for bc in self.boundary_conditions]))

    @property
    def unknowns(self) -> int:
        """Global number of unknowns."""
        return self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs

    @property
    def owned_nodes(self) -> int:
        """Number of this rank's displacement nodes."""
        return self.displacements.dofmap.index_map.size_local

    def complete(self):
        """Bring the whole of ``state`` up to date; between increments only the strip is."""
        if self.recover is not None:
            recover, self.recover = self.recover, None
            recover()

    def reset(self):
        """No displacement, no load."""
        self.state.x.array[:] = 0.0
        self.far_value.x.array[:] = 0.0
        self.delta.value[:] = 0.0
        self.recover = None

    def constant(self, value: float) -> fem.Constant:
        """A parameter of the forms."""
        return fem.Constant(self.mesh, float(value))

    def split(self, state):
        """Displacement and mean stress (None unless mixed) of a field or an argument of the forms."""
        return ufl.split(state) if self.mixed else (state, None)

    def stress(self):
        """UFL stress (2, 2) in the body."""
        s = self.position[1]
        gradient = self._form_depth.gradient(self.u, s)
        return elasticity.stress(self._form_modulus.young(self._form_depth.y(s)) * gradient, self.nu, self.pi)

    def traction(self, u, pi):
        """UFL traction (2,) of a field on the surface."""
        return elasticity.surface_traction(u, self._form_modulus, self.nu, self._form_depth, self.cell_height, pi)

    def surface_modulus(self):
        """UFL plane-strain modulus E/(1 - nu²) of the surface cells, per mesh depth."""
        return self._form_modulus.surface_moduli(self.cell_height, self._form_depth)[1] / (1.0 - self.nu**2)

    def set_far_field(self, load):
        """Prescribe the displacement of the loads ``(Q, P)`` on the outer boundary."""
        self.far_value.x.array[self._far_dofs] = (load[X] * self._far_field[X] + load[Y] * self._far_field[Y]).T

    def apply_far_field(self, load):
        """``set_far_field``, and the same values in ``state``."""
        self.set_far_field(load)
        self.state.x.array[self._far_dofs] = self.far_value.x.array[self._far_dofs]

    def _make_spaces(self):
        cell = self.mesh.basix_cell()
        element = basix.ufl.element("Lagrange", cell, self.degree, shape=(2,))
        if self.mixed:  # Taylor and Hood's pair
            self.space = fem.functionspace(
                self.mesh, basix.ufl.mixed_element([element, basix.ufl.element("Lagrange", cell, self.degree - 1)])
            )
            self.displacements, dofs = self.space.sub(0).collapse()
        else:
            self.space = self.displacements = fem.functionspace(self.mesh, element)
            dofs = np.arange(2 * len(self.space.tabulate_dof_coordinates()))
        self.dofs = np.asarray(dofs, dtype=np.int32).reshape(-1, 2)
        # of what surface points remember, cell by cell
        self.point_space = fem.functionspace(self.mesh, ("DG", self.degree))
        self.state = fem.Function(self.space, name="state")
        self.u, self.pi = self.split(self.state)

    def _stiffness_form(self, works):
        modulus, nu, depth, s = self._form_modulus, self.nu, self._form_depth, self.position[1]
        trial, (v, r) = ufl.TrialFunction(self.space), self.split(ufl.TestFunction(self.space))
        u, pi = self.split(trial)
        dx = ufl.dx(metadata={"quadrature_degree": self.bulk_quadrature})
        correction = self._correction()
        form = elasticity.virtual_work(u, v, modulus, nu, depth, s, correction, pi) * dx
        if self.mixed:
            form += elasticity.dilatation(u, pi, r, modulus, nu, depth, s, correction) * dx
        for work in works:
            form += ufl.derivative(work(self, v), self.state, trial)
        return form

    def _make_strip(self, strip):
        """Facets, cells and measure of the surface on which contact is looked for."""
        mesh = self.mesh
        surface = self.facets.find(SURFACE)
        middle = dolfinx.mesh.compute_midpoints(mesh, 1, surface)[:, 0]
        self.strip = surface[np.abs(middle) < strip]
        tags = dolfinx.mesh.meshtags(mesh, 1, np.sort(self.strip), np.full(len(self.strip), SURFACE, np.int32))
        rule = {"quadrature_degree": 2 * self.degree - 1} | SURFACE_RULE
        self.surface_measure = ufl.Measure("ds", mesh, subdomain_data=tags, metadata=rule)(SURFACE)
        mesh.topology.create_connectivity(1, 2)
        to_cell = mesh.topology.connectivity(1, 2)
        self.strip_cells = np.unique([to_cell.links(facet)[0] for facet in self.strip]).astype(np.int32)

    def _cell_height(self):
        height = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        cells = self.mesh.geometry.x[self.mesh.geometry.dofmap][..., 1]
        height.x.array[:] = np.ptp(cells, axis=1)
        return height

    def _correction(self):
        """Exact mean of E over each cell, divided by its quadrature.

        For k < 0 the modulus is infinite on the surface, and Gauss points miss part of the stiff skin: 13 % of the
        first layer's at k = -0.5, an error of order first_layer^(1+k) in everything.
        """
        if not self.modulus.is_singular:
            return 1.0
        points, weights = np.polynomial.legendre.leggauss(self.degree + 1)
        depths = self.mesh.geometry.x[self.mesh.geometry.dofmap][..., 1]
        top, bottom = np.maximum(depths.min(axis=1), 0.0), depths.max(axis=1)
        at_points = self.modulus.young(top[:, None] + (bottom - top)[:, None] * (1.0 + points) / 2.0)
        factor = fem.Function(self.cell_height.function_space)
        factor.x.array[:] = self.modulus.layer_mean(top, bottom) / (at_points @ weights / 2.0)
        return factor

    def _translation(self, direction):
        field = fem.Function(self.space)
        field.x.array[self.dofs[:, direction]] = 1.0
        return field
