"""The condensed Newton step: the contact forces and the rigid motion of the cylinder, nothing else.

With theta = 0 and integration at the nodes only the surface nodes are loaded, and the body is linear. Its
response W to unit forces is computed once; then u = U load + W f, and Newton's method runs on the dense system

    f - f_contact(u(f), delta) = 0,    sum of f = (Q, P).

The contact forces and their tangent are assembled from the same forms as in the full method, on the strip only.
"""

import numpy as np
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc
from scipy.linalg import lapack

from .newton import bulk_solver
from .problem import ContactProblem, HalfPlane, X, Y

BLOCK = 128  # right-hand sides solved at once


class Compliance:
    """Response of the strip to unit nodal forces on the surface and to unit line loads in the far field.

    Rows are the local (owned and ghost) dofs of the strip cells, columns the surface nodes sorted by x.
    """

    def __init__(self, body: HalfPlane):
        self.body, self.comm = body, body.mesh.comm
        matrix = body.constrained_stiffness
        matrix.setOption(PETSc.Mat.Option.SPD, not body.mixed)
        self._ksp = bulk_solver(matrix, "cholesky")

        nodes = fem.locate_dofs_topological(body.displacements, 1, body.strip)
        index_map = body.displacements.dofmap.index_map
        self.surface = nodes[nodes < body.owned_nodes]  # owned surface nodes
        x = body.displacements.tabulate_dof_coordinates()[self.surface, 0]
        self._counts = self.comm.allgather(len(x))
        self.order = np.argsort(np.concatenate(self.comm.allgather(x)))
        self.n = len(self.order)
        sorted_ids = self.collect(index_map.local_to_global(self.surface.astype(np.int32)))
        self.touched = nodes  # owned and ghost surface nodes, to which this rank's facets contribute
        by_id = np.argsort(sorted_ids)
        ids = index_map.local_to_global(nodes.astype(np.int32))
        self._position = by_id[np.searchsorted(sorted_ids, ids, sorter=by_id)]
        blocks = np.unique(body.space.dofmap.list[body.strip_cells]).astype(int)
        size = body.space.dofmap.index_map_bs
        self.strip_dofs = (size * blocks[:, None] + np.arange(size)).ravel()
        self._columns: dict[int, np.ndarray] = {}
        self._field = fem.Function(body.space)
        self.far = np.stack([self._far_response(i) for i in (X, Y)], axis=1)

    def column(self, direction: int) -> np.ndarray:
        """(strip dofs, n) response to unit forces along ``direction``; computed when first asked for."""
        if direction not in self._columns:
            self._columns[direction] = self._respond(direction)
        return self._columns[direction]

    def collect(self, owned: np.ndarray) -> np.ndarray:
        """Rows (n, ...) sorted by x, on every rank, from those of the owned surface nodes."""
        return np.concatenate(self.comm.allgather(owned))[self.order]

    def add_up(self, contributions: np.ndarray) -> np.ndarray:
        """Rows (n, ...) sorted by x, on every rank, summed over the contributions of all ranks to ``touched`` nodes."""
        total = np.zeros((self.n, *contributions.shape[1:]))
        total[self._position] = contributions
        self.comm.Allreduce(MPI.IN_PLACE, total)
        return total

    def own(self, rows: np.ndarray) -> np.ndarray:
        """The inverse of ``collect``."""
        start = sum(self._counts[: self.comm.rank])
        unsorted = np.empty_like(rows)
        unsorted[self.order] = rows
        return unsorted[start : start + len(self.surface)]

    def displacement(self, load, forces: dict[int, np.ndarray]):
        """The whole displacement field (owned dofs) under nodal forces (n,) by direction: one back-substitution."""
        self.body.set_far_field(load)
        b = self.body.constrained_stiffness.createVecLeft()
        self.body.stiffness.mult(self.body.far_value.x.petsc_vec, b)
        b.scale(-1.0)
        for direction, values in forces.items():
            b.array[self.body.dofs[self.surface, direction]] += self.own(values)
        fem_petsc.set_bc(b, self.body.boundary_conditions)
        x = b.duplicate()
        self._ksp.solve(b, x)
        return x.array_r

    def _on_strip(self, owned):
        """Values of the strip dofs, ghosts included, from those of the owned dofs."""
        self._field.x.array[: len(owned)] = owned
        self._field.x.scatter_forward()
        return self._field.x.array[self.strip_dofs]

    def _far_response(self, direction):
        load = [0.0, 0.0]
        load[direction] = 1.0
        return self._on_strip(self.displacement(load, {}))

    def _respond(self, direction):
        """Solve for all unit forces along ``direction``, BLOCK at a time."""
        response = np.empty((len(self.strip_dofs), self.n))
        rows = self.body.constrained_stiffness.getLocalSize()[0]
        rank_of = np.concatenate([[rank] * count for rank, count in enumerate(self._counts)]).astype(int)
        first = np.concatenate([[0], np.cumsum(self._counts)])[self.comm.rank]
        fixed = self.body.fixed_dofs
        for start in range(0, self.n, BLOCK):
            chosen = self.order[start : start + BLOCK]
            b = PETSc.Mat().createDense(((rows, None), (None, len(chosen))), comm=self.comm)
            b.setUp()
            mine = np.flatnonzero(rank_of[chosen] == self.comm.rank)
            local = b.getDenseArray()
            local[self.body.dofs[self.surface[chosen[mine] - first], direction], mine] = 1.0
            local[fixed[fixed < rows]] = 0.0
            b.assemble()
            x = b.duplicate()
            self._ksp.matSolve(b, x)
            solved = x.getDenseArray()
            for i in range(len(chosen)):
                response[:, start + i] = self._on_strip(solved[:, i])
            b.destroy()
            x.destroy()
        return response


