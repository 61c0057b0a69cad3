"""A run that is killed goes on with --resume and ends as if nothing had happened."""

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

import h5py
import meshio
import numpy as np
import pandas
import pytest
from running import MPI_ENVIRONMENT, ROOT, coarse_arguments, run_command

from simulations import fretting, indentation
from simulations.output import files as output
from simulations.scene import SceneError

SAME = 1e-10  # relative to the largest value: what an interruption may change
QUANTITIES = ("pressure", "gap", "traction", "slip", "frictional_work", "frictional_work_of_cycle")
QUANTITIES += ("load_parameter", "P_prescribed", "P_carried", "Q_prescribed", "Q_carried")
COLUMNS = ("load_parameter", "P_prescribed[N/m]", "P_carried[N/m]", "delta_y[m]", "a[m]", "contact_left[m]")
COLUMNS += ("peak_pressure[Pa]", "Q_prescribed[N/m]", "delta_x[m]", "c[m]", "stick_left[m]", "dissipated_energy[J/m]")


def surface(folder):
    with h5py.File(folder / "surface.h5") as file:
        return {name: file[name][...] for name in file}


def history(folder):
    with open(folder / "history.csv", newline="") as file:
        return list(csv.DictReader(file))


def assert_same(folder, expected):
    """Every number of every increment, and every file, as in the run that was not stopped."""
    mine, theirs = surface(folder), surface(expected)
    for name in QUANTITIES:
        if name in theirs:
            scale = np.abs(theirs[name]).max()
            assert mine[name].shape == theirs[name].shape
            assert np.abs(mine[name] - theirs[name]).max() <= SAME * scale, name
    for one, other in zip(history(folder), history(expected), strict=True):
        for name in ("increment", "branch", "cycle", "state"):
            assert one[name] == other[name]
    for name in COLUMNS:
        if name in other:
            values = np.array([[float(row[name]) for row in history(place)] for place in (folder, expected)])
            assert values[0] == pytest.approx(values[1], rel=1e-9, abs=1e-9 * np.abs(values[1]).max()), name
    assert_same_fields(folder, expected)
    assert json.loads((folder / "summary.json").read_text())["converged"] is True
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in expected.iterdir())


def assert_same_fields(folder, expected):
    lines = [place / "lines.csv" for place in (folder, expected)]
    if lines[1].exists():
        one, other = (pandas.read_csv(path).replace(np.inf, 0.0) for path in lines)
        assert one.select_dtypes(object).equals(other.select_dtypes(object))
        mine, theirs = (table.select_dtypes(float).to_numpy() for table in (one, other))
        assert np.all(np.abs(mine - theirs) <= 1e-8 * np.abs(theirs).max(axis=0))
    with (
        meshio.xdmf.TimeSeriesReader(folder / "fields.xdmf") as one,
        meshio.xdmf.TimeSeriesReader(expected / "fields.xdmf") as other,
    ):
        points = [reader.read_points_cells()[0] for reader in (one, other)]
        assert np.array_equal(*points)
        assert one.num_steps == other.num_steps
        for i in range(one.num_steps):
            (time_1, u_1, stress_1), (time_2, u_2, stress_2) = one.read_data(i), other.read_data(i)
            assert time_1 == time_2
            for mine, theirs in ((u_1, u_2), (stress_1, stress_2)):
                for name in theirs:
                    a, b = np.asarray(mine[name]), np.asarray(theirs[name])
                    assert np.abs(a - b).max() <= 1e-9 * np.abs(b).max(), name


# --- every moment at which something is written ---------------------------------------------------------------

