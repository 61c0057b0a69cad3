"""The mesh of a coupled loop: a place for the edges of contact and stick after every load step."""

from itertools import islice

import numpy as np
import pytest
from mpi4py import MPI
from solving import simulated

from analytic import CoupledLoop
from analytic.coupled.state import CoupledState
from simulations.fem.edge_place import vanishing_place
from simulations.fem.mesh import columns
from simulations.fem.surface import SurfaceState, fitted_contact_edges, fitted_stick_edges
from simulations.runs import coupled_loop
from simulations.runs.checks import largest_zigzag
from simulations.runs.comparison import NoReference, compare_all
from simulations.runs.coupled_loop import grades, loop_of, states_of
from simulations.runs.expected_edges import FACETS_OF_WAY, ONE_EDGE, Stop, expected_edges, stops_at
from simulations.runs.limits import check_size
from simulations.runs.plan import Plan
from simulations.runs.simulation import Simulation
from simulations.runs.step_free import StepFree
from simulations.runs.timing import Stopwatch
from simulations.scene import DEFAULT_SCENE, make_scene, parse


def surface_of(x, p, q, mu) -> SurfaceState:
    """With pressure and traction alone."""
    none = np.zeros((2, len(x)))
    return SurfaceState(x, np.gradient(x), p, q, none, np.zeros(2), none, mu=mu)


def test_of_two_zones_of_stick_the_longest_counts_not_the_one_with_more_nodes():
    x = np.concatenate([np.linspace(-1, 0.5, 100), np.linspace(0.5, 1, 400)[1:]])
    p, mu = np.sqrt(1.0 - np.minimum(x**2, 1.0)), 0.3
    slides = (np.abs(x + 0.9) < 0.05) | (np.abs(x - 0.65) < 0.05)
    q = np.where(slides, mu * p, 0.5 * mu * p)
    surface = surface_of(x, p, q, mu)
    left, right = fitted_stick_edges(surface, 1, lambda s: (0.5, 0.5))
    assert left == pytest.approx(-0.85, abs=0.05) and right == pytest.approx(0.6, abs=0.05)


def test_a_node_that_slides_within_stick_ends_no_zone_of_it():
    x, mu = np.linspace(-1, 1, 801), 0.3
    p = np.sqrt(1.0 - np.minimum(x**2, 1.0))
    q = np.where((np.abs(x) > 0.6) | (np.abs(x - 0.1) < 1e-3), mu * p, 0.5 * mu * p)
    surface = surface_of(x, p, q, mu)
    assert fitted_stick_edges(surface, 1, lambda s: (0.5, 0.5)) == pytest.approx((-0.6, 0.6), abs=0.01)


def test_an_edge_of_stick_is_read_with_the_power_of_the_slip_beside_it_not_of_the_slip_beyond():
    """As P falls again points beside the stick slide outwards still, and those at the edges of contact inwards."""
    x, mu, powers = np.linspace(-1, 1, 801), 0.3, {-1.0: 0.3, 1.0: 0.6}
    p = np.sqrt(1.0 - np.minimum(x**2, 1.0))
    margin = np.maximum(0.4 - np.abs(x), 0.0) ** np.where(x < 0, powers[1.0], powers[-1.0])
    beside = mu * p * -np.sign(x) * (1.0 - margin)
    q = np.where(np.abs(x) < 0.7, beside, -beside)
    surface = surface_of(x, p, q, mu)
    edges = fitted_stick_edges(surface, 0, lambda s: (powers[s], powers[s]))
    assert edges == pytest.approx((-0.4, 0.4), abs=1e-4)


def plan(*settings) -> Plan:
    return Plan(parse(DEFAULT_SCENE, ("solid.nu=0.3", *settings)), Stopwatch())


@pytest.mark.parametrize("k, nu, mu", [(-0.5, 0.3, 0.6), (0.0, 0.3, 0.3), (0.3, 0.3, 0.3), (0.7, 0.0, 0.6)])
def test_rough_edges_are_those_of_the_turns(k, nu, mu):
    """The documented accuracy, beside the solver without load steps; the contact moves aside with Q."""
    made = plan(f"solid.k={k}", f"solid.nu={nu}", f"load.mu={mu}")
    found = expected_edges(made.scene, made.scaled, None, made.effects, made.schedule)
    loads = [(1.0, share * made.loop.Q_A) for share in (0.0, 1.0, -1.0, 1.0)]
    turns = loop_of(made.scaled, mu, made.effects).run(loads)[1:]
    stick = np.array([state.stick for state in turns])
    for edge in np.abs([stick[-1], stick.min(axis=0), stick.max(axis=0)]).ravel():
        assert np.abs(np.array(found.edges) - edge).min() < ONE_EDGE + 2e-3
    inner, outer = np.sort(np.abs(turns[-1].contact))
    assert found.contact_way == pytest.approx((inner, outer), abs=7e-3) and outer - inner > 0.04


