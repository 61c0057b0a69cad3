"""The discrete elastic body: fields, stiffness, and what is prescribed far from the contact.

Everything is dimensionless (``simulations.scene.scaling``). Parameters are constants of the forms, not numbers in their
code: all scenes with the same effects share one compiled form.
"""

from collections.abc import Callable

import dolfinx
import numpy as np
import ufl
from dolfinx import fem

from forms import elasticity, weak_form
from forms.contact import X, Y
from forms.modulus import with_parameters

from .load import Load
from .mesh import FAR, SURFACE, SYMMETRY
from .spaces import SurfaceNodes, create_space
from .stiffness import assemble_stiffness, cell_heights, modulus_correction

# Integration at the displacement nodes makes each node carry its own contact force; with Gauss points between
# them the semismooth Newton diverges on thin layers.
SURFACE_RULE = {"quadrature_rule": "GLL"}


class ElasticBody:
    """Mesh, fields and stiffness of the graded half-plane, cut off far from the contact.

    far_field: function ``(x, y, P, Q) -> (2, n)`` with the displacement far from the loads; it is prescribed on
    the outer boundary, so that only moments of the tractions, not their resultants, feel the domain's size. strip:
    half-width of the surface on which contact is looked for. mixed: the mean stress is a field of its own. works: more
    terms of the virtual work, functions ``(body, v) -> form`` linear in ``body.u``. degree: of the displacements, 1 to
    3. A mesh with SYMMETRY facets is the half x > 0 of a symmetric problem. stretched: the body may have a uniform
    strain along x, ``strain`` (None else), which is an equilibrium by itself; ``state`` is the deviation from it.

    ``state`` holds all unknowns; ``u`` and ``pi`` (None unless mixed) are its parts in forms, and ``dofs[n, i]`` is the
    index in ``state`` of displacement i of node n. ``solid`` is what forms know of the material. ``recover`` is what
    brings ``state`` beyond the strip up to date, None where it is.
    """

    def __init__(
        self,
        mesh,
        facets,
        modulus,
        nu: float,
        far_field,
        strip: float,
        mixed=False,
        works=(),
        degree=2,
        stretched=False,
    ):
        self.mesh, self.modulus, self.mixed, self.degree = mesh, modulus, mixed, degree
        self.depth = modulus.depth_map()
        self.space, self.displacements, self.dofs = create_space(mesh, degree, mixed)
        self.point_space = fem.functionspace(mesh, ("DG", degree))  # of one value at every node of every cell
        self.state = fem.Function(self.space, name="state")
        self.u, self.pi = self.split(self.state)
        self.delta = fem.Constant(mesh, np.zeros(2))
        self.strain = self.constant(0.0) if stretched else None
        self.translations = [self._translation(i) for i in (X, Y)]

        self.nu, self.cell_height = self.constant(nu), cell_heights(mesh)
        correction = modulus_correction(modulus, mesh, self.cell_height.function_space, degree)
        law, s = with_parameters(modulus, self.constant), ufl.SpatialCoordinate(mesh)[1]
        self.solid = elasticity.Solid(law, self.nu, law.depth_map(), s, self.cell_height, correction)

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
        y = self.depth.y(np.maximum(s, 0.0))  # round-off may place the surface at -1e-17
        self._far_field = [far_field(x, y, Q=1.0), far_field(x, y, P=1.0)]

        strip_facets, self.strip_cells, self.surface_measure = self._find_strip(facets.find(SURFACE), strip)
        self.surface_nodes = SurfaceNodes(self.displacements, strip_facets)
        self.stiffness_form = fem.form(self._stiffness_form(works))
        self.stiffness, self.constrained_stiffness = assemble_stiffness(self.stiffness_form, self.fixed_dofs)
        self.recover: Callable[[], None] | None = None

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

    @property
    def symmetry_factor(self) -> float:
        """Integrals over the whole body, over those on the mesh: 2 where that is one half, else 1."""
        return 2.0 if self.is_half else 1.0

    def complete(self):
        """Bring the whole of ``state`` up to date; between load steps only the strip is."""
        if self.recover is not None:
            recover, self.recover = self.recover, None
            recover()

    def reset(self):
        """No displacement, no load."""
        self.state.x.array[:] = 0.0
        self.far_value.x.array[:] = 0.0
        self.delta.value[:] = 0.0
        self.stretch(0.0)
        self.recover = None

    def constant(self, value: float) -> fem.Constant:
        """A parameter of the forms."""
        return fem.Constant(self.mesh, float(value))

    def split(self, state):
        """Displacement and mean stress (None unless mixed) of a field or an argument of the forms."""
        return ufl.split(state) if self.mixed else (state, None)

    def stress(self):
        """UFL stress (2, 2) in the body, to be evaluated at the Gauss points of the stiffness."""
        sigma, young = self.solid.stress(self.u, self.pi), self.solid.young
        return sigma if self.strain is None else sigma + elasticity.stretching_stress(young, self.nu, self.strain)

    def stretch(self, strain: float):
        """Give the body this uniform strain along x; only one that may be ``stretched`` takes other than zero."""
        if self.strain is not None:
            self.strain.value = strain

    def displaced(self) -> np.ndarray:
        """The local array of ``state`` with the displacement of the uniform strain."""
        state = self.state.x.array.copy()
        if self.strain is not None:
            x, s, _ = self.displacements.tabulate_dof_coordinates().T
            state[self.dofs] += self.stretching(x, self.depth.y(np.maximum(s, 0.0)))
        return state

    def stretching(self, x, y) -> np.ndarray:
        """Displacement (n, 2) of the uniform strain at x and depth y (n,), which ``state`` does not hold."""
        strain, nu = 0.0 if self.strain is None else float(self.strain.value), float(self.nu.value)
        return np.stack([strain * x, -nu / (1 - nu) * strain * y], axis=1)

    def set_far_field(self, load: Load):
        """Prescribe the displacement of the loads P and Q on the outer boundary."""
        self.far_value.x.array[self._far_dofs] = (load.Q * self._far_field[X] + load.P * self._far_field[Y]).T

    def apply_far_field(self, load: Load):
        """``set_far_field``, and the same values in ``state``."""
        self.set_far_field(load)
        self.state.x.array[self._far_dofs] = self.far_value.x.array[self._far_dofs]

    def _stiffness_form(self, works):
        trial, (v, r) = ufl.TrialFunction(self.space), self.split(ufl.TestFunction(self.space))
        u, pi = self.split(trial)
        dx = ufl.dx(metadata={"quadrature_degree": 2 * self.degree + 1})  # the square of a gradient, in graded layers
        form = weak_form.internal_work(self.solid, u, pi, v, r, dx)
        for work in works:
            form += ufl.derivative(work(self, v), self.state, trial)
        return form

    def _find_strip(self, surface, half_width):
        """Facets, cells and measure of the surface on which contact is looked for."""
        mesh = self.mesh
        middle = dolfinx.mesh.compute_midpoints(mesh, 1, surface)[:, 0]
        strip = surface[np.abs(middle) < half_width]
        tags = dolfinx.mesh.meshtags(mesh, 1, np.sort(strip), np.full(len(strip), SURFACE, np.int32))
        rule = {"quadrature_degree": 2 * self.degree - 1} | SURFACE_RULE
        measure = ufl.Measure("ds", mesh, subdomain_data=tags, metadata=rule)(SURFACE)
        mesh.topology.create_connectivity(1, 2)
        return strip, dolfinx.mesh.compute_incident_entities(mesh.topology, strip, 1, 2), measure

    def _translation(self, direction):
        field = fem.Function(self.space)
        field.x.array[self.dofs[:, direction]] = 1.0
        return field
