"""Paths on which P grows while Q acts, and the work of friction on loops: no answer depends on the load steps."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI
from running import COARSE
from solving import limit_stepping, of_history

from analytic import PressingWithFriction
from simulations.api import make_scene
from simulations.loading import anchors, stopped_points
from simulations.loading.stepping import LoadStepping
from simulations.runs import checks, comparison
from simulations.runs.closed_forms import Springs
from simulations.runs.comparison import compare, compare_all, compare_state, relative_l2
from simulations.runs.history import all_states
from simulations.runs.mesh_free import MeshFree
from simulations.runs.reference import describe, of_same_physics
from simulations.runs.simulation import Simulation

MESH = COARSE | {
    "mesh.facet": 0.05,
    "mesh.edge_facet": 4e-3,
    "mesh.growth": 1.5,
    "mesh.first_layer": 4e-3,
    "mesh.layer_growth": 1.5,
}
HOLL = {"solid.E0": 210e9, "solid.k": 0.3, "solid.nu": "holl", "solid.y0_over_a0": 10.0, "indenter.R": 0.1}
UNCOUPLED = HOLL | {"solid.E0": 1e9, "solid.nu": 0.3, "solid.y0_over_a0": 3.0, "effects.coupling": False}
STICKS = {
    "holl": HOLL | {"load.mu": 0.3, "load.points": [[2.5e5, 0.0], [1e6, 1.2e5]]},
    "uncoupled": UNCOUPLED | {"load.mu": 0.4, "load.points": [[2500.0, 0.0], [1e4, 1500.0]]},
    "steep": UNCOUPLED | {"solid.k": -0.4, "load.mu": 0.4, "load.points": [[2500.0, 0.0], [1e4, 1500.0]]},
}
THERE_AND_BACK = UNCOUPLED | {
    "load.mu": 0.3,
    "load.points": [[1e4, 0.0], [1e4, 2e3], [6e3, 1e3], [1e4, -1e3]],
}
LOOP = HOLL | {"solid.modulus": "homogeneous", "solid.nu": 0.3, "load.P": 1e6, "load.mu": 0.6, "load.amplitude": 0.6}
del LOOP["solid.k"], LOOP["solid.y0_over_a0"]


def run(scene, steps, cells=None, **changes) -> Simulation:
    keys = scene | MESH | {"solver.increments": steps} | changes
    return Simulation(MPI.COMM_SELF, make_scene(keys, base=None), cells).run_to_end()


def traction_error(simulation) -> float:
    """Of the last state against the springs, relative L2."""
    last = simulation.history.entries[-1]
    exact = Springs(simulation.contact, simulation.mu, simulation.schedule).traction(last, last.surface.x)
    return relative_l2(last.surface.weight, last.surface.traction, exact)


def failing(simulation) -> list[str]:
    found = checks.check(simulation.history, simulation.scaled.indenter.height)
    return [name for name, value in found.items() if not value.holds]


@pytest.mark.parametrize("steps", [1, 3, 6, 24])
@pytest.mark.parametrize("name, error", [("holl", 2.5e-3), ("uncoupled", 2e-3), ("steep", 2e-3)])
def test_what_sticks_all_the_way_is_exact_with_any_number_of_steps(name, error, steps):
    """q = dQ/dP (p - p of the first point) to the error of the mesh, which has k < 0 at its steep edges."""
    simulation = run(STICKS[name], steps)
    last = simulation.history.entries[-1]
    assert traction_error(simulation) < error
    assert last.c == pytest.approx(last.a, rel=4e-3 if name == "steep" else 1e-3)
    assert all(entry.c <= entry.a for entry in simulation.history.entries)
    assert last.dissipated < 1e-6
    assert checks.traction_zigzags(last.surface) < 3e-3  # beside the edges of earlier steps, for k < 0
    assert not failing(simulation)


@pytest.mark.parametrize("slope", [-0.93, 0.0, 0.93])
@pytest.mark.parametrize("steps", [1, 2, 6])
def test_little_friction_without_coupling_leaves_no_zigzags(slope, steps):
    """In one system p would move nodes beside the edge of contact, by the mesh's own coupling: q is 6 to 26 % off."""
    points = np.array([[842000.0, 0.0], [746649.0, -19492.7], [933519.0, -19492.7]])
    points[2, 1] += slope * 0.05 * (points[2, 0] - points[1, 0])
    solid = {"solid.modulus": "homogeneous", "solid.E0": 210e9, "solid.nu": 0.5, "indenter.R": 0.1}
    load = {"load.mu": 0.05, "load.points": points.tolist(), "mesh.edge_facet": 0.02}
    simulation = run(solid, steps, **load)
    assert traction_error(simulation) < 2e-2
    assert not failing(simulation)


