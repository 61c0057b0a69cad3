"""Nodes of the mesh lie where they are meant to be, to the last digit."""

import numpy as np
import pytest
from mpi4py import MPI

from forms.modulus import PowerLaw
from simulations.fem.mesh import Grading, columns, create_mesh, layers


@pytest.mark.parametrize("edges", [(-1.0, 1.0), (-1.03, -0.97, -0.31, 0.31, 0.97, 1.03)])
def test_symmetric_edges_give_a_mesh_that_is_its_own_mirror_image(edges):
    """Cells of 0.001 by 20 beside the axis: round-off of the domain in their widths left forces of 1e-5 of the load."""
    grading = Grading((*edges, 0.0), edge_facet=1e-3, first_layer=1e-3, extent=100.0)
    x, s = columns(grading), layers(grading, PowerLaw.of(0.023).depth_map())
    assert np.array_equal(x, -x[::-1])
    mesh, _ = create_mesh(MPI.COMM_SELF, x, s)
    assert np.array_equal(np.unique(mesh.geometry.x[:, 0]), x)
    assert np.array_equal(np.unique(mesh.geometry.x[:, 1]), s)


def test_edges_that_are_not_symmetric_stay_where_they_are():
    x = columns(Grading((-1.0, 1.0 + 1e-6), edge_facet=1e-3, extent=100.0))
    assert 1e-8 < np.abs(x + x[::-1]).max() < 1e-4
