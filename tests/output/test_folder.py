"""The folder of a run: never another's work, never the user's files; locked while a run writes into it."""

import json
import os
import shutil
import socket
import time
from subprocess import PIPE

import pytest
from restarting import RUN, assert_same, refusal
from running import coarse_arguments, contents, run_python, start_python

from simulations import fretting
from simulations.output import checkpoint, lock
from simulations.output import folder as run_folder
from simulations.output.files import OutputError
from simulations.output.lock import Lock, Locked
from simulations.output.results import Results
from simulations.runs.checks import Check

QUICK = {"load__cycles": 0, "solver__increments": 1, "reference__kind": '"none"'}


def arguments(folder, *more, **changes):
    return [*coarse_arguments(folder, **QUICK | changes), "--quiet", *map(str, more)]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished")
    fretting.main(arguments(folder))
    return folder


def test_a_finished_run_is_not_replaced(finished):
    before = contents(finished)
    said = refusal(*arguments(finished, load__amplitude=0.5))
    assert "holds a finished run" in said and "--overwrite" in said
    assert contents(finished) == before


@pytest.mark.parametrize("more", [(), ("--overwrite",)], ids=["", "overwrite"])
def test_the_users_files_are_never_touched(tmp_path, more):
    own = "solid.E0 = 1e9\nsolid.nu = 0.3\nsolid.k = 0.1\nsolid.y0 = 0.1\nindenter.R = 0.1\nload.P = 1e4\n"
    (tmp_path / "scene.toml").write_text(own)
    (tmp_path / "notes.txt").write_text("mine")
    assert "is in it" in refusal(tmp_path / "scene.toml", "--output", tmp_path, *more)
    assert "which is not as a run wrote it" in refusal(*arguments(tmp_path, *more))
    assert contents(tmp_path) == {
        path.relative_to(tmp_path): text.encode()
        for path, text in ((tmp_path / "scene.toml", own), (tmp_path / "notes.txt", "mine"))
    }
    (tmp_path / "scene.toml").rename(tmp_path / "history.csv")
    assert "holds history.csv, which is not as a run wrote it" in refusal(*arguments(tmp_path, *more))


def test_a_lock_that_cannot_be_made_leaves_no_folder(tmp_path, monkeypatch):
    def refuse(folder):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(run_folder, "Lock", refuse)
    assert "cannot be written: No locks available" in refusal(*arguments(tmp_path / "a" / "b"))
    assert list(tmp_path.iterdir()) == []


def test_a_link_to_what_is_not_there_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link").symlink_to("nowhere")
    for folder in ("link", "link/run"):
        assert "written: link is a link to what is not there, not a folder" in refusal(*arguments(folder))
    assert [path.name for path in tmp_path.iterdir()] == ["link"]


def test_a_scene_that_was_edited_after_the_run_is_the_users(finished, tmp_path):
    folder = tmp_path / "run"
    fretting.main(arguments(folder))
    scene = folder / "scene.toml"
    scene.write_text(scene.read_text().replace("0.3", "0.31"))
    assert "holds scene.toml, which is not as a run wrote it" in refusal(*arguments(folder, "--overwrite"))
    assert "0.31" in scene.read_text()


def test_a_scene_refused_late_leaves_nothing_behind(finished, tmp_path):
    """The mesh is too coarse for its slip zone: known only once that is made; an earlier run is still there."""
    too_coarse = {"load__amplitude": 0.01}
    assert "too coarse" in refusal(*arguments(tmp_path / "a" / "b", **too_coarse))
    assert list(tmp_path.iterdir()) == []
    before = contents(finished)
    assert "too coarse" in refusal(*arguments(finished, "--overwrite", **too_coarse))
    assert contents(finished) == before


class Killed(BaseException):
    """The process ends here."""


def kill(*_, **how):
    raise Killed


def test_a_run_that_is_killed_while_it_is_tidied_up_is_complete(finished, tmp_path, monkeypatch):
    """What makes the checkpoint count goes first: half of one would be refused, though all results are there."""
    folder = shutil.copytree(finished, tmp_path / "run")
    (folder / "checkpoint").mkdir()
    (folder / "checkpoint" / "memory.npz").touch()
    assert not checkpoint.is_complete(folder)
    monkeypatch.setattr(shutil, "rmtree", kill)
    with pytest.raises(Killed):
        checkpoint.remove(folder)
    assert checkpoint.is_complete(folder)


