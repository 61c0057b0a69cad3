"""What is said of the accuracy that was asked for: measured, or estimated by a finer mesh and more load steps."""

import json
from dataclasses import replace
from math import prod
from types import SimpleNamespace

import numpy as np
import pytest
from running import run_command
from solving import coarse_simulation, deviations, simulated

from simulations import fretting, run, sweep
from simulations.output import results
from simulations.runs import comparison, estimate, limits
from simulations.runs.checks import ChecksFailed, ChecksWarning
from simulations.runs.reference import of_same_physics
from simulations.runs.report_data import compared
from simulations.scene import SceneError, parse

PATH = (  # without coupling, from P alone on
    "solid.E0 = 1e9\nsolid.k = 0.3\nsolid.nu = 0.3\nsolid.y0_over_a0 = 3\nindenter.R = 0.1\nload.mu = 0.3\n"
    "load.points = [[1e4, 0], {}]\neffects.coupling = false\n"
)


def test_estimate_is_no_smaller_than_the_error_and_not_much_larger():
    """Where there is a closed form the estimate of two meshes can be judged."""
    fine = simulated({"solver.accuracy": 1e-3})
    errors = estimate.estimated(fine, estimate.second(fine).run_to_end())
    estimated = max(errors.last.values())
    assert errors.largest > errors.worst["pressure_l2"] >= errors.last["pressure_l2"]
    error = max(map(abs, deviations(fine).values()))
    assert error < estimated < 30 * error


def test_second_mesh_is_finer_on_a_larger_domain(monkeypatch):
    """A coarser one on a smaller domain where no finer one is allowed or measured."""
    run = simulated({"solver.accuracy": 1e-2, "load.cycles": 0})
    finer = estimate.second(run)
    assert finer.cells.facet < run.cells.facet and finer.cells.edge_facet < run.cells.edge_facet
    assert finer.cells.extent / run.cells.extent == pytest.approx(run.cells.facet / finer.cells.facet)
    monkeypatch.setattr(limits, "MOST_UNKNOWNS", 2 * prod(3 * len(nodes) for nodes in run.ordinates))
    coarser = estimate.second(run)
    assert coarser.cells.facet > run.cells.facet and coarser.cells.extent < run.cells.extent


@pytest.mark.parametrize("points", ["[1e4, 2e3], [6e3, 1e3], [1e4, -1e3]", "[2e4, 5.5e3]"])
def test_estimate_knows_what_few_load_steps_do(points):
    """One load step from point to point: both meshes have the same error of the energy, 3e-3 and 5e-2."""
    path = simulated({"solver.accuracy": 2e-3, "solver.increments": 1}, PATH.format(points))
    error = max(map(abs, deviations(path).values()))
    check, found = estimate.judged(path, None)
    assert found["is_estimate"] and error < 1.5 * check.value < 6 * error
    assert not check.holds


def test_estimate_knows_what_few_load_steps_do_to_a_strain_that_lags():
    """Four load steps a quarter leave 3 % of the energy out."""
    lag = {"load.bulk_strain": 2e-4, "load.bulk_phase": 90, "solver.accuracy": 1e-2}
    lag |= {"solid.k": 0, "solid.nu": 0.3, "effects.coupling": False}
    few, many = (simulated(lag | {"solver.increments": steps}) for steps in (4, 24))
    error = abs(few.history.dissipated_energy / many.history.dissipated_energy - 1)
    check, found = estimate.judged(few, None)
    assert 0.01 < error < 1.5 * found["errors"]["dissipated_energy"] < 6 * error
    assert not check.holds


@pytest.mark.parametrize(
    "effect", [{"solid.nu": -0.2, "load.amplitude": 0.5}, {"solid.nu": 0.1, "effects.elastic_slip": 1e-7}]
)
def test_estimate_knows_what_few_load_steps_do_to_the_energy_of_a_loop(effect):
    """One load step a quarter; what the meshes alone tell is less than half of the error."""
    loop = {"reference.kind": "none", "solver.accuracy": 1e-2} | effect
    few, many = (simulated(loop | {"solver.increments": steps}) for steps in (1, 12))
    error = abs(few.history.dissipated_energy / many.history.dissipated_energy - 1)
    _, found = estimate.judged(few, None)
    assert 1e-3 < error < 1.5 * found["errors"]["dissipated_energy"] < 6 * error


