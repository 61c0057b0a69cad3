"""Collective operations and the mesh's partition, asked of every rank.

On one rank these are ordinary tests; tests/test_mpi.py runs the folder under mpirun on two and three.
"""

import ctypes
import re

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc
from running import coarse_overrides

from simulations.fem.mesh import create_mesh
from simulations.fem.parallel import gathered, on_root
from simulations.runs import freeing
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, parse

comm = MPI.COMM_WORLD


def test_each_rank_owns_neighbouring_columns():
    """From top to bottom, as many as the others: of two ranks each owns one half of the body."""
    ends = np.linspace(-1.0, 1.0, 4 * comm.size + 1)
    mesh, facets = create_mesh(comm, ends, np.linspace(0.0, 1.0, 6))
    assert mesh.topology.index_map(2).size_local == 4 * 5
    x = mesh.geometry.x[mesh.geometry.dofmap][..., 0]
    assert [x.min(), x.max()] == [ends[4 * comm.rank], ends[4 * (comm.rank + 1)]]
    assert len(facets.find(1)) == 4


def test_rows_are_gathered_in_the_order_of_ranks():
    rows = np.full((comm.rank + 1, 2), float(comm.rank))
    found = gathered(comm, rows)
    assert found.tolist() == [[float(rank)] * 2 for rank in range(comm.size) for _ in range(rank + 1)]


def test_a_failure_of_rank_0_is_raised_everywhere():
    assert on_root(comm, lambda: comm.rank) == 0
    with pytest.raises(ZeroDivisionError):
        on_root(comm, lambda: 1 // 0)


def test_a_load_step_leaves_no_vectors(capfd):
    """Across ranks PETSc keeps what Python has dropped until it is asked: of a short run hundreds of vectors."""
    scene = parse(DEFAULT_SCENE, coarse_overrides(solver__method='"full"', load__cycles=0))
    simulation = Simulation(comm, scene).run_to_end()
    capfd.readouterr()
    for own in freeing.communicators(simulation.body):
        PETSc.garbage_view(own)
    ctypes.CDLL(None).fflush(None)
    found = [int(count) for count in re.findall(r"Total entries: (\d+)", capfd.readouterr().out)]
    assert found == [0] * (0 if comm.rank else 2 * comm.size)


def test_a_strip_that_ends_between_two_ranks():
    """On three: one of them has nodes of the strip's last cells, but not the cells."""
    mesh = {"mesh__facet": 0.2, "mesh__edge_facet": 0.04, "mesh__growth": 1.15, "mesh__extent": 200.0}
    simulation = Simulation(comm, parse(DEFAULT_SCENE, coarse_overrides(load__cycles=0, solver__increments=1, **mesh)))
    middle = (simulation.ordinates[0][1:] + simulation.ordinates[0][:-1]) / 2
    first = np.argmax(np.abs(middle) < simulation.cells.strip)
    if comm.size == 3:
        assert 3 * first == len(middle) + 1  # columns of the first rank
    energy = simulation.run_to_end().history.dissipated_energy
    assert energy == pytest.approx(0.0110714388, rel=1e-6)
