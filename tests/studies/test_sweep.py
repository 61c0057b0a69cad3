"""Sweeps: the same table on any ranks and from Python, failed scenes as rows, stopped and resumed."""

import gc
import json
import signal
import time
import weakref
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from subprocess import DEVNULL

import pytest
from coarse_sweep import COARSE_SETS, VARY, arguments, rows_of
from running import run_command, start_python
from solving import coarse_simulation

from simulations import SceneError, sweep
from simulations.runs import checks, comparison, reference
from simulations.runs.reference import closed_form
from simulations.runs.report_data import find
from simulations.studies import sweeping
from simulations.studies.variation import RESULTS

MEASURED = ("seconds",)


def test_errors_of_every_state_are_checked_as_in_a_single_run(monkeypatch):
    simulation = coarse_simulation().run_to_end()
    exact = closed_form(simulation)
    last = comparison.compare(simulation.history, exact)["traction_l2"]
    largest = comparison.compare_all(simulation.history, exact).worst["traction_l2"]
    assert largest > 2 * last
    monkeypatch.setitem(checks.ERRORS, "traction_l2", (last + largest) / 2)
    row = sweeping.numbers(simulation, find(simulation))
    assert row["checks"] == "not held: error of traction"
    assert row["error_traction_l2"] == last


def run(folder, vary=VARY, *more, ranks=1):
    return run_command(*arguments(folder, vary, *more), module="simulations.sweep", ranks=ranks)


def same(mine, other):
    """Every cell but the seconds, numbers to round-off."""
    assert len(mine) == len(other)
    for one, two in zip(mine, other, strict=True):
        assert list(one) == list(two)
        for name, value in one.items():
            if name not in MEASURED:
                try:
                    assert float(value) == pytest.approx(float(two[name]), rel=1e-6, abs=1e-9), name
                except ValueError:
                    assert value == two[name], name


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Folder of six coarse scenes on one rank."""
    folder = tmp_path_factory.mktemp("sweep")
    done = run(folder)
    assert done.returncode == 0, done.stderr
    assert "6/6" in done.stdout
    return folder


def test_a_row_a_scene(table):
    rows = rows_of(table)
    assert [(row["solid.k"], row["load.mu"]) for row in rows] == [
        (k, mu) for k in ("0.0", "0.3", "0.6") for mu in ("0.2", "0.5")
    ]
    assert {row["status"] for row in rows} == {"done"} and {row["checks"] for row in rows} == {"hold"}
    assert set(RESULTS) < set(rows[0])
    for row in rows:
        assert row["reference"].startswith("closed form")
        assert abs(float(row["error_dissipated_energy"])) < 2e-3
        assert 0 < float(row["c_over_a"]) < 1 and float(row["peak_pressure[Pa]"]) > 0
    assert len({row["a[m]"] for row in rows}) == 3


def test_two_ranks_find_the_same(table, tmp_path):
    done = run(tmp_path, ranks=2)
    assert (done.returncode, done.stderr) == (0, "")
    same(rows_of(tmp_path), rows_of(table))


def test_python_finds_the_same(table, tmp_path):
    vary = {"solid.k": [0, 0.3, 0.6], "load.mu": (0.2, 0.5)}
    found = sweep(vary={key: [float(v) for v in values] for key, values in vary.items()}, sets=COARSE_SETS)
    assert found.failed == 0
    found.to_csv(tmp_path / "sweep.csv")
    same(rows_of(tmp_path), rows_of(table))


def test_a_folder_without_a_name_is_not_this_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match="output = '' is not allowed: the name of a folder"):
        sweep(vary={"solid.k": [0.3]}, sets=COARSE_SETS, output="")
    with pytest.raises(SceneError, match="folders = True is not allowed without output: the name of a folder"):
        sweep(vary={"solid.k": [0.3]}, sets=COARSE_SETS, folders=True)
    assert not list(tmp_path.iterdir())


def test_a_row_is_the_scene_alone(table):
    """What neighbours share changes nothing: the last scene's row has the numbers of a run of its own."""
    simulation = coarse_simulation(solid__k=0.6, load__mu=0.5, effects__coupling="false").run_to_end()
    row, scales = rows_of(table)[-1], simulation.scaled.scales
    energy = simulation.history.dissipated_energy * scales.energy
    assert float(row["dissipated_energy[J/m]"]) == pytest.approx(energy, rel=1e-8)
    assert float(row["c_over_a"]) == pytest.approx(simulation.history.entries[-1].c / simulation.history.entries[-1].a)


@pytest.fixture
def bodies(monkeypatch):
    """Weak references to the body of every scene that is solved."""
    found, run_one = [], sweeping.run_scene

    def watched(values):
        row = run_one(values)
        found.append(weakref.ref(sweeping._kept[0].body))
        return row

    monkeypatch.setattr(sweeping, "run_scene", watched)
    return found


def test_a_body_is_shared_where_it_is_the_same(bodies):
    """Friction and cylinder only scale an uncoupled contact."""
    sweep(vary={"load.mu": [0.2, 0.5], "indenter.R": [0.1, 0.2]}, sets=(*COARSE_SETS, "solid.k=0"))
    assert len(bodies) == 4 and len(set(map(id, bodies))) == 1  # an object has one weak reference


