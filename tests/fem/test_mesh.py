"""Nodes of the mesh lie where they are meant to be, to the last digit."""

from dataclasses import replace

import gmsh
import numpy as np
import pytest
from mpi4py import MPI

from forms.depth_map import DepthMap
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
    assert np.diff(x).max() > 10  # far from the contact columns are wide


@pytest.mark.parametrize("at", [0.0, 0.3, 0.5])
def test_edges_are_placed_in_their_facets(at):
    """On a symmetric mesh, both edges on both sides; an edge too close to another stays where it falls."""
    grading = Grading((-1.0, -0.999, -0.3, 0.3, 0.999, 1.0), edge_at=at)
    x = columns(grading)
    assert x == pytest.approx(-x[::-1], abs=1e-11)
    for edge in (0.3, 1.0):
        assert_placed(edge, x, at)
    assert len(x) == len(columns(replace(grading, edge_at=-1.0)))
    stops = tuple((side * 1.0005, side * 1.0005, 1e-3) for side in (-1, 1))
    assert_placed(1.0, columns(Grading((-1.0, 1.0), edge_at=at, sweeps=stops)), at)  # an edge before a stop


def assert_placed(edge, x, at):
    last = np.searchsorted(x, edge * (1 - 1e-12)) - 1
    place = (edge - x[last]) / (x[last + 1] - x[last])
    assert place % 1.0 == pytest.approx(at, abs=0.02) or (at == 0.0 and place == pytest.approx(1.0))


DEPTHS = pytest.mark.parametrize("depth", [DepthMap(), DepthMap(1 / 0.7, False)], ids=["y", "s"])


@DEPTHS
def test_layers_grow_by_a_ratio_from_the_first_to_the_end_of_the_domain(depth):
    """All of them are a little thinner than asked for; in s that on the surface by far."""
    heights = np.diff(depth.y(layers(Grading((1.0,), first_layer=1e-3, layer_growth=1.3, extent=20.0), depth)))
    assert heights.sum() == pytest.approx(20.0) and heights[-1] / heights[-2] == pytest.approx(1.3, rel=0.01)
    assert 1e-3 / 1.3 < heights[0] <= 1e-3 if depth.is_identity else heights[0] < 1e-3 / 1.3


@DEPTHS
def test_a_layer_begins_where_the_modulus_has_a_kink(depth):
    y = depth.y(layers(Grading(edges=(-1.0, 1.0)), depth, [0.37]))
    assert np.abs(y - 0.37).min() < 1e-12 and np.all(np.diff(y) > 0)


def test_every_kink_of_a_table_has_a_layer_those_in_one_cell_too():
    inside, beyond = [0.3, 0.37, 0.3701, 5.0], [20.0, 1e9]  # the domain ends at 20
    y = layers(Grading(edges=(-1.0, 1.0)), DepthMap(), inside + beyond)
    assert np.isin(inside, y).all() and np.all(np.diff(y) > 5e-5)
    assert len(y) <= len(layers(Grading(edges=(-1.0, 1.0)), DepthMap())) + 1


def test_facets_beside_many_stops_are_the_least_of_all_their_cones():
    """Against each stop by itself."""
    random = np.random.default_rng(1)
    stops = tuple((place, place, size) for place, size in random.uniform([-1, 1e-4], [1, 1e-2], (50, 2)))
    x = random.uniform(-2, 2, 300)
    each = [Grading((1.0,), sweeps=(stop,)).facet_size(x) for stop in stops]
    assert Grading((1.0,), sweeps=stops).facet_size(x) == pytest.approx(np.min(each, axis=0), rel=1e-12)
    assert Grading((1.0,), sweeps=stops[:1]).facet_size(stops[0][0] + 0.01) == pytest.approx(
        stops[0][2] + 0.01 * np.log(1.8), rel=1e-12
    )  # few facets beside each


def refuse(*_):
    raise RuntimeError("no mesh")


@pytest.mark.parametrize("fails", [False, True])
def test_the_session_of_a_caller_is_left_as_it_was(fails, monkeypatch):
    x = s = np.array([0.0, 0.3, 1.0])
    if fails:
        monkeypatch.setattr(gmsh.model.mesh, "generate", refuse)
    for is_open in (False, True):
        if is_open:
            gmsh.initialize(interruptible=False)
            gmsh.model.add("mine")
            gmsh.option.setNumber("Mesh.ElementOrder", 2)
        try:
            mesh, _ = create_mesh(MPI.COMM_SELF, x, s)
            assert mesh.topology.index_map(2).size_local == 4
        except RuntimeError:
            assert fails
        assert gmsh.isInitialized() == is_open
    assert (gmsh.model.list(), gmsh.model.getCurrent()) == (["", "mine"], "mine")
    assert gmsh.option.getNumber("Mesh.ElementOrder") == 2
    gmsh.finalize()
