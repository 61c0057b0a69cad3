"""The condensed Newton step: unknowns are the nodal contact forces and the rigid displacements of the indenter.

With theta = 0 and integration at the nodes only the surface nodes are loaded, and the body is linear. Its compliance
matrix C is known (``surface_compliance``). Then u = U load + C f, and Newton's method runs on the dense system

    f - f_contact(u(f), delta) = 0,    sum of f = (Q, P).

The contact forces and their tangent are assembled from the same forms as in the full method, on the strip only.
"""

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_matrix

from forms.contact import Y

from ...fem.contact_problem import ContactProblem
from ..system import System
from .surface_compliance import SurfaceCompliance
from .tangent import DenseTangent


class CondensedSystem(System):
    """Unknowns: nodal forces, direction by direction, then delta; all on rank 0."""

    def __init__(self, problem: ContactProblem, compliance: SurfaceCompliance):
        self.problem, self.compliance = problem, compliance
        self._rigid = list(problem.directions)
        self._comm, self._is_root = compliance.comm, compliance.comm.rank == 0
        self.size = len(self._rigid) * (compliance.n + 1)
        self._sides = problem.body.symmetry_factor
        self._matrix = compliance.matrix(problem.directions)
        fields = [problem.body.translations[i].x.array for i in self._rigid]
        translations = np.stack([compliance.strip_values(field) for field in fields], axis=1)
        self.dense = DenseTangent(self._matrix, translations, self._sides) if self._is_root else None
        self._pattern = _TangentPattern(problem, compliance)
        self._load, self._constant = np.zeros(2), np.zeros(len(compliance.strip))
        self._shown: tuple = None, None  # the last forces whose displacement was needed, and that displacement
        # Part of the strip displacement that the current forces do not cause, after a change of the load. The first
        # step removes it, so that this step starts from the contact states of the fields.
        self._offset, self._has_offset = np.zeros(len(compliance.strip)), False
        self._held: tuple = None, 0.0  # forces of the held pressure, and their displacement
        self._left: tuple = None, np.zeros(0)  # the strip displacement that ``finish`` left, and its forces

    def create_vector(self) -> PETSc.Vec:
        """A vector of the unknowns."""
        return PETSc.Vec().createMPI((self.size if self._is_root else 0, None), comm=self._comm)

    def begin(self, load, x):
        """Prescribe the line loads and fill ``x`` with the forces of the present state."""
        self._load = np.asarray(load.components)
        compliance, body = self.compliance, self.problem.body
        body.set_far_field(load)
        if self.problem.held is not None and self.problem.held.forces is not self._held[0]:
            held = self.problem.held.forces
            collected = body.surface_nodes.collect(held[body.surface_nodes.owned])
            self._held = held, compliance.matrix((Y,)).apply(collected) if self._is_root else 0.0
        if self._is_root:
            self._constant = compliance.far @ self._load + self._held[1]
        strip = compliance.strip_values()
        forces = self._left[1] if np.array_equal(strip, self._left[0]) else self._contact_forces()
        if self._is_root:
            self._shown = forces, self._displacement(forces)
            self._offset = strip - self._shown[1]
        self._has_offset = self._comm.bcast(bool(np.any(self._offset)))
        self._put(np.concatenate([forces, body.delta.value[self._rigid]]), x)

    def start_elsewhere(self):
        """After ``begin``: start from forces that are not those of the present state, and from their displacements."""
        self._offset[:] = 0.0
        self._has_offset = False

    def residual(self, x, f) -> tuple[float, float]:
        """Fill ``f``; return the norm of the force residual and the largest load imbalance."""
        forces, rigid = self._get(x)
        self._show(forces, rigid)
        contact = self._contact_forces()
        load = self._load[self._rigid]
        imbalance = self._sums(forces) - load
        self._put(np.concatenate([forces - contact, imbalance]), f)
        if self._has_offset:  # the residual that counts is the one without it
            self._show(forces, rigid, with_offset=False)
            contact = self._contact_forces()
            self._show(forces, rigid)
        # the tractions reported are the contact terms' own: these too must balance the loads
        imbalance = np.abs([imbalance, self._sums(contact) - load]).max()
        return float(np.linalg.norm(forces - contact)), float(imbalance)

    def linearise(self, x):
        """Assemble the contact tangent on the strip and factorise the dense system on rank 0."""
        forces, rigid = self._get(x)
        self._show(forces, rigid)
        tangent = self._pattern.assemble()
        if self._is_root:
            self.dense.factorise(tangent)

    def solve(self, b, x, fixed=False):
        """x = J^-1 b; nan where the indenter is free to move (every point slips) and not fixed."""
        if self._is_root:
            right = b.array_r.copy()
            right[: -len(self._rigid)] -= self.dense.tangent @ self._offset
            x.array[:] = self.dense.solve_fixed(right) if fixed else self.dense.solve(right, abs(self._load[Y]))
        self._offset[:] = 0.0
        self._has_offset = False

    def multiply(self, x, y):
        """y = J x."""
        if self._is_root:
            y.array[:] = self.dense.multiply(x.array_r)

    def finish(self, x):
        """Leave the strip in the problem's fields; the rest of the body follows when it is asked for."""
        forces, rigid = self._get(x)
        # gamma times the last digits of u is visible in the tractions: keep the u whose tractions balance the loads
        self._show(forces, rigid)
        self._left = self.compliance.strip_values(), forces
        self.problem.body.recover = self.compliance.recover

    def last_forces(self) -> np.ndarray:
        """Contact forces that ``finish`` left, direction by direction, sorted by x."""
        return self._left[1]

    def take_up(self, forces: np.ndarray):
        """Continue from fields of an earlier run, whose last ``finish`` left these forces."""
        if forces.size:
            self._left = self.compliance.strip_values(), forces

    def _show(self, forces, rigid, with_offset=True):
        """Displacements of the strip under ``forces``, and the rigid motion, into the problem's fields."""
        self.problem.body.delta.value[self._rigid] = rigid
        strip = None
        if self._is_root:
            if not np.array_equal(forces, self._shown[0]):
                self._shown = forces, self._displacement(forces)
            strip = self._shown[1] + self._offset if with_offset else self._shown[1]
        self.compliance.put(strip)

    def _displacement(self, forces):
        return self._constant + self._matrix.apply(forces)

    def _contact_forces(self):
        nodes = self.problem.body.surface_nodes
        return nodes.collect(self.problem.terms.contact_forces(nodes.owned)[:, self._rigid]).T.ravel()

    def _get(self, x):
        values = x.array_r.copy() if self._is_root else None
        values = self._comm.bcast(values) if self._comm.size > 1 else values
        return np.split(values, [self.size - len(self._rigid)])

    def _put(self, values, x):
        if self._is_root:
            x.array[:] = values

    def _sums(self, forces):
        """Resultants (m,) of forces stacked direction by direction."""
        return self._sides * forces.reshape(len(self._rigid), -1).sum(axis=1)