RUN = {"solid__nu": 0.3, "reference__kind": '"none"'}
SCENES = {
    "coupled": {"solid__nu": 0.3},
    "full": {"solver__method": "full", "solid__nu": 0.3},
    "uncoupled": {
        "effects__coupling": "false",
        "solid__nu": 0.3,
        "output__states": '["normal", "C"]',
        "output__lines": "[[0, 0, 1e-3, 2e-3, 5]]",
    },
    "bulk strain": {"solid__nu": 0.3, "load__bulk_strain": 3e-4, "load__bulk_phase": 60},
    "mixed": {"solid__nu": 0.5, "solid__k": -0.1},
    "friction first": {
        "solid__nu": 0.3,
        "effects__friction_in_normal_stage": "true",
        "solver__normal_increments": 3,
        "load__cycles": 0,
    },
}
POINTS = {"uncoupled path": "effects.coupling = false", "coupled path": "effects.coupling = true"}


def path_scene(effects):
    solid = 'solid.E0 = 210e9\nsolid.k = 0.3\nsolid.nu = 0.3\nsolid.y0 = 0.01\nindenter.R = 0.1\nload.mu = 0.3\n'
    return solid + "load.points = [[1e6, 0], [1e6, 1e5], [8e5, 1e5], [8e5, -1e5]]\n" + effects + "\n"


class Killed(BaseException):
    """The process is gone: nothing that would tidy up is run after it."""


def snapshots_of(arguments, folder, monkeypatch, tmp_path, main=fretting.main):
    """Run to the end, with a copy of the folder from each moment just before and after a file takes its place."""
    taken: list[Path] = []
    replace, fsync = os.replace, os.fsync

    def snapshot():
        copy = tmp_path / f"moment{len(taken)}"
        shutil.copytree(folder, copy)
        taken.append(copy)

    def slow_replace(*names):
        snapshot()
        replace(*names)

    def slow_fsync(descriptor):
        fsync(descriptor)
        snapshot()

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", slow_replace)
        patch.setattr(os, "fsync", slow_fsync)
        main([*arguments, "--output", str(folder)])
    snapshot()
    return taken


@pytest.mark.parametrize("case", [*SCENES, *POINTS])
def test_from_every_moment_of_writing(case, tmp_path, monkeypatch):
    """What a SIGKILL would leave at the moments around each write: resumed, some of them twice."""
    if case in SCENES:
        arguments = coarse_arguments("", reference__kind='"none"', **SCENES[case])[:-2]
    else:
        (tmp_path / "scene.toml").write_text(path_scene(POINTS[case]))
        coarse = coarse_arguments("", reference__kind='"none"', solver__increments=1)[:-2]
        arguments = [str(tmp_path / "scene.toml"), *coarse]
    expected = tmp_path / "expected"
    moments = snapshots_of(arguments, expected, monkeypatch, tmp_path)
    whole = [folder for folder in moments if (folder / "scene.toml").exists()]
    assert len(whole) > 20
    for folder in [*whole[1 :: len(whole) // 4], *whole[-3:]]:  # the last ones: when everything is done but tidied up
        fretting.main(["--resume", str(folder), "--quiet"])
        assert_same(folder, expected)


def test_half_a_domain(tmp_path, monkeypatch):
    expected = tmp_path / "expected"
    moments = snapshots_of(coarse_arguments("")[2:-2], expected, monkeypatch, tmp_path, indentation.main)
    for folder in moments[-8:]:
        indentation.main(["--resume", str(folder), "--quiet"])
        assert_same(folder, expected)


# --- real kills -----------------------------------------------------------------------------------------------


def start(*arguments, ranks):
    command = [sys.executable, "-u", "-m", "simulations.fretting", *map(str, arguments)]
    if ranks > 1:
        command = [shutil.which("mpirun"), "-n", str(ranks), *command]
    environment = os.environ | MPI_ENVIRONMENT | {"PYTHONPATH": str(ROOT)}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "stdin": subprocess.DEVNULL}
    return subprocess.Popen(command, cwd=ROOT, env=environment, text=True, **streams)


def descendants(pid):
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [int(child) for child in children] + [grand for child in children for grand in descendants(int(child))]


def kill_after(word, *arguments, ranks, number=signal.SIGKILL):
    """Start, and send ``number`` to one rank once a line with ``word`` is printed. Returns the exit code."""
    process = start(*arguments, ranks=ranks)
    watchdog = threading.Timer(300, process.kill)
    watchdog.start()
    try:
        for line in process.stdout:
            if word in line:
                victim = process.pid
                if ranks > 1:
                    victim = [pid for pid in descendants(process.pid) if b"simulations.fretting" in _command(pid)][-1]
                os.kill(victim, number)
                break
        process.stdout.read()
        return process.wait()
    finally:
        watchdog.cancel()


def _command(pid):
    return Path(f"/proc/{pid}/cmdline").read_bytes()


def to_the_end(folder, ranks):
    done = run_command(*coarse_arguments(folder, **RUN), ranks=ranks)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    return to_the_end(tmp_path_factory.mktemp("uninterrupted"), ranks=1)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [(1, 1, 1, 1), (2, 1, 2, 3)], ids=["one rank", "changing ranks"])
