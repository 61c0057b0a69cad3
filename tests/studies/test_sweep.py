"""Sweeps: the same table on any ranks and from Python, failed scenes as rows, stopped and resumed, and bad input."""

import gc
import json
import os
import signal
import subprocess
import sys
import time
import weakref
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import pytest
from coarse_sweep import COARSE_SETS, VARY, arguments, rows_of
from running import COARSE, MPI_ENVIRONMENT, ROOT, run_command
from solving import coarse_simulation

import simulations.sweep as command
from simulations import SceneError, sweep
from simulations.runs import checks, comparison, reference
from simulations.runs.reference import closed_form
from simulations.runs.report_data import find
from simulations.scene import DEFAULT_SCENE, make_scene, parse
from simulations.studies import sweeping
from simulations.studies.sweeping import prepared
from simulations.studies.variation import product, read_vary

MEASURED = ("seconds",)


def test_errors_of_every_state_are_checked_as_in_a_single_run(monkeypatch):
    simulation = coarse_simulation().run_to_end()
    exact = closed_form(simulation)
    last = comparison.compare(simulation.history, exact)["traction_l2"]
    largest = comparison.worst(simulation.history, exact)["traction_l2"]
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
    for row in rows:
        assert row["reference"].startswith("closed form")
        assert abs(float(row["error_dissipated_energy"])) < 2e-3
        assert 0 < float(row["c_over_a"]) < 1 and float(row["peak_pressure[Pa]"]) > 0
    assert len({row["a[m]"] for row in rows}) == 3


def test_two_ranks_find_the_same(table, tmp_path):
    done = run(tmp_path, ranks=2)
    assert done.returncode == 0, done.stderr
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
    assert not list(tmp_path.iterdir())


def test_a_row_is_the_scene_alone(table):
    """What neighbours share changes nothing: the last scene's row has the numbers of a run of its own."""
    simulation = coarse_simulation(solid__k=0.6, load__mu=0.5, effects__coupling="false").run_to_end()
    row, scales = rows_of(table)[-1], simulation.scaled.scales
    energy = simulation.history.dissipated_energy * scales.energy
    assert float(row["dissipated_energy[J/m]"]) == pytest.approx(energy, rel=1e-8)
    assert float(row["c_over_a"]) == pytest.approx(simulation.history.entries[-1].c / simulation.history.entries[-1].a)


def test_a_body_is_shared_where_it_is_the_same(monkeypatch):
    """Friction, load, cylinder and modulus only scale an uncoupled contact; amplitude and grading change the mesh."""
    bodies = []
    run_one = sweeping.run_scene

    def watched(values):
        row = run_one(values)
        bodies.append(id(sweeping._kept[0].body))
        return row

    monkeypatch.setattr(sweeping, "run_scene", watched)
    sweep(vary={"load.mu": [0.2, 0.5], "indenter.R": [0.1, 0.2]}, sets=(*COARSE_SETS, "solid.k=0"))
    assert len(bodies) == 4 and len(set(bodies)) == 1
    first = coarse_simulation(effects__coupling="false")
    for change, shared in (
        ("load.mu=0.5", True),
        ("load.P=2e6", True),
        ("load.amplitude=0.5", False),
        ("load.cycles=2", False),
        ("solver.increments=12", False),
        ("solid.k=0.2", False),
        ("mesh.facet=0.05", False),
        ("effects.coupling=true", False),
        ('indenter.profile="circle"', False),
    ):
        simulation = prepared(parse(DEFAULT_SCENE, (*COARSE_SETS, change)), first)
        assert (simulation.body is first.body) == shared, change


COUPLED = COARSE | {"solid.nu": 0.3}
NO_LOOP = {"load.P": None, "load.amplitude": None, "load.cycles": None}
PATH = NO_LOOP | {"load.points": [[1e6, 0.0], [1e6, 1e5], [6e5, 1e5]]}


