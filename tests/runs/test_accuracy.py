"""Accuracy by one number: the settings, what is refused, and that it holds for scenes that were not used to
calibrate.
"""

import json

import pytest
from mpi4py import MPI
from running import run_command
from solving import deviations, simulated

from simulations.runs import estimate
from simulations.runs.comparison import compare_all
from simulations.runs.reference import of_same_physics
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, SceneError, accuracy, make_scene, parse
from simulations.studies.costs.cases import COUPLED, cases
from simulations.studies.costs.model import COARSE


def largest_of_all_states(simulation) -> float:
    """What ``--accuracy`` promises: fields of every state of the cycle; a, c and energy at its end."""
    exact = of_same_physics(simulation)
    last, worst, _ = compare_all(simulation.history, exact)
    return max(map(abs, (*last.values(), *worst.values())))


def elsewhere(wanted, k, nu, mu, amplitude, coupling=False) -> dict:
    keys = {"solid.k": k, "solid.nu": nu, "effects.coupling": coupling, "load.mu": mu, "load.amplitude": amplitude}
    return keys | {"solver.accuracy": wanted}


@pytest.mark.parametrize(
    "coupling, wanted, k, nu, mu, amplitude",
    [
        (False, 1e-2, 0.2, 0.25, 0.5, 0.5),
        (False, 2e-3, 0.2, 0.25, 0.5, 0.5),
        (False, 2e-3, 0.5, 0.2, 0.2, 0.7),
        (False, 2e-3, 0.8, 0.3, 0.6, 0.45),
        (False, 1e-2, -0.4, 0.3, 0.4, 0.6),
        (False, 1e-2, -0.1, 0.3, 0.4, 0.6),
        (False, 1e-2, 0.4, 0.3, 0.5, 0.2),  # a small tangential load
        (True, 3e-3, 0.4, 0.2, 0.4, 0.7),
        (True, 1e-2, 0.15, 0.1, 0.5, 0.5),
        (True, 1e-2, -0.2, 0.25, 0.4, 0.6),
    ],
)
def test_holds_for_scenes_that_were_not_used_to_calibrate(coupling, wanted, k, nu, mu, amplitude):
    simulation = simulated(elsewhere(wanted, k, nu, mu, amplitude, coupling))
    assert largest_of_all_states(simulation) <= wanted


def test_holds_in_every_state_of_a_path_without_friction():
    """Where a single load is enough to choose by, the mesh of this path has 2.4e-3 after relief."""
    keys = {"solid.k": -0.3, "solid.nu": 0.3, "load.points": [[1e4, 0], [5e3, 0], [1.5e4, 0]], "solver.accuracy": 1e-3}
    simulation = simulated({"solid.E0": 1e9, "solid.y0": 0.01, "indenter.R": 0.1} | keys, base=None)
    assert largest_of_all_states(simulation) <= 1e-3


def test_more_is_expected_where_the_slip_zone_has_few_facets():
    many, few = (accuracy.beyond_measured(0.2, 0.4, facet) for facet in (1e-3, 0.02))
    assert 1.0 < many < few == pytest.approx(2.5**3)


def test_steep_ends_are_cut_where_the_quadrature_misses_nothing():
    """For k < 0 the place of an edge in its facet is worth more than the size of that: the best against the middle."""
    keys = accuracy.family(2.0, -0.5) | {"solid.k": -0.5, "solid.nu": 0.3, "effects.coupling": False}
    placed = deviations(simulated(keys))
    quarter = deviations(simulated(keys | {"mesh.edge_at": 0.25}))
    assert abs(placed["pressure_l2"]) < 2e-4 < 3e-4 < abs(quarter["pressure_l2"])
    assert abs(placed["traction_l2"]) < 0.3 * abs(quarter["traction_l2"])


@pytest.mark.slow
def test_five_digits_where_the_load_turns():
    errors = deviations(simulated(accuracy.family(0.7, 0.3)))
    assert max(map(abs, errors.values())) <= 1e-5, errors


def test_without_friction_the_mesh_is_that_of_the_pressure_alone():
    coarse, fine = accuracy.choose(1e-3, 0.3, None), accuracy.choose(1e-3, 0.3)
    assert coarse.fineness > fine.fineness
    with pytest.raises(SceneError, match="the best measured"):
        accuracy.choose(1e-5, 0.3)
    assert accuracy.choose(1e-5, 0.3, None).error <= 1e-5


def test_finer_is_asked_for_where_more_is_wanted():
    for k in (-0.3, 0.0, 0.15, 0.3, 0.8):
        found = [accuracy.choose(wanted, k) for wanted in (1e-2, 3e-3)]
        assert found[0].fineness >= found[1].fineness
        errors = [choice.error for choice in accuracy.expected(k)]
        assert errors == sorted(errors), "the error expected falls with the fineness"


