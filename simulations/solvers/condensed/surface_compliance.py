"""Surface compliance matrix of the elastic body, from one Schur factorisation of each symmetric half.

The strip is the row of cells along the surface where contact is looked for. The rest of the body is factorised and
leaves a dense Schur complement on its interface with the strip. The strip itself is added as a dense system. On a
mesh that is its own mirror image the symmetric and the antisymmetric half (``mirror``) are independent, and two ranks
factorise one each.
"""

import numpy as np
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc
from scipy.linalg import solve
from scipy.sparse import csr_matrix

from forms.contact import X

from ...fem.body import ElasticBody
from ...fem.load import Load
from ...fem.parallel import gathered
from .matrix import Block, ComplianceMatrix, StripInside
from .mirror import NONE, Part, parts
from .schur import PartialFactor


class SurfaceCompliance:
    """Displacement of the strip under unit nodal forces on the surface, and under unit line loads in the far field.

    It depends on the body alone. Its n surface nodes are sorted by x. ``strip`` holds the global dofs (r,) of the strip
    cells, sorted. Rank 0 has the matrix and ``far`` (r, 2), columns Q and P; other ranks have neither.
    """

    def __init__(self, body: ElasticBody):
        self.body, self.comm = body, body.mesh.comm
        self._find_surface()
        inner, interface = self._find_strip()
        found = parts(body)
        self._mine: list[tuple[Part, _Half]] = []  # the parts that this rank takes
        self._blocks: list = []
        self.far = np.zeros((len(self.strip), 2))
        loads = np.stack([self._lifting(load) for load in (Load(P=0.0, Q=1.0), Load(P=1.0, Q=0.0))], axis=1)
        failure: Exception | None = None
        try:
            for number in range(self.comm.rank, self.comm.rank + len(found), self.comm.size):
                self._add(found[number] if number < len(found) else Part(NONE), inner, interface, loads)
        except Exception as error:  # of one rank, perhaps, which is to fail on all
            failure = error
        failures = [failure, *self.comm.allgather(failure)]
        for failure in filter(None, failures):
            raise failure
        self.far = self.comm.reduce(self.far)
        blocks = self.comm.gather(self._blocks)
        self._blocks = [block for rank in blocks for block in rank] if blocks else []

    def matrix(self, directions: tuple[int, ...]) -> ComplianceMatrix:
        """Compliance matrix C (r, mn) for unit forces along ``directions``, one after the other; on rank 0."""
        whole = ComplianceMatrix((len(self.strip), 2 * self.n), tuple(self._blocks))
        first = directions[0] * self.n
        return whole if len(directions) == 2 else whole.chosen(slice(first, first + self.n))

    def nodal(self, which: np.ndarray) -> np.ndarray:
        """Displacements (2m, 2m) of surface nodes ``which`` (bool (n,)) under unit forces on them, along x, then y.

        On rank 0.
        """
        chosen = np.flatnonzero(np.tile(which, 2))
        place = np.searchsorted(self.strip, self._surface_dofs.T.ravel()[chosen])
        ones, count = np.ones(len(chosen)), np.arange(len(chosen))
        rows = csr_matrix((ones, (count, place)), (len(chosen), len(self.strip)))
        return self.matrix((0, 1)).times(rows)[:, chosen]

    def strip_values(self, local=None) -> np.ndarray:
        """Values on the strip (r,), on every rank, of the ranks' ``local`` arrays; of the body's state by default."""
        local = self.body.state.x.array if local is None else local
        return gathered(self.comm, local[self._owned])[self._sorted]

    def put(self, values: np.ndarray):
        """Rank 0's ``values`` (r,) of the strip into the body's state."""
        values = self.comm.bcast(values) if self.comm.size > 1 else values
        self.body.state.x.array[self.strip_dofs] = values[self.position]

    def recover(self):
        """Bring the state beyond the strip up to date: equilibrium with the strip and the far field as they are."""
        body = self.body
        strip, right = self.strip_values(), self._lifting()
        u = np.zeros(len(right))
        for part, half in self._mine:
            own = part.among(self.strip).own(strip)
            u += part.matrix(len(u)) @ half.complete(part.restrict(right), own)
        if self.comm.size > 1:
            self.comm.Allreduce(MPI.IN_PLACE, u)
        u[self.strip] = strip
        first, last = body.stiffness.getOwnershipRange()
        body.state.x.array[: last - first] = u[first:last]
        body.state.x.scatter_forward()

    def _find_surface(self):
        body = self.body
        nodes = body.surface_nodes
        self.n = len(nodes.x)
        dofs = body.dofs[nodes.owned]
        self._surface_dofs = nodes.collect(self._global(dofs.ravel()).reshape(-1, 2))
        self._is_free = ~nodes.collect(np.isin(dofs, body.fixed_dofs))
        along, touched = self._surface_dofs[:, X], self._global(body.dofs[nodes.touched, X])
        by_dof = np.argsort(along)
        self.node_position = by_dof[np.searchsorted(along, touched, sorter=by_dof)]  # of ``touched``

    def _find_strip(self):
        """Number the strip's dofs; those inside it and those on its interface with the rest of the body."""
        body, topology = self.body, self.body.mesh.topology
        topology.create_connectivity(2, 2)
        # also those where the strip ends that belong to a rank without the cell that makes them the strip's
        self.strip_dofs = self._dofs_of(fem.locate_dofs_topological(body.space, 2, body.strip_cells))
        mine = self._global(self.strip_dofs)
        self.strip = np.unique(gathered(self.comm, mine))
        self.position = np.searchsorted(self.strip, mine)
        self._owned = self.strip_dofs[self.strip_dofs < body.stiffness.getLocalSize()[0]]
        self._sorted = np.argsort(gathered(self.comm, self._global(self._owned)))
        beyond_cells = np.setdiff1d(np.arange(topology.index_map(2).size_local), body.strip_cells)
        beyond = self._global(self._dofs_of(body.space.dofmap.list[beyond_cells]))
        interface = np.unique(gathered(self.comm, beyond[np.isin(beyond, self.strip)]))
        return np.setdiff1d(self.strip, interface), interface

    def _dofs_of(self, blocks):
        """Local dofs (sorted) of ``blocks`` of them."""
        blocks, size = np.unique(blocks).astype(np.int32), self.body.space.dofmap.index_map_bs
        return (size * blocks[:, None] + np.arange(size)).ravel()

    def _global(self, dofs):
        """Global numbers of local dofs."""
        dofmap = self.body.space.dofmap
        block, component = np.divmod(np.asarray(dofs, dtype=np.int32), np.int32(dofmap.index_map_bs))
        return dofmap.index_map.local_to_global(block) * dofmap.index_map_bs + component

    def _lifting(self, load: Load | None = None):
        """Forces (N,) on every rank that stand for the displacement prescribed far away: under ``load`` or as it is."""
        body = self.body
        if load is not None:
            body.set_far_field(load)
        b = body.stiffness.createVecLeft()
        body.stiffness.mult(body.far_value.x.petsc_vec, b)
        b.scale(-1.0)
        fem_petsc.set_bc(b, body.boundary_conditions)
        return gathered(self.comm, b.array_r)

    def _add(self, part, inner, interface, loads):
        """Factorise a part on this rank, or none, and keep its block of the compliance matrix. Collective."""
        half, r = _half(self.body, part, inner, interface), len(self.strip)
        if half is None:
            return
        self._mine.append((part, half))
        place = np.searchsorted(self.strip, self._surface_dofs.T.ravel())
        forces = csr_matrix((self._is_free.T.ravel().astype(float), (place, np.arange(2 * self.n))), (r, 2 * self.n))
        among = part.among(self.strip)
        rows = among.matrix(r)[:, half.inside_first]
        columns = (rows.T @ forces).tocoo()  # of the part's own surface
        own, column = np.unique(columns.row, return_inverse=True)
        columns = csr_matrix((columns.data, (columns.col, column)), (2 * self.n, len(own)))
        size = np.full(len(own), 0.5 if part.is_half else 1.0)
        unit = csr_matrix((size, (own, np.arange(len(own)))), (len(among.dofs), len(own)))
        self._blocks.append(Block(rows, half.respond(unit), columns, unit[: half.strip.border.shape[0]], half.strip))
        self.far += rows @ half.far(part.restrict(loads))