def test_a_run_that_is_killed_while_it_is_replaced_is_not_complete(finished, tmp_path, monkeypatch):
    """What says so goes first: else a part of its results would pass for all of them."""
    folder, scene = shutil.copytree(finished, tmp_path / "run"), checkpoint.read_scene(finished)
    monkeypatch.setattr(run_folder, "_state_files", kill)
    monkeypatch.setattr(checkpoint, "remove", kill)
    assert checkpoint.is_complete(folder)
    with pytest.raises(Killed):
        run_folder.begin(folder, scene)
    assert not checkpoint.is_complete(folder) and (folder / "surface.h5").exists()


def test_the_scene_of_a_new_run_comes_when_the_results_of_the_old_one_are_gone(finished, tmp_path, monkeypatch):
    folder, scene = shutil.copytree(finished, tmp_path / "run"), checkpoint.read_scene(finished)
    left = []
    monkeypatch.setattr(run_folder, "write_text", lambda *_: left.extend(contents(folder)))
    run_folder.begin(folder, scene)
    assert [str(path) for path in left] == ["scene.toml"]


# --- the lock -------------------------------------------------------------------------------------------------


def owner(folder, **changes):
    """A lock file as another process would have left it."""
    text = {"host": "elsewhere", "pid": 12, "started": "2025-01-01 00:00:00", "boot": "another"} | changes
    (folder / lock.NAME).write_text(json.dumps(text))


@pytest.mark.parametrize("ranks, jobs", [(1, 3), (2, 2)])
def test_of_several_at_once_one_runs(ranks, jobs, uninterrupted, tmp_path):
    """The others are refused in one line; what the one writes is that of a run alone."""
    words = ["-m", "simulations.fretting", *coarse_arguments(tmp_path / "run", **RUN), "--quiet"]
    runs = [start_python(*words, ranks=ranks, stderr=PIPE, text=True) for _ in range(jobs)]
    said = [run.communicate(timeout=300)[1] for run in runs]
    codes = [run.returncode for run in runs]
    assert sorted(codes) == [0, *[2] * (jobs - 1)], said
    for code, line in zip(codes, said):
        assert code == 0 or (line.count("\n") == 1 and ("is locked" in line or "holds a" in line)), line
    assert_same(tmp_path / "run", uninterrupted)


def test_a_lock_ends_with_its_owner(tmp_path):
    hold = "import time; from pathlib import Path; from simulations.output.lock import Lock; "
    hold += f"Lock(Path({str(tmp_path)!r}))"
    process = start_python("-c", hold + "; print(1, flush=True); time.sleep(60)", stdout=PIPE)
    process.stdout.readline()
    with pytest.raises(Locked, match=f"process ({process.pid}|in a container) on "):
        Lock(tmp_path)
    process.kill()
    process.wait()
    assert (tmp_path / lock.NAME).exists()
    Lock(tmp_path).release()
    assert not (tmp_path / lock.NAME).exists()


def test_a_lock_that_was_taken_over_is_not_removed_by_its_first_owner(tmp_path):
    first = Lock(tmp_path)
    (tmp_path / lock.NAME).unlink()
    second = Lock(tmp_path)
    first.release()
    with pytest.raises(Locked):
        Lock(tmp_path)
    second.release()
    assert not (tmp_path / lock.NAME).exists()


@pytest.mark.parametrize(
    "namespace, who", [("pid:[1]", "a process in a container"), (lock.FIRST_NAMESPACE, "process {}")]
)
def test_the_number_of_a_locks_owner_in_a_container_is_not_told(tmp_path, monkeypatch, namespace, who):
    """On the host it is that of another process."""
    monkeypatch.setattr(lock, "_pid_namespace", lambda: namespace)
    held = Lock(tmp_path)
    with pytest.raises(Locked, match=f"locked: {who.format(os.getpid())} on "):
        Lock(tmp_path)
    held.release()


