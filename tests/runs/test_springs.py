"""The exact reference of uncoupled runs: on loops the closed forms, at a sharp tip a mean, on paths no load steps."""

import pytest
from solving import coarse_simulation

from simulations.runs.comparison import compare_state
from simulations.runs.springs import Springs

UNCOUPLED = {"effects__coupling": "false", "solid__nu": 0.3}


@pytest.mark.parametrize("k", [-0.3, 0.0, 0.3])
def test_a_loop_has_the_closed_forms(k):
    simulation = coarse_simulation(solid__k=k, **UNCOUPLED).run_to_end()
    springs, loop = Springs(simulation.contact, simulation.mu, simulation.schedule), simulation.loop
    assert springs.dissipated_energy() == pytest.approx(loop.dissipated_energy, rel=1e-9)
    for entry in simulation.history.last_cycle:
        x, step = entry.surface.x, entry.increment
        exact = loop.traction(x, Q=step.Q, branch=step.branch)
        assert springs.traction(entry, x) == pytest.approx(exact, abs=1e-9)
        assert springs.stick_half_width(entry) == pytest.approx(loop.active_half_width(step.Q, step.branch), rel=1e-9)


def test_the_node_at_a_sharp_tip_has_a_finite_pressure():
    """There the exact pressure is infinite, and that of a node is a mean."""
    sharp = {"indenter__profile": "power", "indenter__exponent": 1.1, "load__cycles": 0}
    simulation = coarse_simulation(**sharp).run_to_end()
    entry = simulation.history.entries[-1]
    springs = Springs(simulation.contact, simulation.mu, simulation.schedule)
    assert compare_state(entry, springs)["pressure_l2"] < 0.05