class CondensedSystem:
    """Unknowns: nodal forces, direction by direction, then delta; all on rank 0, mirrored to the others."""

    def __init__(self, problem: ContactProblem, compliance: Compliance):
        self.problem, self.compliance = problem, compliance
        self._rigid = list(problem.directions)
        self._comm = compliance.comm
        self._load = np.zeros(2)
        n, m = compliance.n, len(self._rigid)
        self.size = m * n + m
        self._response = np.hstack([compliance.column(i) for i in self._rigid])
        self._sides = 2.0 if problem.body.is_half else 1.0
        sums = self._sides * np.kron(np.eye(m), np.ones(n))
        self._linear = np.block([[np.eye(m * n), np.zeros((m * n, m))], [sums, np.zeros((m, m))]])
        # Displacement of the strip beyond that of the forces: what a new load has not yet moved. The first
        # step removes it, so that the contact states it starts from are those of the fields, not of a jump.
        self._offset = np.zeros(len(compliance.strip_dofs))
        self._has_offset = False
        self._left = None  # the strip as ``finish`` left it, and the forces it was left with

    def create_vector(self) -> PETSc.Vec:
        """A vector of the unknowns."""
        return PETSc.Vec().createMPI((self.size if self._comm.rank == 0 else 0, None), comm=self._comm)

    def begin(self, load, x):
        """Prescribe the line loads and fill ``x`` with the forces of the present state."""
        self._load = np.asarray(load)
        held = self.problem.held_forces
        self._constant = self.compliance.far @ self._load
        self._held = {}
        if held is not None:
            self._held = {Y: self.compliance.collect(held[self.compliance.surface])}
            self._constant += self.compliance.column(Y) @ self._held[Y]
        body = self.problem.body
        strip = body.state.x.array[self.compliance.strip_dofs]
        untouched = self._left is not None and np.array_equal(strip, self._left[0])
        forces = self._left[1] if self._comm.allreduce(untouched, MPI.LAND) else self._contact_forces()
        self._offset = strip - self._displacement(forces)
        self._has_offset = self._comm.allreduce(bool(np.any(self._offset)), MPI.LOR)
        self._put(np.concatenate([forces, body.delta.value[self._rigid]]), x)

    def residual(self, x, f) -> tuple[float, float]:
        """Fill ``f``; return the norm of the force residual and the largest load imbalance."""
        forces, rigid = self._get(x)
        self._show(forces, rigid)
        contact = self._contact_forces()
        load = self._load[self._rigid]
        imbalance = self._sums(forces) - load
        self._put(np.concatenate([forces - contact, imbalance]), f)
        if self._has_offset:  # what is left to balance is known only without it
            self._show(forces, rigid, with_offset=False)
            contact = self._contact_forces()
        # the tractions reported are the contact terms' own: these too must balance the loads
        imbalance = np.abs([imbalance, self._sums(contact) - load]).max()
        return float(np.linalg.norm(forces - contact)), float(imbalance)

    def linearise(self, x):
        """Assemble the contact tangent on the strip and factorise the dense system on rank 0."""
        self._show(*self._get(x))
        compliance, body = self.compliance, self.problem.body
        tangent = self.problem.force_tangent().tocsr()
        dofs = compliance.strip_dofs
        rows, removed = [], []
        for i in self._rigid:
            strip = tangent[body.dofs[compliance.touched, i]][:, dofs]
            rigid = strip @ np.stack([body.translations[j].x.array[dofs] for j in self._rigid], axis=1)
            rows.append(compliance.add_up(np.hstack([strip @ self._response, -rigid])))
            removed.append(compliance.add_up(-strip @ self._offset))
        self._removed = np.concatenate([*removed, np.zeros(len(rows))])
        if self._comm.rank == 0:
            tangent = np.vstack(rows)
            self._jacobian = self._linear.copy()
            self._jacobian[: len(tangent)] += tangent
            # a node without contact has df = b: it is eliminated before the factorisation
            loaded = np.append(np.any(tangent != 0.0, axis=1), np.ones(len(self._rigid), bool))
            self._free, self._loaded = np.flatnonzero(~loaded), np.flatnonzero(loaded)
            dense = self._jacobian[np.ix_(self._loaded, self._loaded)]
            self._lu, self._pivots, self._singular = lapack.dgetrf(dense)

    def solve(self, b, x):
        """x = J^-1 b; nan where the cylinder is free to move (every point slips)."""
        if self._comm.rank == 0:
            right = b.array_r + self._removed
            coupling = self._jacobian[np.ix_(self._loaded, self._free)]
            step, _ = lapack.dgetrs(self._lu, self._pivots, right[self._loaded] - coupling @ right[self._free])
            right[self._loaded] = np.nan if self._singular else step
            x.array[:] = right
        self._offset[:] = 0.0
        self._has_offset = False

    def is_singular(self) -> bool:
        """Whether the cylinder is free to move at the last ``linearise``."""
        return self._comm.bcast(bool(self._singular) if self._comm.rank == 0 else None)

    def multiply(self, x, y):
        """y = J x."""
        if self._comm.rank == 0:
            y.array[:] = self._jacobian @ x.array_r

    def finish(self, x):
        """Leave the whole state ``x`` in the problem's fields: one back-substitution."""
        forces, rigid = self._get(x)
        by_direction = dict(zip(self._rigid, forces.reshape(len(rigid), -1)))
        body = self.problem.body
        body.delta.value[self._rigid] = rigid
        displacement = self.compliance.displacement(self._load, by_direction | self._held)
        body.state.x.array[: len(displacement)] = displacement
        body.state.x.scatter_forward()
        # gamma times the last digits of u is visible in the tractions: keep those that balance the loads
        self._show(forces, rigid)
        self._left = body.state.x.array[self.compliance.strip_dofs], forces

    def last_forces(self) -> np.ndarray:
        """Contact forces that ``finish`` left, direction by direction, sorted by x."""
        return np.zeros(0) if self._left is None else self._left[1]

    def take_up(self, forces: np.ndarray):
        """Go on from fields that an earlier run's ``finish`` left with these forces."""
        if forces.size:
            self._left = self.problem.body.state.x.array[self.compliance.strip_dofs], forces

    def _show(self, forces, rigid, with_offset=True):
        """Displacements of the strip under ``forces``, and the rigid motion, into the problem's fields."""
        body = self.problem.body
        body.delta.value[self._rigid] = rigid
        body.state.x.array[self.compliance.strip_dofs] = self._displacement(forces)
        if with_offset:
            body.state.x.array[self.compliance.strip_dofs] += self._offset

    def _displacement(self, forces):
        return self._constant + self._response @ forces

    def _contact_forces(self):
        forces = (self.problem.nodal_forces(i)[self.compliance.surface] for i in self._rigid)
        return np.concatenate([self.compliance.collect(f) for f in forces])

    def _get(self, x):
        values = self._comm.bcast(x.array_r.copy() if self._comm.rank == 0 else None)
        return np.split(values, [self.size - len(self._rigid)])

    def _put(self, values, x):
        if self._comm.rank == 0:
            x.array[:] = values

    def _sums(self, forces):
        """Resultants (m,) of forces stacked direction by direction."""
        return self._sides * forces.reshape(len(self._rigid), -1).sum(axis=1)