def test_a_default_mesh_fits_however_far_the_contact_goes():
    """Beyond the critical coefficient of friction it moves by more than its half-width."""
    friction = "load.mu=3", "load.amplitude=0.8", "effects.coupling=true"
    made = plan("solid.k=-0.7", "solid.nu=-0.3", *friction)
    x = columns(made.grading())
    assert len(x) < 10 * FACETS_OF_WAY
    check_size(made.scene, made.grading(), len(x), 50)


def test_facets_are_small_where_an_edge_stops_and_edges_lie_where_they_cost_least():
    """Beside every edge facets are below half of ``facet``; more than half of the edges have the best place in
    theirs, the others are too close to these.
    """
    made = plan("solver.increments=3")
    grading = made.grading()
    x = columns(grading)
    states = states_of(loop_of(made.scaled, made.mu, made.effects), tuple((step.P, step.Q) for step in made.schedule))
    edges = np.abs([edge for state in states[1:] for edge in (*state.contact, *state.stick)])
    after = np.searchsorted(x, edges)
    facets = x[after] - x[after - 1]
    place = (edges - x[after - 1]) / facets
    assert len(edges) == 60 and facets.max() < grading.facet / 2
    assert np.mean(np.abs(place - grading.edge_at) < 0.1) > 0.5


@pytest.mark.slow
def test_steep_tractions_do_not_zigzag():
    """k = -0.6: the edge of pressing has a place too, without which its pressure zigzags by 15 %. p and q beside the
    solver without load steps are off by 2.1e-3 and 6e-3; on a mesh for rough edges q was off by 1.7e-2.
    """
    simulation = simulated({"solid.k": -0.6, "solid.nu": 0.3, "solver.increments": 6, "mesh.facet": 0.08})
    zigzag = max(largest_zigzag(entry.surface) for entry in simulation.history.entries)
    found = compare_all(simulation.history, StepFree(simulation)).worst
    assert zigzag < 0.03 and found["pressure_l2"] < 4e-3 and found["traction_l2"] < 1e-2


def test_neighbouring_stops_are_one_with_the_least_share():
    found = [(0.5, 0.3), (0.9, 0.2), (0.5004, 0.1), (0.5006, 0.4), (0.7, 0.0)]
    assert stops_at(found, 5e-4) == (Stop(pytest.approx(0.5002), 0.1), Stop(0.5006, 0.4), Stop(0.9, 0.2))


def test_the_mesh_takes_the_first_cycle_which_is_solved_once(monkeypatch):
    """The reference of one cycle has the same states; 100 cycles would take two minutes before the first word."""
    solve, asked = CoupledLoop.where_known, []
    monkeypatch.setattr(CoupledLoop, "where_known", lambda loop, loads: asked.append(len(loads)) or solve(loop, loads))
    for cycles, solves in (("1", 1), ("2", 2)):
        made = plan("solver.increments=2", "load.cycles=" + cycles)
        made.grading()
        states_of(loop_of(made.scaled, made.mu, made.effects), tuple((step.P, step.Q) for step in made.schedule))
        assert len(asked) == solves and asked[0] == sum(step.cycle <= 1 for step in made.schedule)
        states_of.cache_clear()
        asked.clear()


def test_no_solution_leaves_the_rough_edges(monkeypatch):
    """Where points come into contact in stick up to the turn there is none; nor on large facets, which gain nothing."""
    asked = plan("solid.nu=-0.4", "load.mu=0.7", "solid.k=-0.3", "load.amplitude=0.3")
    assert grades(asked.scene, asked.effects)
    assert coupled_loop.loop_edges(asked.scene, asked.scaled, asked.effects, asked.schedule) is None
    assert asked.grading().stops == ()
    coarse = plan("mesh.edge_facet=0.02")
    assert not grades(coarse.scene, coarse.effects)


def test_load_steps_without_a_state_leave_the_others_their_places():
    """Just after the turns points come into contact in stick: two of ten load steps have no state."""
    asked = plan("solid.k=-0.543", "solid.nu=-0.083", "load.mu=0.0994", "load.amplitude=0.661", "solver.increments=2")
    loads = tuple((step.P, step.Q) for step in asked.schedule)
    states = states_of(loop_of(asked.scaled, asked.mu, asked.effects), loads)
    known = [isinstance(state, CoupledState) for state in states]
    assert known == [True, True, True, False, True, True, True, False, True, True, True]
    cells = asked.grading()
    assert cells.edge_at > 0 and len(cells.stops) >= 12
    with pytest.raises(NoReference, match="come into contact in stick"):
        StepFree(Simulation(MPI.COMM_SELF, asked.scene))


