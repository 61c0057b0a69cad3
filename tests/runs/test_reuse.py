"""A body is taken over by scenes of the same solid that ask for the same mesh, and refused to all others."""

from time import sleep

import numpy as np
import pytest
from mpi4py import MPI
from running import COARSE

from simulations.runs.simulation import Simulation
from simulations.runs.timing import Stopwatch
from simulations.scene import make_scene

BASE = COARSE | {"load.cycles": 0, "solid.y0": 0.01}


@pytest.fixture(scope="module")
def first():
    return Simulation(MPI.COMM_SELF, make_scene(BASE))


@pytest.mark.parametrize(
    "changes, reason",
    [
        ({"solid.nu": 0.2}, "another solid"),
        ({"solid.k": 0.2}, "another solid"),
        ({"mesh.degree": 3}, "mesh.degree = 3, not 2"),
        ({"mesh.facet": 0.05}, "mesh.facet = 0.05, not 0.1"),
        ({"mesh.edge_facet": 0.01}, "mesh.edge_facet = 0.01, not 0.02"),
        ({"mesh.growth": 1.4}, "mesh.growth = 1.4, not 1.6"),
        ({"mesh.layer_growth": 1.4}, "mesh.layer_growth = 1.4, not 1.6"),
        ({"mesh.first_layer": 0.01}, "mesh.first_layer = 0.01, not 0.02"),
        ({"mesh.extent": 30}, "mesh.extent = 30, not 20"),
        ({"mesh.edges": "states"}, "too coarse where contact or stick may end, at x = 0.895 a"),
        ({"load.amplitude": 0.6}, "too coarse where contact or stick may end, at x = 0.856 a"),
        ({"load.amplitude": 0.05}, "too coarse"),
        ({"load.mu": None, "load.amplitude": None, "load.cycles": None}, "symmetry is on in one of them only"),
    ],
)
def test_what_is_refused(first, changes, reason):
    scene = make_scene(BASE | changes)
    with pytest.raises(ValueError, match="the body cannot be taken over: ") as error:
        Simulation(MPI.COMM_SELF, scene, like=first)
    assert reason in str(error.value)


def test_what_is_reused_has_the_numbers_of_its_own_body(first):
    scene = make_scene(BASE | {"load.mu": 0.5, "solid.E0": 70e9, "load.P": 2e6})
    shared = Simulation(MPI.COMM_SELF, scene, like=first).run_to_end()
    alone = Simulation(MPI.COMM_SELF, scene).run_to_end()
    assert shared.body is first.body
    for mine, own in zip(shared.history.entries, alone.history.entries, strict=True):
        for name in ("pressure", "traction"):
            one, other = getattr(mine.surface, name), getattr(own.surface, name)
            assert np.abs(one - other).max() <= 1e-8 * own.surface.pressure.max()


def test_seconds_of_a_phase_within_another_are_counted_once():
    watch = Stopwatch()
    with watch("mesh"):
        with watch("edges"):
            sleep(0.1)
        assert watch.last >= 0.1
    assert watch.last >= 0.1 and watch.seconds["mesh"] < 0.05 < watch.seconds["edges"]
