"""What several ranks share, checked on every one of them: run under mpirun by test_cost."""

import numpy as np
from mpi4py import MPI

from simulations.mesh import half_plane
from simulations.workers import SharedMatrix, Workers, on_root

comm = MPI.COMM_WORLD


def check_columns():
    """Each rank owns neighbouring columns from top to bottom, as many as the others (of two, one half each)."""
    ends = np.linspace(-1.0, 1.0, 4 * comm.size + 1)
    mesh, facets = half_plane(comm, ends, np.linspace(0.0, 1.0, 6))
    assert mesh.topology.index_map(2).size_local == 4 * 5
    x = mesh.geometry.x[mesh.geometry.dofmap][..., 0]
    assert [x.min(), x.max()] == [ends[4 * comm.rank], ends[4 * (comm.rank + 1)]]
    assert len(facets.find(1)) == 4


def check_sums():
    """Rank 0 gets the sum over the ranks, as often as it asks; nobody hears of it elsewhere."""
    workers = Workers(comm)
    workers.can("share", lambda factor: factor * np.full(3, comm.rank + 1.0))
    total = comm.size * (comm.size + 1) / 2
    found = workers.lead(lambda: [workers.sum("share", float(i)).tolist() for i in range(comm.size + 1)])
    assert found == ([3 * [i * total] for i in range(comm.size + 1)] if comm.rank == 0 else None)


def check_matrix():
    """Products with a matrix that only rank 0 has, replaced by one of another size."""
    workers = Workers(comm)
    matrix = SharedMatrix(workers, "matrix")
    for n in (7, 2, 11):
        whole, b = np.random.default_rng(n).random((n, n)), np.arange(1.0, n + 1)
        workers.lead(lambda: matrix.keep(np.asfortranarray(whole)))
        product = workers.lead(lambda: matrix.times(b))
        assert (product is None) == (matrix.whole is None) == (comm.rank > 0)
        if comm.rank == 0:
            np.testing.assert_allclose(product, whole @ b, rtol=1e-14)


def check_failure():
    """What fails on rank 0 while it leads fails there alone, and lets the others go; what it does for all, on all."""
    workers = Workers(comm)
    try:
        workers.lead(lambda: 1 // 0)
        assert comm.rank > 0
    except ZeroDivisionError:
        assert comm.rank == 0
    assert on_root(comm, lambda: comm.rank) == 0
    try:
        on_root(comm, lambda: 1 // 0)
    except ZeroDivisionError:
        return
    raise AssertionError("no failure")


for check in (check_columns, check_sums, check_matrix, check_failure):
    check()
    comm.Barrier()
if comm.rank == 0:
    print("as many as", comm.size)
