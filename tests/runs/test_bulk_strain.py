"""Runs with bulk strain: against the closed form, against the mesh-free solver beyond it, and no trace without."""

import numpy as np
import pandas
import pytest
from running import ROOT, coarse_arguments
from solving import coarse_simulation, metered, simulated, solved

from simulations import fretting
from simulations.fem.body_sample import BodySampler
from simulations.loading.schedule import rocking, stretched
from simulations.runs.closed_forms import StretchedForm
from simulations.runs.comparison import compare, compare_all, relative_l2
from simulations.runs.energy import worst_defect
from simulations.runs.mesh_free import MeshFree, equal_shares, refined
from simulations.runs.reference import of_same_physics
from simulations.scene import SceneError, make_scene, parse
from simulations.scene.effects import Effects

UNCOUPLED = (ROOT / "scenes" / "uncoupled.toml").read_text(encoding="utf-8")
GHENT = (ROOT / "scenes" / "ghent.toml").read_text(encoding="utf-8")
STRAIN = 4e-4  # two thirds of the largest of the closed form at k = 0, 0.9 μP


def test_no_trace_without_it():
    """No field, no constant and no key."""
    without, with_strain = coarse_simulation(), coarse_simulation(load__bulk_strain=1e-4)
    forms = [simulation.stepping.frictional.terms.forces_form.ufcx_form for simulation in (without, with_strain)]
    assert forms[0].num_constants == forms[1].num_constants - 1
    assert without.body.strain is None and without.body.unknowns <= with_strain.body.unknowns
    assert "bulk" not in without.scene.to_toml()
    assert not any(step.load.strain for step in without.schedule)


@pytest.mark.parametrize("cycles", [0, 1])
def test_against_the_closed_form(cycles):
    """Coarse cells; energy balance with the work of the strain; the slip in the stick zone is none; stress below."""
    simulation = coarse_simulation(UNCOUPLED, solid__k=0.3, load__bulk_strain=1e-3, load__cycles=cycles)
    energies = metered(simulation)
    exact = of_same_physics(simulation)
    assert isinstance(exact, StretchedForm)
    found = compare(simulation.history, exact)
    assert found["traction_l2"] < 1e-2 and abs(found["dissipated_energy"]) < 1e-2 and abs(found["c"]) < 1e-2
    assert worst_defect(energies) < 1e-7
    last, loop = simulation.history.entries[-1], simulation.stretched
    assert np.mean(last.stick) == pytest.approx(loop.shift, abs=2e-3)
    stuck = np.abs(last.surface.x - loop.shift) < 0.7 * loop.c
    assert np.abs(last.slip[stuck]).max() < 1e-3 * np.abs(last.slip).max()
    x, y = np.meshgrid(np.linspace(-2, 2, 41), [0.1, 0.3])
    stress = BodySampler(simulation.numbering).sample().stress_at(x.ravel(), y.ravel())[:, 0].reshape(x.shape)
    expected = loop.amplitude.stress_xx(x, y)
    difference = np.abs(stress - expected).max(axis=1) / np.abs(expected).max(axis=1)
    assert np.all(difference < [5e-3, 1.5e-2])  # cells grow with the depth


@pytest.mark.parametrize(
    "changes, has_closed_form, increments",
    [
        ({}, True, 6),
        ({"load.bulk_strain": 10 * STRAIN}, False, 6),
        ({"load.bulk_phase": 0}, True, 6),
        ({"load.bulk_phase": "constant"}, False, 6),
        ({"load.bulk_phase": 90}, False, 12),
    ],
)
def test_what_a_strain_calls_for(changes, has_closed_form, increments):
    """Little of it in phase has a closed form; on an ellipse of loads there are more load steps."""
    scene = make_scene({"load.bulk_strain": STRAIN} | changes, UNCOUPLED)
    assert (Effects(scene).has_closed_form, scene.solver.increments) == (has_closed_form, increments)


def test_ghent_rig():
    """Half-width, pressure and stick zone of the aluminium rig."""
    simulation = solved(GHENT, load__cycles=0, mesh__edge_facet=0.005)
    last, a = simulation.history.entries[-1], simulation.scene.half_width
    assert a == pytest.approx(0.2067e-3, rel=3e-4)
    assert last.surface.pressure.max() * simulation.scaled.scales.stress == pytest.approx(418.1e6, rel=3e-4)
    left, right = last.stick
    assert (right - left) / 2 == pytest.approx(0.2202, abs=2e-4)
    assert (right + left) / 2 == pytest.approx(0.1993, abs=3e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    "k, turns, energy, every", [(0.0, 1e-4, 2e-5, 1e-3), (0.3, 1e-4, 2e-5, 1e-3), (-0.3, 1e-3, 1e-4, 3e-3)]
)
def test_default_mesh(k, turns, energy, every):
    """Traction at ±Q_A, energy, and traction at every state."""
    simulation = simulated({"solid.k": k, "load.bulk_strain": STRAIN}, UNCOUPLED)
    exact = of_same_physics(simulation)
    found = compare(simulation.history, exact)
    assert found["traction_l2"] < turns and abs(found["dissipated_energy"]) < energy
    assert compare_all(simulation.history, exact).worst["traction_l2"] < every