def test_estimate_knows_what_few_load_steps_do_to_points_that_come_into_contact_in_stick():
    """Just after a turn of a coupled loop; two load steps a quarter leave 1 % of q out, which no mesh tells."""
    loop = {"solid.k": 0.0, "solid.nu": 0.0, "load.mu": 0.6, "load.amplitude": 0.6, "reference.kind": "none"}
    few, many = (simulated(loop | {"solver.accuracy": 3e-2, "solver.increments": steps}) for steps in (2, 6))
    same = many.history.entries[3::3]  # both begin with the normal stage
    states = comparison.OfStates([many.history.entries[0], *same], None)
    error = comparison.compare_all(few.history, states).worst["traction_l2"]
    _, found = estimate.judged(few, None)
    assert 0.01 < error < found["largest_error_worst_state"] < 4 * error


def test_an_estimate_is_more_than_the_second_mesh_changes(monkeypatch):
    """The finer one has an error too; of either sign."""
    monkeypatch.setattr(estimate, "compare_all", lambda *_: ({"a": -0.1}, {"pressure_l2": 0.2}, {}))
    of = SimpleNamespace(history=SimpleNamespace(entries=[], dissipated_energy=None))
    errors = estimate.estimated(of, of)
    assert errors.last["a"] == pytest.approx(0.25)
    assert errors.worst["pressure_l2"] == pytest.approx(0.5) and errors.is_estimate


def test_a_reference_measures_only_what_it_is_known_well_enough_for():
    """Its own error may be three tenths of the accuracy asked for."""
    exact = SimpleNamespace(deviations={"a": 1e-4, "peak_pressure": 9.0}, worst={}, own={"a": 2e-4})
    assert estimate.measured(exact, 1e-3).last == {"a": 1e-4}
    assert estimate.measured(exact, 5e-4) is None and estimate.measured(None, 1e-3) is None


def test_normal_increments_are_not_doubled_without_friction_in_the_normal_stage():
    """They have no effect, and twice as many would be too many for a scene."""
    path = PATH.format("[1e4, 2e3], [6e3, 1e3]")
    few = coarse_simulation(path, solver__increments=1, solver__normal_increments=600)
    assert estimate.more_load_steps(few) == {"solver.increments": 4}


def test_with_friction_in_the_normal_stage_normal_increments_are_doubled_too():
    keys = {"solid.nu": 0.3, "load.mu": 0.3, "load.points": [[5e5, 0.0], [1e6, 1e5]], "reference.kind": "none"}
    keys |= {"solid.E0": 210e9, "solid.k": 0.3, "solid.y0": 0.01, "indenter.R": 0.1, "solver.accuracy": 3e-2}
    steps = {"solver.increments": 2, "solver.normal_increments": 3, "effects.friction_in_normal_stage": True}
    few = simulated(keys | steps, base=None)
    other = estimate.second(few)
    assert other.scene.solver.normal_increments == 6 and other.scene.solver.increments == 4
    assert estimate.estimated(few, other.run_to_end()).is_estimate


def test_more_load_steps_only_where_errors_depend_on_them():
    """Without coupling, at constant P, each of a loop's states is that of one load step."""
    assert not estimate.more_load_steps(coarse_simulation(effects__coupling="false"))


def test_the_largest_error_may_be_negative():
    errors = estimate.Errors({"pressure_l2": 0.1, "dissipated_energy": -0.2}, {"pressure_l2": 0.15}, False)
    assert errors.largest == errors.summary()["largest_error"] == 0.2