def test_edges_are_read_with_the_powers_that_coupling_gives():
    """In both directions; with (1+k)/2, the power without coupling, they are ten times as far off."""
    keys = {"solid.k": 0, "solid.nu": 0.1, "load.mu": 0.6, "load.amplitude": 0.6, "mesh.edge_facet": 1.9e-3}
    simulation = simulated(keys | {"solver.increments": 3})
    reference, middle = StepFree(simulation), []
    for exponents in (simulation.history.exponents, lambda friction: 4 * (0.5,)):
        off = []
        for entry in simulation.history.entries[1:-1]:  # the last edge has that of the first turn beside it
            x_l, c_l, c_r, x_r = exponents(entry.step.direction * simulation.mu)
            contact = fitted_contact_edges(entry.surface, (x_l, x_r))
            stick = fitted_stick_edges(entry.surface, entry.step.direction, lambda s: (c_l, c_r))
            exact = (*reference.contact(entry), *reference.states[entry.number].stick)
            off.append(np.abs(np.subtract((*contact, *stick), exact)))
        middle.append(np.median(off))
    assert 10 * middle[0] < middle[1] and middle[0] < 2e-4


@pytest.mark.parametrize("coupling", [False, True])
def test_the_mesh_has_the_edges_at_the_points_of_a_path_however_many_load_steps_lie_between(coupling):
    """The widest among them, which is where contact is looked for."""

    def edges(steps: int) -> np.ndarray:
        scene = {
            "solid.E0": 210e9,
            "solid.nu": 0.3,
            "solid.k": 0.3,
            "solid.y0_over_a0": 10.0,
            "indenter.R": 0.1,
            "load.mu": 0.3,
            "load.points": [[1e6, 0.0], [1e6, 1e5], [5e5, 1e5], [9e5, 0.0], [0.3e6, -5e4]],
            "solver.increments": steps,
            "effects.coupling": coupling,
        }
        return np.array(Plan(make_scene(scene, base=None), Stopwatch()).grading().edges)

    few, many = edges(6), edges(24)
    assert max(few) > 0.99 and len(few) <= 40
    assert np.abs(np.subtract.outer(few, many)).min(axis=1).max() < (0.01 if coupling else 1e-9)


def test_pressed_with_friction_contact_grows_by_equal_steps_that_end_at_the_best_place_in_their_facets():
    """Where a steep pressure ends elsewhere in its facet the last pressures zigzag: at 0.4 by 31 % of the range."""
    first_contact = "effects.friction_in_normal_stage=true", "solver.normal_increments=10"
    simulation = Simulation(
        MPI.COMM_SELF,
        parse(DEFAULT_SCENE, ("solid.k=-0.65", "solid.nu=-0.3", "load.mu=0.1", "reference.kind=none", *first_contact)),
    )
    pressed = [*islice(simulation.run(), 10)]
    exact = simulation.pressing_with_friction.contact_half_width * np.arange(1, 11) / 10
    assert [entry.a for entry in pressed[1:]] == pytest.approx(exact[1:], abs=3e-3)  # half a facet
    x, at = simulation.ordinates[0], vanishing_place(2, -0.65)
    after = np.searchsorted(x, exact)
    assert (exact - x[after - 1]) / (x[after] - x[after - 1]) == pytest.approx(np.full(10, at), abs=0.05)
    assert max(largest_zigzag(entry.surface) for entry in pressed[1:]) < 0.02


@pytest.mark.parametrize("k, mu", [(0.0, 0.6), (-0.3, 0.3)])
def test_pressed_with_friction_edges_are_read_with_the_powers_of_slip_to_both_sides(k, mu):
    """Beside the exact half-width; with (1+k)/2 it was 1e-3 and 6e-4 too small."""
    scene = {"solid.k": k, "solid.nu": 0.1, "load.mu": mu, "effects.friction_in_normal_stage": True}
    scene |= {"solver.normal_increments": 3, "mesh.facet": 0.05, "mesh.edge_facet": 2e-3, "mesh.first_layer": 2e-3}
    simulation = Simulation(MPI.COMM_SELF, make_scene(scene))
    *_, pressed = islice(simulation.run(), 3)
    assert pressed.a == pytest.approx(simulation.pressing_with_friction.contact_half_width, abs=2e-4)
