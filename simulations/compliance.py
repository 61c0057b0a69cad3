"""What the body is to its surface: the response to contact forces, from one factorisation of each half.

The body outside the strip is factorised down to the interface with the strip, to which it leaves a dense Schur
complement; the strip, one row of cells, is added to that as a dense system. No response is solved for one by one. On a
mesh that is its own mirror image the two halves (``mirror``) are independent, and two ranks do one each.
"""

import numpy as np
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc
from scipy.linalg import solve
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

from .body import HalfPlane, gathered
from .mirror import NONE, Part, parts
from .response import Response
from .schur import PartialFactor


class Compliance:
    """Response of the strip to unit nodal forces on the surface and to unit line loads in the far field.

    It depends on the body alone. Surface nodes are sorted by x. ``strip`` holds the global dofs (r,) of the strip
    cells, sorted; rank 0 has ``far`` (r, 2), columns Q and P, and ``response``; None elsewhere.
    """

    def __init__(self, body: HalfPlane):
        self.body, self.comm = body, body.mesh.comm
        self._find_surface()
        inner, interface = self._find_strip()
        found = parts(body)
        self._halves: list[tuple[int, Part, _Half | None]] = []  # owner, part, and what the owner knows of it
        self._blocks: list = []
        self.far = np.zeros((len(self.strip), 2)) if self.comm.rank == 0 else None
        loads = np.stack([self._lifting(load) for load in np.eye(2)], axis=1)
        for start in range(0, len(found), self.comm.size):
            self._add(found[start : start + self.comm.size], inner, interface, loads)

    def response(self, directions: tuple[int, ...]) -> Response:
        """R (r, mn) to unit forces along ``directions``, one after the other; on rank 0."""
        whole = Response(tuple(self._blocks))
        return (
            whole if len(directions) == 2 else whole.chosen(slice(directions[0] * self.n, (directions[0] + 1) * self.n))
        )

    def collect(self, owned: np.ndarray) -> np.ndarray:
        """Rows (n, ...) sorted by x, on every rank, from those of the owned surface nodes."""
        return gathered(self.comm, owned)[self.order]

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
        for owner, part, half in self._halves:
            if owner == self.comm.rank:
                part.extend(half.complete(part.restrict(right), self._of_part(part, strip)), u)
        if self.comm.size > 1:
            self.comm.Allreduce(MPI.IN_PLACE, u)
        u[self.strip] = strip
        first, last = body.stiffness.getOwnershipRange()
        body.state.x.array[: last - first] = u[first:last]
        body.state.x.scatter_forward()

    def _of_part(self, part, strip):
        """The strip's values (r,) as displacements of a part: twice what ``restrict`` makes of forces on a half."""
        among = part.among(self.strip)
        return among.restrict(strip) * np.where(among.on_axis, 2.0, 1.0)

    def _find_surface(self):
        body = self.body
        nodes = fem.locate_dofs_topological(body.displacements, 1, body.strip)
        self.touched = nodes  # owned and ghost surface nodes, to which this rank's facets contribute
        self.surface = nodes[nodes < body.owned_nodes]
        x = gathered(self.comm, body.displacements.tabulate_dof_coordinates()[self.surface, 0])
        self.order = np.argsort(x)
        self.n = len(self.order)
        by_id = np.argsort(ids := self.collect(self._node_ids(self.surface)))
        self.node_position = by_id[np.searchsorted(ids, self._node_ids(nodes), sorter=by_id)]  # of ``touched``
        dofs = body.dofs[self.surface]
        self._surface_dofs = self.collect(self._global(dofs.ravel()).reshape(-1, 2))
        fixed = np.isin(dofs, body.fixed_dofs)
        self._is_free = ~self.collect(fixed)

    def _node_ids(self, nodes):
        return self.body.displacements.dofmap.index_map.local_to_global(nodes.astype(np.int32))

    def _find_strip(self):
        """Number the strip's dofs; those inside it and those on its interface with the rest of the body."""
        body = self.body
        count = body.mesh.topology.index_map(2).size_local
        is_strip = np.zeros(count + body.mesh.topology.index_map(2).num_ghosts, dtype=bool)
        is_strip[body.strip_cells] = True
        self.strip_dofs = self._dofs_of(np.flatnonzero(is_strip))
        mine = self._global(self.strip_dofs)
        self.strip = np.unique(gathered(self.comm, mine))
        self.position = np.searchsorted(self.strip, mine)
        self._owned = self.strip_dofs[self.strip_dofs < body.stiffness.getLocalSize()[0]]
        self._sorted = np.argsort(gathered(self.comm, self._global(self._owned)))
        others = np.unique(gathered(self.comm, self._global(self._dofs_of(np.flatnonzero(~is_strip[:count])))))
        interface = np.intersect1d(self.strip, others)
        return np.setdiff1d(self.strip, interface), interface

    def _dofs_of(self, cells):
        """Local dofs (sorted) of ``cells``."""
        dofmap = self.body.space.dofmap
        blocks, size = np.unique(dofmap.list[cells]).astype(np.int32), dofmap.index_map_bs
        return (size * blocks[:, None] + np.arange(size)).ravel()

    def _global(self, dofs):
        """Global numbers of local dofs."""
        dofmap = self.body.space.dofmap
        block, component = np.divmod(np.asarray(dofs, dtype=np.int32), np.int32(dofmap.index_map_bs))
        return dofmap.index_map.local_to_global(block) * dofmap.index_map_bs + component

    def _lifting(self, load=None):
        """Forces (N,) on every rank that stand for the displacement prescribed far away: under ``load`` or as it is."""
        body = self.body
        if load is not None:
            body.set_far_field(load)
        b = body.stiffness.createVecLeft()
        body.stiffness.mult(body.far_value.x.petsc_vec, b)
        b.scale(-1.0)
        fem_petsc.set_bc(b, body.boundary_conditions)
        return gathered(self.comm, b.array_r)

    def _add(self, found, inner, interface, loads):
        """Factorise one part a rank and add what each contributes to the response."""
        rank, r = self.comm.rank, len(self.strip)
        half = _extract(self.body, found[rank] if rank < len(found) else Part(NONE), inner, interface)
        place = np.searchsorted(self.strip, self._surface_dofs.T.ravel())
        forces = csr_matrix((self._is_free.T.ravel().astype(float), (place, np.arange(2 * self.n))), (r, 2 * self.n))
        for owner, part in enumerate(found):
            self._halves.append((owner, part, half if owner == rank else None))
            among = part.among(self.strip)
            rows = among.matrix(r)
            columns = (rows.T @ forces).tocoo()  # of the part's own surface
            own, column = np.unique(columns.row, return_inverse=True)
            columns = csr_matrix((columns.data, (columns.col, column)), (2 * self.n, len(own)))
            blocks = None
            if owner == rank:
                unit = np.zeros((len(among.dofs), len(own)))
                unit[own, np.arange(len(own))] = 0.5 if part.is_half else 1.0
                blocks = half.respond(unit), half.far(part.restrict(loads))
            if owner and rank == owner:  # rank 0 needs it
                self.comm.send(blocks, dest=0)
            elif owner and rank == 0:
                blocks = self.comm.recv(source=owner)
            if rank == 0:
                self._blocks.append((rows, blocks[0], columns))
                self.far += rows @ blocks[1]