def test_killed_several_times(ranks, uninterrupted, tmp_path):
    """SIGKILL before the first increment, in the first quarter and near the end; the last part runs through."""
    folder, first = tmp_path / "run", coarse_arguments(tmp_path / "run", **RUN)
    for word, count, arguments in zip(
        ("unknowns", " 3/11", " 9/11"), ranks, (first, ["--resume", folder], ["--resume", folder])
    ):
        assert kill_after(word, *arguments, ranks=count) != 0
        summary = folder / "summary.json"  # rank 0 may have heard of the other's end
        assert not summary.exists() or json.loads(summary.read_text())["converged"] is False
    done = run_command("--resume", folder, ranks=ranks[-1])
    assert done.returncode == 0, done.stderr
    assert "going on after increment" in done.stdout
    assert_same(folder, uninterrupted)
    done = run_command("--resume", folder)
    assert done.returncode == 0 and "is complete" in done.stdout


@pytest.mark.parametrize("ranks, number", [(1, signal.SIGINT), (1, signal.SIGTERM), (2, signal.SIGTERM)])
def test_stopped_by_a_signal(ranks, number, uninterrupted, tmp_path):
    folder = tmp_path / "run"
    code = kill_after(" 4/11", *coarse_arguments(folder, **RUN), ranks=ranks, number=number)
    assert code == 128 + number if ranks == 1 else code != 0
    summary = folder / "summary.json"
    if summary.exists():
        assert json.loads(summary.read_text())["converged"] is False
    done = run_command("--resume", folder, ranks=3 - ranks)
    assert done.returncode == 0, done.stderr
    assert_same(folder, uninterrupted)


@pytest.mark.parametrize("call", [3, 12, 31, 38, 40, 42])
def test_full_disk(call, uninterrupted, tmp_path, monkeypatch):
    """The disk is full at some write: one line, what was whole stays whole, and the run goes on when there is room."""
    folder, calls, fsync = tmp_path / "run", [], os.fsync

    def full(descriptor):
        calls.append(descriptor)
        if len(calls) >= call:
            raise OSError(28, "No space left on device")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(output.OutputError, match="No space left on device; go on with .*--resume") as error:
        fretting.main(coarse_arguments(folder, **RUN))
    assert "\n" not in str(error.value)
    assert not [path for path in folder.rglob("part.*")]
    monkeypatch.undo()
    fretting.main(["--resume", str(folder)])
    assert_same(folder, uninterrupted)


# --- what cannot be resumed -----------------------------------------------------------------------------------


@pytest.fixture
def stopped(uninterrupted, tmp_path, monkeypatch):
    """A run that ended after its second increment."""
    folder = tmp_path / "run"

    def stop(progress, entry):
        if len(progress.simulation.history.entries) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr("simulations.command.progress.Progress.step", stop)
    with pytest.raises(KeyboardInterrupt):
        fretting.main(coarse_arguments(folder, **RUN))
    monkeypatch.undo()
    return folder


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refusal(capfd, *arguments):
    with pytest.raises(SceneError) as error:
        fretting.main([str(word) for word in arguments])
    assert "\n" not in str(error.value)
    return str(error.value)