@pytest.mark.parametrize(
    "keys, changes",
    [
        (COUPLED, {"load.mu": 0.5}),
        (COARSE | {"load.bulk_strain": 1e-4}, {"load.P": 1.1e6}),
        (COARSE | {"load.bulk_strain": 1e-4}, {"load.P": 2e6}),
        (COARSE | {"load.bulk_strain": 1e-4}, {"load.mu": 0.5}),
        (COARSE | {"effects.elastic_slip": 2e-7}, {"load.mu": 0.5}),
        (COUPLED | PATH | {"effects.elastic_slip": 2e-7}, {"solid.E0": 70e9}),
    ],
)
def test_a_body_is_not_shared_where_the_edges_are_others(keys, changes):
    """Strain and elastic slip are values of their own: load, modulus and friction do not only scale them."""
    first = prepared(make_scene(keys), None)
    other = prepared(make_scene(keys | changes), first)
    assert other.body is not first.body and other.cells != first.cells


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


def test_a_combination_that_is_no_scene_is_a_row():
    found = sweep(vary={"solid.nu": ["holl", 0.3], "solid.k": [-0.1, 0.3]}, sets=COARSE_SETS)
    assert [row["status"] for row in found] == ["failed", "done", "done", "done"]
    assert "holl" in found[0]["reason"] and found.failed == 1


def test_a_stopped_sweep_goes_on(table, tmp_path):
    """Killed after two scenes; the next call solves the others only."""
    command = [sys.executable, "-m", "simulations.sweep", *arguments(tmp_path)]
    environment = os.environ | MPI_ENVIRONMENT | {"PYTHONPATH": str(ROOT)}
    store, deadline = tmp_path / "sweep.jsonl", time.time() + 120
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL) as running:
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
    with ThreadPoolExecutor(2) as executor, pytest.raises(SceneError, match="ThreadPoolExecutor is not allowed: "):
        sweep(vary={"solid.k": [0.0, 0.3]}, executor=executor, sets=COARSE_SETS, output=tmp_path / "out")
    assert not (tmp_path / "out").exists()


BAD = {
    "nothing": ([], "nothing varies"),
    "no key": (["--vary", "=1,2"], "KEY=FIRST:LAST:COUNT"),
    "no value": (["--vary", "solid.k="], "KEY=FIRST:LAST:COUNT"),
    "a hole": (["--vary", "solid.nu=holl,,0.3"], "missing between two commas"),
    "unknown key": (["--vary", "solid.kk=0.1,0.2"], "solid.k?"),
    "twice": (["--vary", "solid.k=0.1,0.2", "--vary", "solid.k=0.3,0.4"], "twice"),
    "same value": (["--vary", "solid.k=0.1,0.1"], "twice"),
    "set and vary": (["--vary", "solid.k=0.1,0.2", "--set", "solid.k=0.3"], "--set solid.k=0.3"),
    "two keys for one": (["--vary", "solid.y0=1,2", "--vary", "solid.y0_over_a0=1,2"], "y0"),
    "one end": (["--vary", "solid.k=0.1:0.1:3"], "two different ends"),
    "one value": (["--vary", "solid.k=0.1:0.2:1"], "2 to 100000"),
    "no count": (["--vary", "solid.k=0.1:0.2"], "FIRST:LAST:COUNT"),
    "words": (["--vary", "solid.k=a:b:3"], "FIRST:LAST:COUNT"),
    "out of range": (["--vary", "solid.k=0.1,1.5"], "1.5"),
    "no number": (["--vary", "load.mu=0.1,nan"], "load.mu = nan is to vary, but: load.mu = nan is not allowed"),
    "too many": (["--vary", "solid.k=0:0.9:1000", "--vary", "load.mu=0.1:0.9:1000"], "1000000 scenes"),
    "part of a count": (["--vary", "solid.k=0.1:0.2:1.5"], "COUNT from 2 to 100000"),
    "no file": (["--csv-in", "absent.csv"], "absent.csv cannot be read: No such file"),
    "no scene": (["absent.toml", "--vary", "solid.k=0.1,0.2"], "absent.toml"),
    "option": (["--vry", "solid.k=0.1,0.2"], "--vry"),
}