def test_just_below_k_0_errors_are_those_of_the_meshes_for_k_below_0():
    """Lines of k = 0 are of other meshes."""
    for coupled in (False, True):
        nearest = max(line.k for line in accuracy.table() if line.coupled == coupled and line.k < 0)
        below, at = (accuracy.expected(k, 0.9, coupled) for k in (nearest / 2, nearest))
        assert [choice.error for choice in below] == [choice.error for choice in at]


def test_what_cannot_be_reached_is_refused_with_the_best_that_can():
    with pytest.raises(SceneError, match="the best measured for k = 0.3 is ") as refused:
        parse(DEFAULT_SCENE, ("solver.accuracy=1e-12",))
    best = str(refused.value).partition(" is not allowed: the best measured for k = 0.3 is ")[2].split()[0]
    parse(DEFAULT_SCENE, (f"solver.accuracy={best}",))
    assert float(best) == pytest.approx(min(choice.error for choice in accuracy.expected(0.3)), rel=0.1)
    with pytest.raises(SceneError, match="the best measured for k = -0.5 is 0.5 or more"):
        accuracy.choose(0.4, -0.5, 1 - 1e-6)
    with pytest.raises(SceneError, match="lies outside"):
        make_scene(elsewhere(1e-3, -0.8, 0.3, 0.3, 0.9))


def test_cell_sizes_are_not_given_twice():
    with pytest.raises(SceneError, match="not allowed beside solver.accuracy"):
        parse(DEFAULT_SCENE, ("solver.accuracy=1e-3", "mesh.facet=0.123"))
    scene = parse(DEFAULT_SCENE, ("solver.accuracy=1e-3",))
    assert parse(scene.to_toml()) == scene


def test_without_grading_the_mesh_is_that_of_a_homogeneous_body():
    wanted = {"solver.accuracy": 3e-3, "solid.nu": 0.3}
    without, homogeneous = (make_scene(wanted | one) for one in ({"effects.grading": False}, {"solid.k": 0.0}))
    assert without.mesh == homogeneous.mesh != make_scene(wanted).mesh


def test_a_coating_is_coupled_at_the_holl_ratio_of_its_k_too():
    coupled, uncoupled = (accuracy.choose(3e-3, 0.3, 0.9, which).mesh["mesh.facet"] for which in (True, False))
    power_law = make_scene({"solid.nu": 1 / 2.3, "solver.accuracy": 3e-3})
    keys = {"solid.nu": 1 / 2.3, "solid.modulus": "power-law coating", "solid.thickness_over_a0": 5}
    coating = make_scene(keys | {"solver.accuracy": 3e-3})
    assert coating.mesh.facet == coupled != uncoupled == power_law.mesh.facet
    said = estimate.expectation(coating)
    assert f"facets of {coupled:g} a" in said and "measured for simpler scenes" in said


def test_the_table_covers_the_study():
    """Every line is one of the study's, so that the table can be made again."""
    studied = {(c.problem in COUPLED, c.k, float(c.level)) for c in cases() if c.study == "fineness"}
    assert {(line.coupled, line.k, line.fineness) for line in accuracy.table()} <= studied
    assert {(coupled, k) for coupled, k, _ in studied} == {(line.coupled, line.k) for line in accuracy.table()}


def test_nothing_of_the_study_is_refused(monkeypatch):
    """Neither the meshes that were measured, which --accuracy takes, nor the coarse ones that compile their forms."""

    class Accepted(Exception):
        """The mesh would be made now."""

    def accept(*_):
        raise Accepted

    monkeypatch.setattr("simulations.runs.simulation.create_mesh", accept)
    meshes = [(case.text, case.sets | more) for case in cases(with_getfem=False) for more in ({}, COARSE)]
    for text, sets in {repr(mesh): mesh for mesh in meshes}.values():
        with pytest.raises(Accepted):
            Simulation(MPI.COMM_SELF, parse(text, tuple(f"{key}={value}" for key, value in sets.items())))


def test_command_says_expected_and_found(tmp_path):
    done = run_command("--accuracy", "1e-2", "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "expected error" in done.stdout and "all states, a, c and energy are within 0.01" in done.stdout
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["accuracy"]["largest_error"] == pytest.approx(max(map(abs, summary["errors"].values())))
    assert summary["accuracy"]["is_within"] and not summary["accuracy"]["is_estimate"]
    of_states = summary["errors_worst_state"].values()
    assert summary["accuracy"]["largest_error_worst_state"] == pytest.approx(max(of_states))


def test_command_finds_the_error_of_a_coupled_loop_beside_its_reference(tmp_path):
    """The solver without load steps knows it much better than a second mesh."""
    done = run_command("--set", "solid.nu=0.3", "--accuracy", "1e-2", "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "second mesh" not in done.stdout and "within 0.01" in done.stdout
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["accuracy"]["is_within"] and not summary["accuracy"]["is_estimate"]