def test_anchored_where_the_step_began_points_are_too_early(monkeypatch):
    limit_stepping(monkeypatch, anchor_passes=0)
    simulation = run(STICKS["holl"], 3)
    assert traction_error(simulation) > 0.1
    assert max(entry.unsettled for entry in simulation.history.entries) > 0.1  # and they say so


@pytest.mark.parametrize("steps", [3, 12])
def test_a_path_with_slip_and_stick_by_turns(steps):
    simulation = run(THERE_AND_BACK, steps)
    assert traction_error(simulation) < 5e-3
    springs = Springs(simulation.contact, simulation.mu, simulation.schedule)
    assert simulation.history.entries[-1].dissipated == pytest.approx(springs.dissipated_energy(), rel=2e-3)
    assert not failing(simulation)


def test_frictional_work_of_a_coupled_loop_does_not_depend_on_the_steps():
    """The states of such a loop do not either: what differs is the work rule."""
    simulation = run(LOOP, 6)  # where its edges stop the mesh is finer
    few, many = simulation.history, run(LOOP, 24, simulation.cells).history
    assert few.dissipated_energy == pytest.approx(many.dissipated_energy, rel=2e-4)
    assert few.entries[-1].surface.traction == pytest.approx(many.entries[-1].surface.traction, abs=1e-8)


def pressed_in_two_steps(k, nu, mu):
    """A run, its state after pressing, the exact one, and relative errors of p and q."""
    solid = {"solid.modulus": "power law", "solid.k": k, "solid.nu": nu, "solid.y0_over_a0": 10.0}
    load = {"load.mu": mu, "load.cycles": 0, "effects.friction_in_normal_stage": True, "solver.normal_increments": 2}
    simulation = run(LOOP | solid | load, 1)
    last = [entry for entry in simulation.history.entries if entry.step.branch == "normal"][-1]
    pressed = last.surface
    exact = PressingWithFriction(simulation.scaled.solid, simulation.scaled.indenter.analytic(), mu, 1.0)
    pairs = (pressed.pressure, exact.pressure), (pressed.traction, exact.traction)
    errors = [relative_l2(pressed.weight, values, field(pressed.x)) for values, field in pairs]
    return simulation, last, exact, errors


@pytest.mark.parametrize("k, nu, mu", [(0.0, 0.2, 0.25), (0.0, 0.3, 1.0), (0.3, 0.3, 0.3)])
def test_pressing_with_friction_is_exact_with_two_steps(k, nu, mu):
    """Of the self-similar contact, whose points in stick are anchored where it lets them stick."""
    simulation, last, exact, (of_p, of_q) = pressed_in_two_steps(k, nu, mu)
    assert of_p < 1e-3 and of_q < 4e-3
    # slip zones of 0.002 a and 0.02 a dissipate next to nothing
    assert last.dissipated == pytest.approx(exact.dissipated_energy, rel=5e-4, abs=1e-6)
    assert not failing(simulation)


STRONG = LOOP | {"solid.modulus": "power law", "solid.k": 0.534, "solid.nu": -0.19, "solid.y0_over_a0": 10.0}
STRONG |= {"load.mu": 2.1, "load.amplitude": 0.765, "load.cycles": 0}


