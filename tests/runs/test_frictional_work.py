"""The energy that friction takes on a straight way of the loads follows from the balance of energy."""

from dataclasses import replace

import numpy as np
import pytest
from running import COARSE
from solving import simulated

from simulations.fem.surface import SurfaceState
from simulations.runs.closed_forms import Springs
from simulations.runs.frictional_work import frictional_work, work_of_pressing
from simulations.runs.simulation import Simulation

SOLID = {"solid.E0": 210e9, "solid.nu": 0.3, "solid.modulus": "homogeneous", "indenter.R": 0.1, "load.mu": 0.3}
STRONG = SOLID | {"solid.modulus": "power law", "solid.k": 0.5, "solid.y0_over_a0": 10.0, "solid.nu": 0.495}
STRONG |= {"load.P": 1e6, "load.mu": 1.0, "load.amplitude": 0.95}
UNCOUPLED = {"effects.coupling": False}
LOOP = {"load.P": 1e6, "load.amplitude": 0.9}
MOVING = SOLID | {"solid.nu": 0.0, "load.P": 1e6, "load.mu": 0.6, "load.amplitude": 0.8}  # points enter and leave
FALLING = SOLID | {"load.points": [[8.9e5, 0.0], [7.1e5, 9.8e4], [2.7e5, 6.5e3], [6.1e5, 1.3e5]]}


def run(scene, steps, cells=None) -> Simulation:
    return simulated(COARSE | scene | {"solver.increments": steps}, None, cells)


def by_points(history) -> float:
    """Energy of the last cycle, or of the whole path, from each load step's two states alone."""
    entries = history.last_cycle if history.has_cycle else history.entries[1:]
    return sum(entry.surface.line_load(entry.own_work) for entry in entries)


@pytest.mark.parametrize("scene, steps, error, of_points", [(STRONG, 3, 2e-3, 3e-3), (MOVING, 4, 1e-3, 1.2e-3)])
def test_strong_coupling_with_few_load_steps(scene, steps, error, of_points):
    """Of a loop, whose states do not depend on the load steps; each point begins to slide somewhere within one.

    Where points enter contact pressure has a part in the balance of energy, here 1.3e-3 of it.
    """
    few = run(scene, steps)
    many = run(scene, 24, few.cells).history.dissipated_energy
    assert few.history.dissipated_energy == pytest.approx(many, rel=error)
    assert by_points(few.history) / many - 1 > of_points


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


MU, FAR = 0.4, ((-9.0, 9.0), (-9.0, 9.0))  # edges of contact that no point is near


def surface(pressure, share, s) -> SurfaceState:
    """Points with ``share`` of the traction that friction allows, at s (n,)."""
    n, zero = len(s), np.zeros((2, len(s)))
    pressure, u = np.broadcast_to(pressure, n), np.array([s, np.zeros(n)])
    x, weight, delta = np.linspace(0, 1, n), np.full(n, 1 / n), np.zeros(2)
    return SurfaceState(x, weight, pressure, share * MU * pressure, u, delta, zero, mu=MU)


@pytest.mark.parametrize("k", [-0.6, 0.0, 0.6])
def test_points_that_begin_to_slide_one_after_the_other(k):
    """From t0 on each goes like (t - t0)^m, m = (3-k)/2, while p grows from 1 to 3: work -∫ q ds, on 1000 points."""
    left, m = (np.arange(1000) + 0.5) / 1000, (3 - k) / 2  # of the load step when each begins
    before, after = surface(1.0, 0.0, 0.0 * left), surface(3.0, 1.0, -(left**m))
    exact = MU * (3.0 * left**m - 2.0 * left ** (m + 1) / (m + 1))
    assert frictional_work(before, after, FAR, k).sum() == pytest.approx(exact.sum(), rel=1e-5)


@pytest.mark.parametrize("leaves", [False, True])
@pytest.mark.parametrize("k", [-0.6, 0.0, 0.6])
def test_points_that_an_edge_passes_slide_for_a_part_of_the_step(k, leaves):
    """Under a pressure like the distance from the edge to the power (1+k)/2, whose mean over time is what counts."""
    distance, power = (np.arange(1000) + 0.5) / 1000, (1 + k) / 2  # of each point from where the edge ends, or began
    touching, open_points = surface(distance**power, 1.0, -0.2 + 0 * distance), surface(0.0, 0.0, 0 * distance)
    if leaves:
        touching, open_points = surface(distance**power, 1.0, 0 * distance), surface(0.0, 0.0, -0.2 + 0 * distance)
    work = frictional_work(*((touching, open_points) if leaves else (open_points, touching)), FAR, k)
    exact = 0.2 * MU * distance ** (power + 1) / (power + 1)  # each slides as long as the edge is beyond it
    assert work.sum() == pytest.approx(exact.sum(), rel=1e-4)


@pytest.mark.parametrize("k", [-0.6, 0.0, 0.6])
def test_work_of_pressing_is_that_of_all_earlier_states_similar_to_the_last(k):
    """p = 1 and u_x = -x under a parabola with a = 1: each point has x^(3+k) ∫ g ξ^-(4+k) dξ, g = mu ξ."""
    x = np.linspace(-1, 1, 4001)
    work = work_of_pressing(replace(surface(1.0, 1.0, -x), x=x), k, 2.0)
    distance = np.abs(x)
    exact = MU * (distance - distance ** (3 + k)) / (2 + k)
    assert work == pytest.approx(exact, rel=1e-3, abs=1e-3 * exact.max())


def test_a_point_that_slides_ever_faster_does_more_under_the_later_pressure():
    """s = -t² from t = 20 on, by load steps of 1, while p grows from 1 to 3.

    To a thirtieth of what a steady slip leaves out.
    """
    earlier, before, after = (surface(p, 1.0, -np.full(3, t**2)) for p, t in ((1.0, 20.0), (1.0, 21.0), (3.0, 22.0)))
    t = (np.arange(10_000) + 0.5) / 10_000
    exact = MU * np.mean((1 + 2 * t) * 2 * (21 + t))
    steady, faster = (frictional_work(before, after, FAR, 0.0, first)[0] for first in (None, earlier))
    assert faster - steady == pytest.approx(exact - steady, rel=0.03) and exact > steady
