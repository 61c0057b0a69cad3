"""What several ranks share, checked on every one of them: run under mpirun by test_cost."""

import numpy as np
from mpi4py import MPI

from simulations.fem.mesh import create_mesh
from simulations.fem.parallel import on_root
from simulations.solvers.condensed.workers import SharedInverse, Workers

comm = MPI.COMM_WORLD


def check_columns():
    """Each rank owns neighbouring columns from top to bottom, as many as the others (of two, one half each)."""
    ends = np.linspace(-1.0, 1.0, 4 * comm.size + 1)
    mesh, facets = create_mesh(comm, ends, np.linspace(0.0, 1.0, 6))
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


def check_inverse():
    """Inverses of matrices that only rank 0 has, some of their rows those of the identity, one size after another."""
    workers = Workers(comm)
    inverse = SharedInverse(workers)
    for n in (7, 2, 11):
        random = np.random.default_rng(n)
        matrix, active, b = np.eye(n) + 0.3 * random.random((n, n)), random.random(n) < 0.7, np.arange(1.0, n + 1)
        matrix[~active] = np.eye(n)[~active]
        done = workers.lead(lambda: inverse.invert(matrix[active], active))
        product = workers.lead(lambda: inverse.times(b))
        if comm.rank == 0:
            assert done
            np.testing.assert_allclose(inverse.whole @ matrix, np.eye(n), atol=1e-12)
            np.testing.assert_allclose(matrix @ product, b, rtol=1e-12)
        assert (product is None) == (inverse.whole is None) == (comm.rank > 0)
    done = workers.lead(lambda: inverse.invert(np.ones((2, 2)), np.ones(2, bool)))
    assert done is (False if comm.rank == 0 else None)


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


for check in (check_columns, check_sums, check_inverse, check_failure):
    check()
    comm.Barrier()
if comm.rank == 0:
    print("as many as", comm.size)