def test_a_failed_scene_is_a_row(tmp_path):
    """Too thin a slip zone is refused before the solve; the next call tries it again."""
    done = run(tmp_path, ("load.amplitude=0.01,0.5", "solid.k=0.3"))
    assert done.returncode == 3
    assert len(done.stderr.strip().splitlines()) == 1 and "1 of 2 scenes failed" in done.stderr
    bad, good = rows_of(tmp_path)
    assert (bad["status"], good["status"]) == ("failed", "done")
    assert "slip zone" in bad["reason"] and bad["a[m]"] == "" and good["reason"] == ""
    again = run(tmp_path, ("load.amplitude=0.01,0.5", "solid.k=0.3"), ranks=2)
    assert again.returncode == 3 and "1 of 2 runs kept from before" in again.stdout
    assert "Traceback" not in again.stderr


def test_a_table_without_results_has_their_columns(tmp_path):
    """Who reads ``checks`` need not know whether a scene has a result."""
    table = sweep(vary={"load.amplitude": [0.01]}, sets=COARSE_SETS)
    table.to_csv(tmp_path / "sweep.csv")
    (row,) = rows_of(tmp_path)
    assert row["status"] == "failed" and row["checks"] == row["a[m]"] == row["seconds"] == ""


def test_a_combination_that_is_no_scene_is_a_row():
    found = sweep(vary={"solid.nu": ["holl", 0.3], "solid.k": [-0.1, 0.3]}, sets=COARSE_SETS)
    assert [row["status"] for row in found] == ["failed", "done", "done", "done"]
    assert "holl" in found[0]["reason"] and found.failed == 1


def test_a_stopped_sweep_goes_on(table, tmp_path):
    """Killed after two scenes; the next call solves the others only."""
    store, deadline = tmp_path / "sweep.jsonl", time.time() + 120
    with start_python("-m", "simulations.sweep", *arguments(tmp_path), stdout=DEVNULL) as running:
        while not (store.exists() and store.read_text().count("\n") >= 2) and time.time() < deadline:
            time.sleep(0.01)
        running.send_signal(signal.SIGKILL)
    kept = store.read_text().count("\n")
    assert 2 <= kept < 6
    done = run(tmp_path, VARY, ranks=2)
    assert done.returncode == 0, done.stderr
    assert f"{kept} of 6 runs kept from before" in done.stdout
    assert len({json.loads(line)["key"] for line in store.read_text().splitlines()}) == 6
    same(rows_of(tmp_path), rows_of(table))


def test_folders_of_the_runs(tmp_path):
    done = run(tmp_path, ("load.amplitude=0.5,0.9",), "--folders")
    assert done.returncode == 0, done.stderr
    for number, row in enumerate(rows_of(tmp_path), start=1):
        summary = json.loads((tmp_path / f"run-{number:04d}" / "summary.json").read_text())
        assert summary["dissipated_energy"] == pytest.approx(float(row["dissipated_energy[J/m]"]), rel=1e-12)


def test_the_reference_of_a_folder_is_solved_once(tmp_path, monkeypatch):
    solved, solve = [], reference.of_same_physics
    monkeypatch.setattr(reference, "of_same_physics", lambda *given: solved.append(1) or solve(*given))
    (row,) = sweep(vary={"load.cycles": [0]}, sets=COARSE_SETS, output=tmp_path / "out", folders=True)
    assert row["reference"].startswith("closed form") and len(solved) == 1


def test_scenes_from_a_table(tmp_path):
    (tmp_path / "in.csv").write_text("solid.k,load.mu\n0.3,0.1\n0.5,0.6\n")
    done = run(tmp_path / "out", ("load.amplitude=0.5,0.9",), "--csv-in", str(tmp_path / "in.csv"))
    assert done.returncode == 0, done.stderr
    keys = [(row["solid.k"], row["load.mu"], row["load.amplitude"]) for row in rows_of(tmp_path / "out")]
    assert keys == [("0.3", "0.1", "0.5"), ("0.3", "0.1", "0.9"), ("0.5", "0.6", "0.5"), ("0.5", "0.6", "0.9")]


def test_processes_share_the_scenes(table):
    """Two more processes of this machine."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        found = sweep(vary={"solid.k": [0.0, 0.3, 0.6], "load.mu": [0.2, 0.5]}, executor=executor, sets=COARSE_SETS)
    for row, other in zip(found, rows_of(table), strict=True):
        energy = float(other["dissipated_energy[J/m]"])
        assert row["dissipated_energy[J/m]"] == pytest.approx(energy, rel=1e-8), row["reason"]


@pytest.mark.parametrize("callback", ["Newton._test", "_Operator.apply"])
def test_ctrl_c_while_petsc_calls_back_ends_a_sweep(callback, monkeypatch):
    """PETSc's own error in its place would be the reason of one failed scene, and the sweep would go on."""

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"simulations.solvers.newton.{callback}", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sweep(vary={"load.mu": [0.2, 0.5]}, sets=COARSE_SETS)


def test_threads_are_refused(tmp_path):
    with ThreadPoolExecutor(2) as executor, pytest.raises(SceneError, match="ThreadPoolExecutor is not allowed: PETSc"):
        sweep(vary={"solid.k": [0.0, 0.3]}, executor=executor, sets=COARSE_SETS, output=tmp_path / "out")
    with pytest.raises(SceneError, match="executor = int is not allowed: a ProcessPoolExecutor"):
        sweep(vary={"solid.k": [0.0, 0.3]}, executor=2, sets=COARSE_SETS, output=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_memory_is_flat(bodies):
    """Eight scenes with a body each: none of them stays."""
    sweep(vary={"solid.k": [0.1 * n for n in range(1, 9)]}, sets=(*COARSE_SETS, "load.cycles=0"))
    gc.collect()
    gc.collect()  # what the first pass set free
    assert len(bodies) == 8 and sum(body() is not None for body in bodies) == 0