class _Half:
    """A part of the body on one rank: the factor of its bulk, and its strip condensed onto the interface.

    strip: stiffness inside it; inside_first: (r,) the strip's dofs of the part, those inside it before those of the
    interface.
    """

    def __init__(self, matrix: csr_matrix, is_inner: np.ndarray, is_interface: np.ndarray, definite: bool):
        """matrix: stiffness (h, h); is_inner, is_interface: (h,) which dofs are inside the strip, and on its edge."""
        self._bulk, self._inner = np.flatnonzero(~is_inner), np.flatnonzero(is_inner)
        in_strip = is_inner | is_interface
        self.inside_first = np.argsort(is_interface[in_strip], kind="stable")
        self._kept = np.flatnonzero(is_interface[self._bulk])
        self._factor = PartialFactor(matrix[self._bulk][:, self._bulk], self._kept, definite)
        self._assume = "pos" if definite else "sym"
        inside = matrix[self._inner][:, np.concatenate([self._inner, np.flatnonzero(is_interface)])]
        m = len(self._inner)
        self.strip = StripInside(inside[:, :m].tocsc(), inside[:, m:], definite)
        self._response = self.strip.factor.solve(self.strip.border.toarray())
        self._schur = self._factor.schur - self.strip.border.T @ self._response

    def respond(self, forces: csr_matrix) -> np.ndarray:
        """Displacements (r, c) of the strip under forces (r, c) on it, both with its inside first."""
        m = len(self._inner)
        return self._displacements(forces[:m], forces[m:].toarray())

    def far(self, forces: np.ndarray) -> np.ndarray:
        """Displacements (r, c) of the strip, its inside first, under forces (h, c) anywhere."""
        fixed = np.stack([self._factor.solve(column)[self._kept] for column in forces[self._bulk].T], axis=1)
        return self._displacements(csr_matrix(forces[self._inner]), self._factor.schur @ fixed)

    def complete(self, forces: np.ndarray, strip: np.ndarray) -> np.ndarray:
        """Displacements (h,) of the whole part where the strip's (r,) are known, under forces (h,) on the bulk."""
        right = forces[self._bulk]
        right[self._kept] -= self.strip.border.T @ strip[self.inside_first[: len(self._inner)]]
        displacements = np.zeros(len(forces))
        displacements[self._bulk] = self._factor.solve(right)
        return displacements

    def _displacements(self, inside, on_interface):
        """Those of the strip under forces inside it (m, c; sparse) and on its interface, those of the bulk condensed
        onto that.
        """
        on_interface = on_interface - (inside.T @ self._response).T  # the stiffness inside is symmetric
        u = solve(self._schur, on_interface, assume_a=self._assume, check_finite=False)
        m = inside.shape[0]
        joined = np.empty((m + len(u), u.shape[1]))  # row by row, for products with sparse matrices
        joined[:m], joined[m:] = self.strip.solve(inside.toarray(), u), u
        return joined


def _half(body: ElasticBody, part: Part, inner, interface) -> "_Half | None":
    """What this rank knows of its own part; None where that is empty. Collective."""
    dofs = part.dofs
    matrix = _submatrix(body.constrained_stiffness, dofs)
    if not len(dofs):
        return None
    row = np.repeat(part.on_axis, np.diff(matrix.indptr))
    matrix.data[row & part.on_axis[matrix.indices]] *= 0.5
    return _Half(matrix, np.isin(dofs, inner), np.isin(dofs, interface), not body.mixed)


def _submatrix(matrix: PETSc.Mat, dofs: np.ndarray) -> csr_matrix:
    """Rows and columns ``dofs`` (h,), sorted global numbers, of a distributed matrix on this rank. Collective."""
    wanted = [PETSc.IS().createGeneral(np.asarray(dofs, PETSc.IntType), comm=PETSc.COMM_SELF)]
    (found,) = matrix.createSubMatrices(wanted, wanted)
    chosen = csr_matrix(found.getValuesCSR()[::-1], found.size)
    found.destroy()
    return chosen