@pytest.mark.slow
def test_beyond_the_closed_form():
    """A strain a quarter of a cycle behind, coarse cells: the mesh-free solver on the ellipse agrees."""
    lagging = {"load__bulk_strain": 1e-3, "load__bulk_phase": 90, "solver__increments": 6}
    simulation = solved(UNCOUPLED, solid__k=0.3, **lagging)
    other = of_same_physics(simulation)
    assert isinstance(other, MeshFree)
    assert compare(simulation.history, other)["traction_l2"] < 2e-2


@pytest.mark.slow
def test_strain_that_lags_stops_points_just_before_a_turn():
    """The short load step there finds them: c/a is 0.44 without it, 0.68 by an incremental solver of constant elements.
    The reference shares neither load steps nor the error of the energy that they leave."""
    lagging = {"load__amplitude": 0.8, "load__bulk_strain": 3e-4, "load__bulk_phase": 60, "solid__k": 0.0}
    few = solved(UNCOUPLED, **lagging, solver__increments=6)
    many = solved(UNCOUPLED, few.cells, **lagging, solver__increments=48)
    for simulation in (few, many):
        last = simulation.history.entries[-1]
        assert last.c / last.a == pytest.approx(0.685, abs=5e-3)
    error = few.history.dissipated_energy / many.history.dissipated_energy - 1
    reference = of_same_physics(few)
    stated = few.history.dissipated_energy / reference.dissipated_energy() - 1
    assert reference.finer == 8 and 5e-3 < abs(error) < 1.2 * abs(stated)


@pytest.mark.parametrize("k, coupling", [(0.0, "false"), (-0.3, "true")])
def test_strain_that_makes_all_slip(k, coupling):
    """Refused at the first +Q_A of a rough solution."""
    with pytest.raises(SceneError, match="load.bulk_strain = 0.05 is not allowed: it makes the whole contact slip"):
        coarse_simulation(UNCOUPLED, solid__k=k, load__bulk_strain=0.05, effects__coupling=coupling)


def test_elastic_slip_tends_to_coulombs_law():
    """Proportional to its length; the strain, which moves stuck points too, is not lost in it."""
    given = {"solid__k": 0.3, "load__bulk_strain": 1e-3, "load__cycles": 0}
    plain = solved(UNCOUPLED, **given)
    stiff, differences = plain.history.entries[-1].surface, []
    for length in (0.01, 0.001):
        metres = length * plain.scaled.scales.displacement
        surface = solved(UNCOUPLED, plain.cells, **given, effects__elastic_slip=metres).history.entries[-1].surface
        differences.append(relative_l2(stiff.weight, surface.traction, stiff.traction))
    assert differences[0] < 1e-2 and differences[1] < 0.2 * differences[0]


def test_strain_behind_the_load():
    """In phase ε = ε_A Q/Q_A; 90° behind it is largest at Q = 0 on the way down; constant stays."""
    schedule = rocking(1.0, 0.6, cycles=1, quarter=2)
    in_phase, behind, constant = (
        [step.load.strain for step in stretched(schedule, 2.0, phase)] for phase in (0.0, 90, "constant")
    )
    assert in_phase == pytest.approx([2 * step.Q / 0.6 for step in schedule])
    down = np.array([step.branch == "unloading" for step in schedule])
    assert np.array(behind)[down] == pytest.approx([3**0.5, 2, 3**0.5, 0], abs=1e-12)
    assert np.array(behind)[~down] == pytest.approx([0, 0, -(3**0.5), -2, -(3**0.5), 0], abs=1e-12)
    assert constant == pytest.approx([1, 2] + 8 * [2])


