"""Load steps of the mesh-free reference: small ones where P grows with coupling, as each leaves an error of its own."""

import numpy as np
import pytest
from running import COARSE
from solving import simulated

from simulations.fem.load import Load
from simulations.loading.schedule import LoadStep, visiting
from simulations.runs import mesh_free
from simulations.runs.comparison import apart
from simulations.runs.history import all_states
from simulations.runs.mesh_free import MeshFree, equal_shares

PATH = COARSE | {
    "solid.modulus": "homogeneous",
    "solid.E0": 210e9,
    "solid.nu": 0.3,
    "indenter.R": 0.1,
    "load.mu": 0.6,
    "load.points": [[1e6, 0.0], [8e5, 1e5], [1e6, -1e5]],
    "solver.increments": 3,
    "mesh.facet": 0.05,
    "mesh.edge_facet": 4e-3,
    "mesh.first_layer": 4e-3,
}


def test_there_are_more_load_steps_where_P_grows_most_where_it_begins_to():
    """Where P falls there are as many as for any other load."""
    schedule = [LoadStep(Load(1.0)), *visiting(Load(1.0), [Load(0.8, 0.1), Load(1.0, -0.1)], 10)]
    steps = [len(parts) for parts in equal_shares(schedule, friction_first=False, finer=2, small=0.0051)]
    assert steps == 10 * [2] + [12] + 9 * [4]
    assert {len(parts) for parts in equal_shares(schedule, friction_first=False, finer=2)} == {2}


@pytest.mark.slow
def test_small_load_steps_where_P_grows_leave_a_tenth_of_the_error(monkeypatch):
    """Points come into contact in stick there. Where P falls no more steps are needed."""
    simulation = simulated(PATH, base=None)
    fine, small = (MeshFree(simulation, nodes=(150,), finer=finer) for finer in (9, 3))
    monkeypatch.setattr(mesh_free, "SMALL_GROWTH", np.inf)
    equal, states = MeshFree(simulation, nodes=(150,), finer=3), all_states(simulation.history)

    def worst(other, entries=states):
        return max(apart(entry, other, fine)["traction_l2"] for entry in entries)

    assert worst(equal, states[:3]) < 5e-3
    assert worst(small) < 6e-3 and worst(equal) > 0.04
