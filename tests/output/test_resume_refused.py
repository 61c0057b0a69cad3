"""What --resume does not go on from, what a resumed run says of its past, and a new run in the folder of an old one."""

import json
import re
import shutil

import numpy as np
import pytest
from restarting import RUN, refusal
from running import coarse_arguments, contents, csv_rows

from simulations import __version__, fretting, report
from simulations.runs.checks import ChecksFailed
from simulations.scene import SceneError


@pytest.fixture(scope="module")
def after_two(tmp_path_factory):
    """A run that ended after its second increment; nobody writes there."""
    folder = tmp_path_factory.mktemp("after_two") / "run"

    def stop(progress, entry):
        if len(progress.simulation.history.entries) == 2:
            raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr("simulations.command.progress.Progress.step", stop)
        fretting.main(coarse_arguments(folder, **RUN))
    return folder


@pytest.fixture
def stopped(after_two, tmp_path):
    return shutil.copytree(after_two, tmp_path / "run")


def test_other_keys_are_refused(stopped):
    for more in (["--set", "load.mu=0.2"], ["scenes/holl.toml"], ["--output", "elsewhere"], ["--explain"]):
        assert "--resume takes no scene" in refusal("--resume", stopped, *more)


def test_a_scene_changed_since_is_refused(stopped, uninterrupted, tmp_path):
    """Whether the run ended or not, and by the report of it too."""
    ended = shutil.copytree(uninterrupted, tmp_path / "ended")
    for folder in (stopped, ended):
        scene = folder / "scene.toml"
        scene.write_text(scene.read_text().replace("mu = 0.3", "mu = 0.31"))
        assert "changed afterwards" in refusal("--resume", folder)
    with pytest.raises(SceneError, match="scene.toml is not as the run wrote it"):
        report.main([str(ended)])
    assert not (ended / "report.html").exists()


@pytest.mark.parametrize("content", [b"", bytes(2), b"solid = 1"])
def test_a_scene_that_is_lost_is_not_read(stopped, content):
    """By a power cut, for one: what would be said of keys that are missing in it helps nobody."""
    (stopped / "scene.toml").write_bytes(content)
    assert "scene.toml is not as the run wrote it" in refusal("--resume", stopped)


@pytest.mark.parametrize("checks", [None, {"x": {}}, {"x": None}, [1]])
def test_a_summary_whose_checks_were_changed_is_refused(uninterrupted, tmp_path, checks):
    folder = shutil.copytree(uninterrupted, tmp_path / "ended")
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps(summary | {"checks": checks}))
    assert "the checks in summary.json are not as the run wrote them" in refusal("--resume", folder)


def test_a_complete_run_that_has_lost_a_table_is_refused(uninterrupted, tmp_path):
    folder = shutil.copytree(uninterrupted, tmp_path / "ended")
    (folder / "surface.h5").unlink()
    assert "complete, but its surface.h5 is missing; start again" in refusal("--resume", folder)


def test_an_accuracy_that_was_not_judged_does_not_hold(tmp_path, monkeypatch):
    """The run is stopped while a second mesh is solved for it: there is nothing left from which it could be judged."""

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(fretting, "judged", stop)
    short = ["--set", "load.cycles=0", "--set", "solver.increments=1"]
    with pytest.raises(KeyboardInterrupt):
        fretting.main(["--accuracy", "1e-2", *short, "--output", str(tmp_path / "run"), "--quiet"])
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["converged"] and not summary["checks_hold"] and summary["checks"]["accuracy"]["value"] is None
    with pytest.raises(ChecksFailed, match=r"^checks that fail: accuracy \(the accuracy was not judged, .*--overwrite"):
        fretting.main(["--resume", str(tmp_path / "run")])


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
def test_damaged_checkpoint_is_refused(stopped, name, damaged, why):
    path = stopped / "checkpoint" / name
    path.write_bytes(damaged(path.read_bytes()))
    before = contents(stopped)
    said = refusal("--resume", stopped)
    assert "checkpoint cannot be read" in said and why in said and "--overwrite" in said
    assert contents(stopped) == before


@pytest.mark.parametrize("name", ["mesh.h5", "000000.h5"])
def test_a_run_whose_fields_are_gone_is_refused(stopped, monkeypatch, name):
    """Before the mesh is made: its results would refer to a file that does not exist."""
    monkeypatch.setattr(fretting, "Simulation", None)
    (stopped / "fields" / name).unlink()
    before = contents(stopped)
    assert f"fields/{name} is missing; start again" in refusal("--resume", stopped)
    assert contents(stopped) == before


def test_the_checkpoint_of_another_version_is_refused(stopped, monkeypatch):
    monkeypatch.setattr("simulations.output.checkpoint.__version__", "9.9.9")
    assert f"graded-fretting {__version__} made it, and this is 9.9.9" in refusal("--resume", stopped)


def test_what_a_resumed_run_reports_of_earlier_increments(stopped, uninterrupted):
    """Tolerances and changes of contact states are kept too: checks and history.csv are as if nothing had happened.

    That it was resumed is said, and the seconds are those of both parts.
    """
    with np.load(stopped / "checkpoint" / "memory.npz") as memory:
        before = dict(zip(memory["phases"].tolist(), memory["seconds"].tolist()))
    fretting.main(["--resume", str(stopped), "--quiet"])
    histories = [csv_rows(folder / "history.csv") for folder in (stopped, uninterrupted)]
    for one, other in zip(*histories, strict=True):
        assert one["states_changed"] == other["states_changed"]
    checks = [json.loads((folder / "summary.json").read_text())["checks"] for folder in (stopped, uninterrupted)]
    assert {name: c["limit"] for name, c in checks[0].items()} == {name: c["limit"] for name, c in checks[1].items()}
    summary = json.loads((stopped / "summary.json").read_text())
    took = [float(row["seconds"]) for row in histories[0]]
    assert summary["resumed"] == 1 and summary["seconds"]["total"] > before["total"]
    assert summary["seconds"]["solve"] == pytest.approx(sum(took), abs=1e-2)
    assert summary["seconds"]["mesh"] > before["mesh"] > 0.0


def test_the_report_of_a_run_that_goes_on_is_taken_away(stopped):
    """It says that the run did not reach its end."""
    report.main([str(stopped)])
    assert (stopped / "report.html").exists()
    fretting.main(["--resume", str(stopped), "--quiet"])
    assert not (stopped / "report.html").exists()


def test_the_summary_of_a_run_that_goes_on_is_taken_away(stopped, monkeypatch):
    """Tables are written meanwhile, and it does not go with them: there is no report before the run has ended again."""
    assert json.loads((stopped / "summary.json").read_text())["increments"] == 2
    monkeypatch.setattr(fretting, "go", lambda *_: None)  # as if it were killed at once
    fretting.main(["--resume", str(stopped), "--quiet"])
    with pytest.raises(SceneError, match="the whole of a run that ended: summary.json is missing"):
        report.main([str(stopped)])


def test_a_new_run_in_the_folder_of_an_old_one(stopped, uninterrupted):
    """Refused, but where the old one is to be replaced: then nothing of it is left in the new one's files."""
    again = coarse_arguments(stopped, **RUN, load__cycles=0)
    before = contents(stopped)
    assert re.search("holds a run that was stopped; go on with --resume .* --overwrite", refusal(*again))
    assert contents(stopped) == before
    fretting.main([*again, "--overwrite"])
    assert len(csv_rows(stopped / "history.csv")) == 3
    assert not (stopped / "checkpoint").exists()
    assert len(list((stopped / "fields").iterdir())) == 3  # mesh, normal stage, A