class _Half:
    """A part of the body on one rank: the factor of its bulk, and its strip condensed onto the interface."""

    def __init__(self, bulk: csr_matrix, inside: csr_matrix, place, definite: bool):
        """inside: rows of the strip's inner dofs, columns those and the interface; place: of bulk and strip dofs."""
        self._bulk, self._inner = place["bulk"], place["inner"]
        self._in_strip = place["inner in strip"], place["interface in strip"]
        self._kept = place["interface in bulk"]
        self._factor = PartialFactor(bulk, self._kept, definite)
        self._assume = "pos" if definite else "sym"
        m = len(self._inner)
        self._border = inside[:, m:]
        self._inside = splu(inside[:, :m].tocsc())
        self._response = self._inside.solve(self._border.toarray())
        self._schur = self._factor.schur - self._border.T @ self._response

    def respond(self, forces: np.ndarray) -> np.ndarray:
        """Displacements (r, c) of the strip under forces (r, c) on it."""
        inner, interface = self._in_strip
        return self._join(forces[inner], forces[interface])

    def far(self, forces: np.ndarray) -> np.ndarray:
        """Displacements (r, c) of the strip under forces (h, c) anywhere."""
        fixed = np.stack([self._factor.solve(column)[self._kept] for column in forces[self._bulk].T], axis=1)
        return self._join(forces[self._inner], self._factor.schur @ fixed)

    def complete(self, forces: np.ndarray, strip: np.ndarray) -> np.ndarray:
        """Displacements (h,) of the whole part where the strip's are known, under forces (h,) on the bulk."""
        right = forces[self._bulk]
        right[self._kept] -= self._border.T @ strip[self._in_strip[0]]
        displacements = np.zeros(len(forces))
        displacements[self._bulk] = self._factor.solve(right)
        return displacements

    def _join(self, inside, on_interface):
        """Displacements of the strip under forces inside it and on its interface, those of the bulk condensed onto
        that.
        """
        particular = self._inside.solve(np.ascontiguousarray(inside))
        on_interface = on_interface - self._border.T @ particular
        u = solve(self._schur, on_interface, assume_a=self._assume, check_finite=False)
        joined = np.empty((len(particular) + len(u), u.shape[1]))
        inner, interface = self._in_strip
        joined[inner], joined[interface] = particular - self._response @ u, u
        return joined