class _TangentPattern:
    """Gathers the contact tangent of all ranks into one sparse matrix (mn, r) on rank 0."""

    def __init__(self, problem: ContactProblem, compliance: SurfaceCompliance):
        self._problem, self._comm = problem, compliance.comm
        local = problem.terms.force_tangent()
        numbered = local.copy()
        numbered.data = np.arange(1.0, local.data.size + 1).reshape(local.data.shape)
        dofs = problem.body.dofs[problem.body.surface_nodes.touched]
        rows = np.concatenate([dofs[:, i] for i in problem.directions])
        chosen = numbered.tocsr()[rows][:, compliance.strip_dofs].tocoo()
        self._entries = chosen.data.astype(int) - 1
        place = np.concatenate([i * compliance.n + compliance.node_position for i in range(len(problem.directions))])
        where = place[chosen.row], compliance.position[chosen.col]
        found = self._comm.gather(where)
        if self._comm.rank == 0:
            row, column = (np.concatenate(part) for part in zip(*found))
            shape = len(problem.directions) * compliance.n, len(compliance.strip)
            key, self._sum_into = np.unique(row.astype(np.int64) * shape[1] + column, return_inverse=True)
            row, column = np.divmod(key, shape[1])
            indptr = np.searchsorted(row, np.arange(shape[0] + 1))
            self._matrix = csr_matrix((np.zeros(len(key)), column, indptr), shape=shape)

    def assemble(self) -> csr_matrix | None:
        """The tangent at the present state, on rank 0; None elsewhere."""
        mine = self._problem.terms.force_tangent().data.ravel()[self._entries]
        parts = self._comm.gather(mine)
        if self._comm.rank:
            return None
        data = np.bincount(self._sum_into, np.concatenate(parts), minlength=self._matrix.nnz)
        return csr_matrix((data, self._matrix.indices, self._matrix.indptr), shape=self._matrix.shape)
