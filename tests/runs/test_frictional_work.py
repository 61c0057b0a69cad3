"""The energy that friction takes on a straight way of the loads follows from the balance of energy."""

import pytest
from running import COARSE
from solving import simulated

from simulations.runs.closed_forms import Springs
from simulations.runs.simulation import Simulation

SOLID = {"solid.E0": 210e9, "solid.nu": 0.3, "solid.modulus": "homogeneous", "indenter.R": 0.1, "load.mu": 0.3}
STRONG = SOLID | {"solid.modulus": "power law", "solid.k": 0.5, "solid.y0_over_a0": 10.0, "solid.nu": 0.495}
STRONG |= {"load.P": 1e6, "load.mu": 1.0, "load.amplitude": 0.95}
UNCOUPLED = {"effects.coupling": False}
LOOP = {"load.P": 1e6, "load.amplitude": 0.9}
FALLING = SOLID | {"load.points": [[8.9e5, 0.0], [7.1e5, 9.8e4], [2.7e5, 6.5e3], [6.1e5, 1.3e5]]}


def run(scene, steps, cells=None) -> Simulation:
    return simulated(COARSE | scene | {"solver.increments": steps}, None, cells)


def by_points(history) -> float:
    """Energy of the last cycle, or of the whole path, from each load step's two states alone."""
    entries = history.last_cycle if history.has_cycle else history.entries[1:]
    return sum(entry.surface.line_load(entry.own_work) for entry in entries)


def test_strong_coupling_with_few_load_steps():
    """Of a loop, whose states do not depend on the load steps; each point begins to slide somewhere within one."""
    few = run(STRONG, 3)
    many = run(STRONG, 24, few.cells).history.dissipated_energy
    assert few.history.dissipated_energy == pytest.approx(many, rel=2e-3)
    assert by_points(few.history) / many - 1 > 3e-3


def test_while_P_changes_without_coupling():
    """Beside the springs, which are exact; points enter contact in stick, slide, and leave it."""
    simulation = run(FALLING | UNCOUPLED, 6)
    exact = Springs(simulation.contact, simulation.mu, simulation.schedule).dissipated_energy()
    assert simulation.history.dissipated_energy == pytest.approx(exact, rel=2e-3)
    assert abs(by_points(simulation.history) / exact - 1) > 5e-3


@pytest.mark.parametrize(
    "scene, steps",
    [(STRONG | UNCOUPLED, 6), (STRONG | {"load.cycles": 0}, 3), (SOLID | LOOP | {"solid.nu": 0.45}, 6)],
    ids=["constant P without coupling", "few load steps", "both sums alike"],
)
def test_where_points_are_as_good_they_count(scene, steps):
    history = run(scene, steps).history
    assert history.dissipated_energy == pytest.approx(by_points(history), rel=1e-12)


def test_a_dwell_and_a_point_on_the_way_change_nothing():
    """Work of every point; the way to the last point is one with that to the point before."""
    loads = [[1e6, 0.0], [1e6, 2.7e5], [1e6, 0.0], [1e6, 0.0], [1e6, -2.7e5]]
    straight = run(SOLID | {"load.points": [loads[0], loads[1], loads[4]]}, 6)
    stops = run(SOLID | {"load.points": loads}, 6, straight.cells)
    assert stops.history.dissipated_energy == pytest.approx(straight.history.dissipated_energy, rel=1e-3)
    assert len(stops.history.entries) == len(straight.history.entries) + 12
    assert stops.history.entries[-1].work.sum() == pytest.approx(straight.history.work.sum(), rel=1e-3)