def apart(found: Simulation, expected: Simulation, name: str) -> float:
    """Difference of the last states, relative L2."""
    a, b = (simulation.history.entries[-1].surface for simulation in (found, expected))
    return relative_l2(b.weight, getattr(a, name), getattr(b, name))


def test_two_steps_of_strong_coupling_do_as_eight():
    """The advancing edge sticks: r of the points that it passes turns with their distance from where it was."""
    facet = {"mesh.edge_facet": 0.02}
    many = run(STRONG, 8, **facet)
    few = run(STRONG, 2, many.cells, **facet)
    alike = Simulation(MPI.COMM_SELF, few.scene, many.cells)  # one r for all
    alike.stepping = LoadStepping(alike.stepping.normal, alike.stepping.frictional, alike._system)
    alike.run_to_end()
    for name in ("pressure", "traction"):
        assert apart(few, many, name) < 8e-3
        assert apart(alike, many, name) > 3e-2


@pytest.mark.slow
def test_the_mesh_free_solver_states_its_error_where_an_edge_sticks():
    """It anchors points where the step began; the truth is that of many load steps."""
    few = run(STRONG, 2, **{"mesh.edge_facet": 0.02})
    reference, last = MeshFree(few, estimated=True), few.history.entries[-1]
    error, own = compare_state(last, reference), compare_all(few.history, reference).own
    many = MeshFree(few, nodes=(300,), finer=8)
    x, w = last.surface.x, last.surface.weight
    true = relative_l2(w, reference.traction(last, x), many.traction(last, x))
    assert 0.03 < true < 2 * own["traction_l2"]
    assert abs(error["traction_l2"]) < 2 * own["traction_l2"]
    assert relative_l2(w, last.surface.traction, many.traction(last, x)) < 0.03
    # it could not judge a run, and what does takes more load steps
    assert any(own.get(name, 0.0) > limit for name, limit in checks.ERRORS.items())
    finer = of_same_physics(few)
    assert isinstance(finer, MeshFree) and finer.finer > reference.finer
    assert compare_all(few.history, finer).own["traction_l2"] < own["traction_l2"] / 2
    assert f"{finer.finer} load steps for ten times the distance" in describe(finer, few)


@pytest.mark.slow
def test_pressing_with_friction_where_points_in_stick_are_not_known():
    """k < 0, so that the load steps find them; half of the error that one r for all has with two steps."""
    *_, (of_p, of_q) = pressed_in_two_steps(-0.3, 0.3, 1.0)
    assert of_p < 1e-2 and of_q < 7e-2


@pytest.mark.slow
def test_a_circle_pressed_with_friction_in_one_step():
    """It is nearly a parabola, and so is its work. The reference has steps of its own: it sees what one step misses."""
    circle = LOOP | {"indenter.profile": "circle", "solid.nu": 0.2, "load.mu": 0.25, "load.cycles": 0}
    circle["effects.friction_in_normal_stage"] = True
    few, many = (run(circle | {"solver.normal_increments": steps}, 1) for steps in (1, 12))
    pressed = few.history.entries[0], many.history.entries[11]
    assert pressed[0].dissipated == pytest.approx(pressed[1].dissipated, rel=0.05)
    reference, finer = (MeshFree(few, nodes=(120,), finer=finer) for finer in (2, 8))
    assert apart_in_slip(few, reference, finer) < 0.1 * apart_in_slip(few, of_history(few.history), finer)
    assert pressed[0] in all_states(few.history)


def apart_in_slip(simulation, other, reference) -> float:
    return comparison.apart(simulation.history.entries[-1], other, reference)["slip_l2"]