def test_a_lock_of_another_machine_lives_as_long_as_it_is_touched(tmp_path):
    """Then it is that of its new owner alone, whose name may be shorter."""
    owner(tmp_path, started="2025-01-01 " + 300 * "0")
    with pytest.raises(Locked, match="process 12 on elsewhere"):
        Lock(tmp_path)
    long_ago = time.time() - lock.SILENT - 1
    os.utime(tmp_path / lock.NAME, (long_ago, long_ago))
    held = Lock(tmp_path)
    assert set(json.loads((tmp_path / lock.NAME).read_text())) == {"host", "pid", "started", "boot"}
    with pytest.raises(Locked, match=f" on {socket.gethostname()}, begun 20"):
        Lock(tmp_path)
    held.release()


def test_on_a_file_system_without_locks_a_sign_of_life_counts(tmp_path, monkeypatch):
    def without(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("fcntl.flock", without)
    lock = Lock(tmp_path)
    with pytest.raises(Locked):
        Lock(tmp_path)
    lock.release()
    Lock(tmp_path).release()


def test_a_lock_is_touched_while_it_is_held(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "BEAT", 0.05)
    held = Lock(tmp_path)
    os.utime(tmp_path / lock.NAME, (0, 0))
    time.sleep(0.5)
    assert time.time() - (tmp_path / lock.NAME).stat().st_mtime < 10
    held.release()


def test_a_signal_after_the_end_changes_nothing(tmp_path, monkeypatch):
    """The summary says that the run is complete, and its checkpoint is gone: it must stay so."""
    made = []
    monkeypatch.setattr(fretting, "Results", lambda *words: made.append(Results(*words)) or made[-1])
    fretting.main(arguments(tmp_path))
    before = contents(tmp_path)
    made[0].keep("stopped by SIGTERM")
    assert contents(tmp_path) == before


# --- what cannot be written, and what does not hold -------------------------------------------------------------


def test_a_name_that_is_too_long(tmp_path):
    assert "cannot be written: File name too long" in refusal(*arguments(tmp_path / ("x" * 300) / "run"))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_disappears(tmp_path, monkeypatch):
    folder = tmp_path / "run"

    def vanish(progress, entry):
        folder.rename(tmp_path / "moved") if folder.exists() else None

    monkeypatch.setattr("simulations.command.progress.Progress.step", vanish)
    with pytest.raises(OutputError, match="cannot be written: No such file or directory: the folder is gone") as error:
        fretting.main(arguments(folder))
    assert "\n" not in str(error.value) and not folder.exists()
    monkeypatch.undo()
    (tmp_path / "moved" / lock.NAME).unlink(missing_ok=True)
    fretting.main(["--resume", str(tmp_path / "moved"), "--quiet"])


def test_checks_that_fail_are_a_failure(tmp_path):
    """An exit code of its own, said under --quiet too; the results are there, and their summary says so."""
    code = "import simulations.runs.checks as c; c.PENETRATION = -1.0; from simulations.command.command import run; "
    code += f"import sys; sys.argv = ['x', *{arguments(tmp_path / 'run')!r}]; "
    code += "from simulations.fretting import main; run(main)"
    done = run_python("-c", code, ranks=2, timeout=300)
    assert done.returncode == 4 and done.stdout == ""
    assert done.stderr.startswith("checks that fail: gap >= 0") and done.stderr.count("\n") == 1
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["converged"] is True and summary["checks_hold"] is False
    assert summary["checks"]["gap >= 0"]["holds"] is False
    assert Check(**{k: v for k, v in summary["checks"]["residual"].items() if k != "holds"}).holds


def test_packages_that_are_not_the_recorded_ones_are_named_with_every_run(tmp_path, monkeypatch):
    moved = tmp_path / "moved.txt"
    moved.write_text("python3-numpy 1:2.2.4+ds-1 1:2.2.5+ds-1\n")
    monkeypatch.setattr(run_folder, "MOVED", moved)
    assert run_folder.versions()["python3-numpy"] == "1:2.2.5+ds-1 (recorded: 1:2.2.4+ds-1)"
    moved.write_text("")
    assert "python3-numpy" not in run_folder.versions()
