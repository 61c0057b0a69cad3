"""A run that is killed goes on with --resume and ends as if nothing had happened."""

import json
import os
import shutil
import signal
import subprocess
import threading
from pathlib import Path

import pytest
from restarting import RUN, assert_same
from running import coarse_arguments, ranks_of, run_command, start_python

from simulations import fretting, indentation, report
from simulations.output.checkpoint import is_complete
from simulations.output.fields import FieldWriter

# --- every moment at which something is written ---------------------------------------------------------------

SCENES = {
    "coupled": {"solid__nu": 0.3},
    "full": {"solver__method": "full", "solid__nu": 0.3, "load__cycles": 0, "solver__increments": 4},
    "uncoupled": {
        "effects__coupling": "false",
        "solid__nu": 0.3,
        "output__states": '["normal", "C"]',
        "output__lines": "[[0, 0, 1e-3, 2e-3, 5]]",
    },
    "bulk strain": {"solid__nu": 0.3, "load__bulk_strain": 3e-4, "load__bulk_phase": 60},
    "elastic slip": {"solid__nu": 0.3, "effects__elastic_slip": 3e-6},
    "mixed": {"solid__nu": 0.5, "solid__k": -0.1},
    "friction first": {
        "solid__nu": 0.3,
        "effects__friction_in_normal_stage": "true",
        "solver__normal_increments": 2,
        "solver__increments": 1,  # a whole cycle: points slide and stick again elsewhere
    },
}
POINTS = {"uncoupled path": "effects.coupling = false", "coupled path": "effects.coupling = true"}


def path_scene(effects):
    solid = 'solid.E0 = 210e9\nsolid.k = 0.3\nsolid.nu = 0.3\nsolid.y0 = 0.01\nindenter.R = 0.1\nload.mu = 0.3\n'
    return solid + "load.points = [[1e6, 0], [1e6, 1e5], [8e5, 1e5], [8e5, -1e5]]\n" + effects + "\n"


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


def has_checkpoint(folder) -> bool:
    return (folder / "checkpoint" / "memory.npz").exists()


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
    begun = next(i for i, folder in enumerate(moments) if has_checkpoint(folder))  # from here on nothing is lost
    assert all(has_checkpoint(folder) or is_complete(folder) for folder in moments[begun:])
    some = whole[len(whole) // 3 :: len(whole) // 3]
    if case == "coupled":  # at the beginning, and when everything is done but tidied up, no scene is special
        some += [whole[1], *whole[-3:]]
    for folder in some:
        fretting.main(["--resume", str(folder), "--quiet"])
        assert_same(folder, expected)


def test_half_a_domain(tmp_path, monkeypatch):
    expected = tmp_path / "expected"
    moments = snapshots_of(coarse_arguments("")[2:-2], expected, monkeypatch, tmp_path, indentation.main)
    for folder in moments[-8:]:
        indentation.main(["--resume", str(folder), "--quiet"])
        assert_same(folder, expected)


@pytest.mark.parametrize("first, increments", [(0, 1), (1, 3)])
def test_of_a_state_that_was_not_yet_on_the_disk_no_index_tells(first, increments, tmp_path, monkeypatch):
    """A signal in the middle of its fields, the first or others: readers would ask for a file that is not there."""
    write = FieldWriter.write

    def interrupted(writer, number):
        if number >= first:
            (writer.folder / "fields").mkdir(exist_ok=True)
            (writer.folder / "fields" / "mesh.h5").touch()
            raise KeyboardInterrupt
        write(writer, number)

    monkeypatch.setattr(FieldWriter, "write", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fretting.main(coarse_arguments(tmp_path, **RUN, output__points="[[0, 1e-4]]"))
    assert json.loads((tmp_path / "summary.json").read_text())["increments"] == increments
    assert (tmp_path / "lines.csv").exists() == (first > 0)
    report.main([str(tmp_path)])


# --- real kills -----------------------------------------------------------------------------------------------


def kill_after(word, *arguments, ranks, number=signal.SIGKILL):
    """Start, and send ``number`` to one rank once a line with ``word`` is printed. Returns the exit code."""
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    process = start_python("-u", "-m", "simulations.fretting", *arguments, ranks=ranks, **streams)
    watchdog = threading.Timer(300, process.kill)
    watchdog.start()
    try:
        for line in process.stdout:
            if word in line:
                os.kill(process.pid if ranks == 1 else ranks_of(process.pid)[-1], number)
                break
        process.stdout.read()
        return process.wait()
    finally:
        watchdog.cancel()


@pytest.mark.slow
def test_killed_several_times(uninterrupted, tmp_path):
    """SIGKILL before the first load step, in the first quarter and near the end; the last part runs through. On other
    ranks each time: on the same ones runs are stopped in tests/command.
    """
    folder, first = tmp_path / "run", coarse_arguments(tmp_path / "run", **RUN)
    again = ["--resume", folder]
    for word, ranks, arguments in (("unknowns", 2, first), (" 3/11", 1, again), (" 9/11", 2, again)):
        assert kill_after(word, *arguments, ranks=ranks) != 0
        summary = folder / "summary.json"  # rank 0 may have heard of the other's end
        assert not summary.exists() or json.loads(summary.read_text())["converged"] is False
    done = run_command("--resume", folder, ranks=3)
    assert done.returncode == 0, done.stderr
    assert "going on after increment" in done.stdout
    assert_same(folder, uninterrupted)
    done = run_command("--resume", folder)
    assert done.returncode == 0 and "is complete" in done.stdout


@pytest.mark.parametrize("ranks, number", [(1, signal.SIGINT), (2, signal.SIGTERM)])
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