def test_steps_of_a_lagging_strain_go_round_an_ellipse():
    """Steps equal in the angle, but for a short one before each turn; those of the reference lie between them on the
    ellipse, but the short one stays one; B and D at half of Q_A."""
    schedule = stretched(rocking(1.0, 0.6, cycles=1, quarter=3, harmonic=True), 2.0, 60)
    loads, places = refined(schedule, equal_shares(schedule, friction_first=False, finer=4))
    assert np.array(loads)[places] == pytest.approx(np.array([step.load for step in schedule]))
    _, Q, strain = np.array(loads[places[2] :]).T
    half = [*np.linspace(0, 150, 21), *np.linspace(150, 179.625, 5)[1:], 180]
    angle = np.deg2rad([*half, *(180 + place for place in half[1:])])
    assert Q == pytest.approx(0.6 * np.cos(angle), abs=1e-12)
    assert strain == pytest.approx(2 * np.cos(angle - np.pi / 3), abs=1e-12)
    assert {step.state: step.Q for step in schedule[3:10] if step.state} == pytest.approx(
        {"B": 0.3, "C": 0.0, "D": -0.3, "E": -0.6}, abs=1e-12
    )


@pytest.mark.parametrize("quarter", [119, 150, 239, 240, 300])
def test_more_steps_round_an_ellipse_meet_the_same_loads(quarter):
    """So states of both are compared; steps as short as the one before a turn are divided in the reference."""
    few, many = (stretched(rocking(1.0, 0.6, 1, n, harmonic=True), 2.0, 60) for n in (quarter, 2 * quarter))
    loads = np.array([step.load for step in many])
    assert all(np.abs(loads - step.load).max(axis=1).min() < 1e-12 for step in few)
    shares = equal_shares(few, friction_first=False, finer=4)
    assert [step.state for step, parts in zip(few[1:], shares, strict=True) if len(parts) == 1] == ["E", "A"]


def test_stress_instead_of_strain():
    """ε = σ (1 - ν²)/E at the depth that is named."""
    scene = parse(UNCOUPLED, ("load.bulk_stress=1e8", "load.bulk_depth=1e-3"))
    E = scene.half_plane.modulus(1e-3)
    assert scene.bulk_strain == pytest.approx(1e8 * (1 - 0.3**2) / E)
    plain = make_scene({"solid.k": 0.3, "effects.grading": False, "load.bulk_stress": 1e8}, UNCOUPLED)
    assert plain.bulk_strain == pytest.approx(1e8 * (1 - 0.3**2) / plain.solid.E0)


LINEAR = {"modulus": "linear", "E0": 100e9, "E_substrate": 200e9, "thickness": 1e-3, "nu": 0.3}
POINTS = [[0.0, 200e9], [1e-3, 200e9], [2e-3, 100e9], [3e-3, 200e9]]
TABLE = {"modulus": "tabulated", "points": POINTS, "nu": 0.3, "E0": None}


@pytest.mark.parametrize("solid", [LINEAR, LINEAR | {"E0": 200e9, "E_substrate": 100e9, "thickness": 1e-6}, TABLE])
def test_stress_in_a_coating_needs_its_depth(solid):
    changes = {"solid": solid | {"k": None, "y0_over_a0": None}, "load.bulk_stress": 1e8}
    with pytest.raises(SceneError, match="load.bulk_depth is missing: the depth .*, a number > 0"):
        make_scene(changes)
    E = solid.get("E_substrate", 200e9)
    assert make_scene(changes | {"load.bulk_depth": 1e-3}).bulk_strain == pytest.approx(1e8 * 0.91 / E)


def test_stress_far_from_the_contact_in_the_files(tmp_path):
    """E(y) ε/(1 - ν²) at +Q_A, its opposite at -Q_A: P adds the same to both, Q what is odd in x. So does u_y."""
    scene = tmp_path / "scene.toml"
    scene.write_text(UNCOUPLED, encoding="utf-8")
    strain, solved_for = 1e-3, parse(UNCOUPLED, ("solid.k=0.3",))
    a = solved_for.half_width
    lines = [[x * a, 2 * a, x * a, 15 * a, 4] for x in (-15, 15)]
    changes = {"solid__k": 0.3, "load__bulk_strain": strain, "output__lines": lines, "reference__kind": '"none"'}
    fretting.main([str(scene), *coarse_arguments(tmp_path / "run", **changes), "--quiet"])
    table = pandas.read_csv(tmp_path / "run" / "lines.csv")
    last = table["increment"] == table["increment"].max()
    names = ["stress_xx[Pa]", "displacement_y[m]"]
    found = {state: at[names].to_numpy() for state, at in table.groupby("state")}
    depth = table["depth[m]"][last].to_numpy()[:4]
    at_A, at_E = (found[state][-8:].reshape(2, 4, 2).mean(axis=0) for state in ("A", "E"))
    stress, upwards = (at_A - at_E).T / 2
    expected = solved_for.half_plane.modulus(depth) * strain / (1 - 0.3**2)
    assert stress == pytest.approx(expected, rel=2e-3)
    assert upwards == pytest.approx(0.3 / (1 - 0.3) * strain * depth, rel=2e-3)