@pytest.mark.parametrize("words, said", BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line(tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError) as refusal:
        command.read([*words, "--output", "out"])
    assert said in str(refusal.value) and "\n" not in str(refusal.value)
    assert list(tmp_path.iterdir()) == []


SHORT, HOLE = "solid.k,load.mu\n0.1\n", "solid.k\n0.1\n \n"
TABLES = {"": "keys", "solid.k\n": "keys", "solid.k,solid.k\n1,2\n": "keys", "solid.kk\n0.1\n": "solid.k?"}
TABLES |= {"solid.k;load.mu\n0,1;0,2\n": "separated by ;"}
TABLES |= {SHORT: "line 2", HOLE: "line 3", "solid.k\n0.1\n0.1\n": "twice"}


@pytest.mark.parametrize("text, said", TABLES.items())
def test_a_bad_table_is_one_line(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.csv").write_text(text)
    with pytest.raises(SceneError) as refusal:
        command.read(["--csv-in", "in.csv", "--output", "out"])
    assert said in str(refusal.value) and "\n" not in str(refusal.value)
    assert [path.name for path in tmp_path.iterdir()] == ["in.csv"]


def test_a_scene_that_is_not_toml_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "comma.toml").write_text("k = 0,3")
    with pytest.raises(SceneError, match="scene comma.toml is not TOML: .*'k = 0,3'"):
        command.read(["comma.toml", "--vary", "solid.k=0.1,0.2", "--output", "out"])
    assert [path.name for path in tmp_path.iterdir()] == ["comma.toml"]


def test_a_refusal_as_the_user_sees_it(tmp_path):
    words = ["--vary", "solid.kk=0.1,0.2", "--output", "out"]
    done = run_command(*words, module="simulations.sweep", cwd=tmp_path, timeout=120, ranks=2)
    assert done.returncode == 2, done.stderr
    assert sum("did you mean solid.k?" in line for line in done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr and done.stdout == "" and list(tmp_path.iterdir()) == []


def test_what_is_wrong_without_the_key_that_varies_is_not_blamed_on_it():
    for words, said in ((["--set", "foo=1"], "foo = 1 is not a key"), (["--set", "load.mu=-1"], "load.mu = -1")):
        with pytest.raises(SceneError, match=f"^{said}"):
            command.read([*words, "--vary", "solid.k=0.1,0.2", "--output", "out"])
    with pytest.raises(SceneError, match="^solid.k = 1.5 is to vary, but: "):
        command.read(["--vary", "solid.k=1.5,2.5", "--output", "out"])


def test_values_of_a_key():
    assert read_vary(["solid.k=-0.5:0.9:15"])["solid.k"][8] == 0.3
    assert read_vary(["a=holl, 0.3"]) == {"a": ["holl", 0.3]}
    assert read_vary(['a="a,b",c']) == {"a": ["a,b", "c"]}
    assert read_vary(['a=["normal","A"],named']) == {"a": [["normal", "A"], "named"]}
    assert read_vary(["a=Bob's, 'x, ]', Ann's"]) == {"a": ["Bob's", "x, ]", "Ann's"]}
    assert read_vary(["a=true,false"]) == {"a": [True, False]}
    assert read_vary(["a=[[1, 0], [2, 0.5]]"]) == {"a": [[[1, 0], [2, 0.5]]]}
    pairs = [(1, 3), (1, 4), (2, 3), (2, 4)]
    assert product({"a": [1, 2], "b": [3, 4]}) == [{"a": a, "b": b} for a, b in pairs]
    assert product([{"a": 1}, {"a": 2}]) == [{"a": 1}, {"a": 2}]
    for wrong in ({}, {"a": []}, [], {"a": [1, 1.0]}, {"a": [[1, 0], [1, 0]]}):
        with pytest.raises(SceneError, match="vary|varies"):
            product(wrong)


def test_memory_is_flat(monkeypatch):
    """Eight scenes with a body each: none of them stays."""
    bodies = []
    run_one = sweeping.run_scene

    def watched(values):
        row = run_one(values)
        bodies.append(weakref.ref(sweeping._kept[0].body))
        return row

    monkeypatch.setattr(sweeping, "run_scene", watched)
    sweep(vary={"solid.k": [0.1 * n for n in range(1, 9)]}, sets=(*COARSE_SETS, "load.cycles=0"))
    gc.collect()
    gc.collect()  # what the first pass set free
    assert len(bodies) == 8 and sum(body() is not None for body in bodies) == 0