def test_pressed_with_friction_and_relieved_at_no_tangential_load():
    """Tractions, stick and energy are compared though Q stays 0; energy is known exactly only while P grows."""
    relieved = LOOP | {"solid.nu": 0.0, "load.points": [[1e6, 0.0], [3e5, 0.0]]}
    for key in ("load.P", "load.amplitude"):
        del relieved[key]
    simulation = run(relieved, 4, **{"effects.friction_in_normal_stage": True, "mesh.edge_facet": 0.01})
    reference = MeshFree(simulation, nodes=(120,), finer=4)
    pressed = replace(simulation.pressing_with_friction, P=1.0).dissipated_energy
    assert reference.dissipated_energy() > 1.1 * pressed
    errors = compare(simulation.history, reference)
    assert errors["traction_l2"] < 0.05 and abs(errors["c"]) < 0.05 and abs(errors["dissipated_energy"]) < 0.03
    assert [entry.step.P for entry in all_states(simulation.history)] == pytest.approx([1, 0.825, 0.65, 0.475, 0.3])


def test_where_friction_from_first_contact_does_nothing_no_traction_is_compared():
    """At the Holl ratio without Q: errors of a traction that is 0 would be nan, and an accuracy never reached."""
    pressed = HOLL | {"load.mu": 0.3, "load.points": [[1e6, 0.0], [3e5, 0.0]]}
    simulation = run(pressed, 2, **{"effects.friction_in_normal_stage": True, "mesh.edge_facet": 0.01})
    errors = compare(simulation.history, of_same_physics(simulation))
    assert set(errors) == {"pressure_l2", "a"} and np.isfinite([*errors.values()]).all()


FEW = {
    "another facet": (-0.2, -0.2, 0.55, 0.2, 2, 0.0034),
    "KEEPS": (-0.2, -0.2, 0.55, 0.15, 3, 0.003),
    "points that stop change": (-0.3, -0.2, 0.55, 0.2, 3, 0.0034),
    "CUT": (-0.4, -0.2, 0.4, 0.2, 2, 0.003),
    "edge within its facet": (-0.3, 0.0, 0.4, 0.15, 10, 0.001),
    "narrow band of stick": (-0.058, -0.231, 0.0876, 0.295, 3, 0.001),
}


def zigzags_with_few_steps(k, nu, mu, amplitude, steps, facet) -> bool:
    """Whether the traction of a coupled loop does, and no other check fails."""
    load = {"load.mu": mu, "load.amplitude": amplitude, "solver.increments": steps, "mesh.edge_facet": facet}
    solid = {"solid.modulus": "power law", "solid.k": k, "solid.nu": nu, "solid.y0_over_a0": 10.0}
    fails = failing(Simulation(MPI.COMM_SELF, make_scene(LOOP | solid | load, base=None)).run_to_end())
    assert fails in ([], ["traction zigzags"])
    return bool(fails)


@pytest.mark.slow
@pytest.mark.parametrize("loop", FEW.values())
def test_tractions_do_not_zigzag_where_the_edge_of_contact_has_been(loop, whole_steps):
    """Points at its old place slide for a moment, those of a curve may stick up to it, a band of stick may pass."""
    assert not zigzags_with_few_steps(*loop)


@pytest.mark.slow
@pytest.mark.parametrize(("room", "name", "value"), [(anchors, "KEEPS", 10**9), (stopped_points, "CUT", 0)])
def test_without_these_they_do(room, name, value, whole_steps, monkeypatch):
    """Which points stop changes from solve to solve; the facet that the old edge had cut has no exact displacements."""
    monkeypatch.setattr(room, name, value)
    assert zigzags_with_few_steps(*FEW[name])


def test_stick_half_width_where_points_slide_against_the_change_of_q():
    """As P falls points slide along with q while Q falls as well."""
    points = [[1e4, 0.0], [1e4, 2e3], [6e3, 1e3]]
    simulation = run(UNCOUPLED | {"load.mu": 0.3, "load.points": points}, 6)
    springs = Springs(simulation.contact, simulation.mu, simulation.schedule)
    for entry in simulation.history.entries[-3:]:
        assert entry.c < 0.95 * entry.a
        assert entry.c == pytest.approx(springs.stick_half_width(entry), rel=0.01)