def test_command_estimates_where_there_is_no_reference(tmp_path):
    sets = "--set", "solid.nu=0.4", "--set", "load.cycles=0", "--set", "reference.kind=none"
    done = run_command("--accuracy", "1e-2", *sets, "--output", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "estimated, not measured" in done.stdout
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["accuracy"]["is_estimate"]
    assert np.isfinite(summary["accuracy"]["largest_error"])


def test_an_accuracy_that_is_missed_fails_the_run(tmp_path):
    """One load step from point to point: the energy is off by more, which no mesh mends. To go on says so again."""
    scene = tmp_path / "path.toml"
    scene.write_text(PATH.format("[1e4, 2e3], [6e3, 1e3], [1e4, -1e3]"))
    words = scene, "--accuracy", "2e-3", "--set", "solver.increments=1", "--quiet", "--output", tmp_path / "run"
    done = run_command(*words)
    assert done.returncode == 4 and done.stderr.startswith("checks that fail: accuracy (2.9e-03")
    assert "more solver.increments" in done.stderr
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["converged"] and not summary["checks_hold"] and not summary["accuracy"]["is_within"]
    assert summary["checks"]["accuracy"]["value"] == summary["accuracy"]["largest_error"] > 2e-3
    again = run_command("--resume", tmp_path / "run")
    assert again.returncode == 4 and again.stderr.startswith("checks that fail: accuracy (more solver.increments")
    assert "nothing is left to do" in again.stdout


def test_an_accuracy_that_is_missed_fails_in_sweeps_and_from_python_too(tmp_path, monkeypatch):
    """The picture says so too: it is drawn again, as the accuracy is judged after it."""
    said = []
    monkeypatch.setattr(results, "plot_run", lambda *drawn: said.append(drawn[-1]))
    text = PATH.format("[1e4, 2e3], [6e3, 1e3], [1e4, -1e3]")
    wanted = ("solver.accuracy=2e-3", "solver.increments=1")
    with pytest.warns(ChecksWarning, match="accuracy"):
        assert not run(parse(text, wanted)).checks["accuracy"].holds
    for folder in (None, tmp_path / "sweep"):
        (row,) = sweep(text, {"solver.gamma0": [10.0]}, sets=wanted, output=folder, folders=folder is not None)
        assert row["checks"] == "not held: accuracy"
    assert said == [[], ["accuracy"]]
    summary = json.loads((tmp_path / "sweep" / "run-0001" / "summary.json").read_text())
    assert not summary["checks_hold"] and not summary["accuracy"]["is_within"]


@pytest.mark.parametrize("reference", ["auto", "none"])
def test_an_accuracy_of_an_unknown_stick_zone_is_not_reached(reference, tmp_path):
    """c, a hundredth of a, is too narrow for the mesh that the accuracy chooses: neither measured nor estimated."""
    scene = tmp_path / "path.toml"
    scene.write_text(PATH.format("[1e4, 2.9999e3]"))
    words = "--accuracy", "3e-2", "--reference", reference, "--output", tmp_path / "run"
    done = run_command(scene, *words)
    assert done.returncode == 4 and done.stderr.startswith("checks that fail: accuracy (nan")
    assert "c not known, as of a stick zone too narrow for the mesh; " in done.stderr
    assert "largest error of the last state nan (c;" in done.stdout and "NOT within" in done.stdout
    accuracy_of_run = json.loads((tmp_path / "run" / "summary.json").read_text())["accuracy"]
    assert not accuracy_of_run["is_within"] and accuracy_of_run["largest_error"] is None
    assert accuracy_of_run["largest_error_worst_state"] < 2e-2


def test_an_accuracy_that_cannot_be_judged_fails_the_run(tmp_path, monkeypatch):
    """No second mesh is possible; the run itself is done, and to go on says so again."""

    def refuse(*_):
        raise SceneError("too coarse")

    monkeypatch.setattr(estimate, "second", refuse)
    arguments = "--set", "load.cycles=0", "--reference", "none", "--accuracy", "0.03", "--quiet"
    with pytest.raises(ChecksFailed, match="the error is not known, as the second mesh fails: too coarse"):
        fretting.main([*arguments, "--output", str(tmp_path / "run")])
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["accuracy"] == {"wanted": 0.03, "is_within": False}
    with pytest.raises(ChecksFailed, match="accuracy"):
        fretting.main(["--resume", str(tmp_path / "run")])


def test_load_steps_are_no_advice_without_friction():
    """Nothing depends on the loads before."""
    relieved = "solid.E0 = 1e9\nsolid.k = -0.3\nsolid.nu = 0.3\nsolid.y0 = 0.01\nindenter.R = 0.1\n"
    simulation = simulated({"load.points": [[1e4, 0], [5e3, 0]], "solver.accuracy": 1e-3}, relieved)
    exact = compared(simulation, of_same_physics(simulation))
    check, _ = estimate.judged(simulation, replace(exact, worst={"p": 0.1}))
    assert not check.holds and check.cause == estimate.TOO_COARSE and "increments" not in check.cause