def test_other_keys_are_refused(stopped, capfd):
    for more in (["--set", "load.mu=0.2"], ["scenes/holl.toml"], ["--output", "elsewhere"], ["--explain"]):
        assert "--resume takes no scene" in refusal(capfd, "--resume", stopped, *more)


def test_a_scene_changed_since_is_refused(stopped, capfd):
    scene = stopped / "scene.toml"
    scene.write_text(scene.read_text().replace("mu = 0.3", "mu = 0.31"))
    assert "changed afterwards" in refusal(capfd, "--resume", stopped)


DAMAGE = {
    "nonsense": ("memory.npz", lambda old: b"PK\3\4 nonsense", "not a zip file"),
    "empty": ("memory.npz", lambda old: b"", "No data left"),
    "cut short": ("memory.npz", lambda old: old[: len(old) // 2], "not a zip file"),
    "zeroed tail": ("memory.npz", lambda old: old[:-200] + bytes(200), "not a zip file"),
    "another byte": ("memory.npz", lambda old: old[:2000] + bytes([old[2000] ^ 1]) + old[2001:], ""),
    "states cut short": ("states.bin", lambda old: old[:-1], "states.bin is too short"),
    "states with a zeroed tail": ("states.bin", lambda old: old[:-400] + bytes(400), "not as it was written"),
}


@pytest.mark.parametrize("name, damaged, why", DAMAGE.values(), ids=DAMAGE)
def test_damaged_checkpoint_is_refused(stopped, capfd, name, damaged, why):
    path = stopped / "checkpoint" / name
    path.write_bytes(damaged(path.read_bytes()))
    before = contents(stopped)
    said = refusal(capfd, "--resume", stopped)
    assert "checkpoint cannot be read" in said and why in said and "--overwrite" in said
    assert contents(stopped) == before


def test_the_checkpoint_of_another_version_is_refused(stopped, capfd, monkeypatch):
    monkeypatch.setattr("simulations.output.checkpoint.__version__", "9.9.9")
    assert "graded-fretting 0.1.0 made it, and this is 9.9.9" in refusal(capfd, "--resume", stopped)


def test_what_a_resumed_run_reports_of_earlier_increments(stopped, uninterrupted):
    """Tolerances and changes of contact states are kept too: checks and history.csv are as if nothing had happened."""
    fretting.main(["--resume", str(stopped), "--quiet"])
    for one, other in zip(history(stopped), history(uninterrupted), strict=True):
        assert one["states_changed"] == other["states_changed"]
    checks = [json.loads((folder / "summary.json").read_text())["checks"] for folder in (stopped, uninterrupted)]
    assert {name: c["limit"] for name, c in checks[0].items()} == {name: c["limit"] for name, c in checks[1].items()}


def test_a_folder_without_a_run_is_refused(tmp_path, capfd):
    assert "is not the folder of a run" in refusal(capfd, "--resume", tmp_path)
    assert "is not the folder of a run" in refusal(capfd, "--resume", tmp_path / "absent")
    assert list(tmp_path.iterdir()) == []


def test_a_new_run_in_the_folder_of_an_old_one(stopped, uninterrupted, capfd):
    """Refused, but where the old one is to be replaced: then nothing of it is left in the new one's files."""
    again = coarse_arguments(stopped, **RUN, load__cycles=0)
    before = contents(stopped)
    assert re.search("holds a run that was stopped; go on with --resume .* --overwrite", refusal(capfd, *again))
    assert contents(stopped) == before
    fretting.main([*again, "--overwrite"])
    assert len(history(stopped)) == 3
    assert not (stopped / "checkpoint").exists()
    assert len(list((stopped / "fields").iterdir())) == 3  # mesh, normal stage, A