def test_a_dwell_and_a_return_pass_the_check_of_slip():
    """Nothing moves at a dwell: what moves there is round-off, and so is the work that it does."""
    points = [[1e6, 0.0], [1e6, 2e5], [1e6, 2e5 * (1 - 1e-13)], [1e6, 1e5], [1e6, 2e5], [1e6, 2e5]]
    simulation = run(HOLL | {"load.mu": 0.3, "load.points": points}, 1)
    assert checks.check(simulation.history, simulation.scaled.indenter.height)["slip against q"].value < 1e-6


@pytest.mark.parametrize("there", [1e3, 1e3 * (1 - 1e-13)], ids=["exact", "to round-off"])
@pytest.mark.parametrize("scene", [HOLL, UNCOUPLED], ids=["holl", "uncoupled"])
def test_a_dwell_is_no_turn_of_the_load(scene, there):
    """The next step starts on the line through the states before it, with the edges that these lead to."""
    straight, dwelling = (
        run(scene | {"load.mu": 0.3, "load.points": [[1e4, 0.0], [1e4, 1e3], *dwell, [1e4, 2e3]]}, 2).history.entries
        for dwell in ([], [[1e4, there]])
    )
    assert [entry.iterations for entry in dwelling[-2:]] == [entry.iterations for entry in straight[-2:]]
    expected = straight[-1].surface.traction
    assert dwelling[-1].surface.traction == pytest.approx(expected, abs=1e-8 * expected.max())


@pytest.mark.parametrize("friction_first", [False, True])
def test_a_dwell_changes_neither_work_nor_edges(friction_first):
    """Nor what is known of pressing with friction: the steps after it press on."""
    points = [[5e3, 0.0], [8e3, 0.0], [1e4, 1e3], [8e3, 1.5e3]]
    scene = HOLL | {"solid.nu": 0.2, "load.mu": 0.3, "effects.friction_in_normal_stage": friction_first}
    steps = {"solver.normal_increments": 2}
    straight = run(scene | {"load.points": points}, 2, **steps)
    dwelling = run(scene | {"load.points": np.repeat(points, 2, axis=0).tolist()}, 2, straight.cells, **steps)
    for entry in straight.history.entries:
        same = [other for other in dwelling.history.entries if np.allclose(other.step.load, entry.step.load)]
        assert len(same) in (1, 3)
        for other in same:
            assert other.dissipated == pytest.approx(entry.dissipated, rel=1e-8, abs=1e-15)
            assert (*other.contact, *other.stick) == pytest.approx((*entry.contact, *entry.stick), abs=1e-8)


@pytest.mark.parametrize("scene", [HOLL, HOLL | {"solid.nu": 0.2}, UNCOUPLED], ids=["holl", "coupled", "uncoupled"])
def test_a_load_to_the_left_gives_the_mirror_image(scene):
    """To the tolerance of the forces: anchors of points that stop take the same neighbours on both sides."""
    points = np.array([[1e4, 0.0], [1e4, 1e3], [3.5e3, 1e3], [1e4, 1e3]])
    right, left = (
        run(scene | {"load.mu": 0.3, "load.points": (points * [1, sign]).tolist()}, 2).history.entries[-1].surface
        for sign in (1, -1)
    )
    for name, sign in (("pressure", 1), ("traction", -1), ("relative_displacement", -1)):
        expected = getattr(right, name)
        assert sign * getattr(left, name)[::-1] == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


def test_a_look_at_the_clearance_moves_nothing():
    """Nor a last digit, which the tractions would show: where points enter, solves start from the state itself."""
    points = [[1e4, 0.0], [1e4, 1e3], [3.5e3, 1e3], [1e4, 1e3]]
    scene = make_scene(UNCOUPLED | MESH | {"load.mu": 0.3, "load.points": points, "solver.increments": 2}, base=None)
    simulation = Simulation(MPI.COMM_SELF, scene)
    for entry in simulation.run():
        before = simulation.body.state.x.array.copy()
        if entry.step.branch != "normal":
            assert np.any(simulation.stepping._clearance() > 0)
        assert np.array_equal(simulation.body.state.x.array, before), entry.number