def _extract(body: HalfPlane, part: Part, inner, interface) -> "_Half | None":
    """Every rank takes the matrices of its own part out of the distributed stiffness; empty parts give None."""
    dofs = part.dofs
    is_inner = np.isin(dofs, inner)
    bulk, strip = dofs[~is_inner], dofs[np.isin(dofs, inner) | np.isin(dofs, interface)]
    first, last = dofs[is_inner], dofs[np.isin(dofs, interface)]
    matrix = body.constrained_stiffness
    axis = dofs[part.on_axis]
    rest = _submatrix(matrix, bulk, bulk, axis)
    inside = _submatrix(matrix, first, np.concatenate([first, last]), axis)
    if not len(dofs):
        return None
    place = {
        "bulk": np.flatnonzero(~is_inner),
        "inner": np.flatnonzero(is_inner),
        "inner in strip": np.searchsorted(strip, first),
        "interface in strip": np.searchsorted(strip, last),
        "interface in bulk": np.searchsorted(bulk, last),
    }
    return _Half(rest, inside, place, not body.mixed)


def _submatrix(matrix: PETSc.Mat, rows, columns, axis) -> csr_matrix:
    """Rows and columns (global) of a distributed matrix on this rank; entries between axis dofs belong to a half by
    half.
    """
    order = np.argsort(columns, kind="stable")  # PETSc wants them sorted
    wanted = [
        PETSc.IS().createGeneral(np.asarray(d, PETSc.IntType), comm=PETSc.COMM_SELF) for d in (rows, columns[order])
    ]
    (found,) = matrix.createSubMatrices(wanted[:1], wanted[1:])
    indptr, indices, data = found.getValuesCSR()
    found.destroy()
    for row in np.flatnonzero(np.isin(rows, axis)):
        entries = slice(indptr[row], indptr[row + 1])
        data[entries][np.isin(columns[order[indices[entries]]], axis)] *= 0.5
    result = csr_matrix((data, indices, indptr), shape=(len(rows), len(columns)))
    return result if np.array_equal(order, np.arange(len(order))) else result[:, np.argsort(order)]
