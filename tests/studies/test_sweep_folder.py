"""The folder of a sweep: nothing in it is replaced silently, and the table belongs to the folders of the runs."""

import json
import shutil
from pathlib import Path

import pytest
from coarse_sweep import COARSE_SETS, arguments, rows_of
from running import coarse_arguments, contents, fill_disk

import simulations.sweep as command
from simulations import SceneError, SolveError, fretting
from simulations.output import folder as run_folder
from simulations.output.checkpoint import read_scene
from simulations.output.files import OutputError
from simulations.output.lock import Lock, Locked
from simulations.runs.checks import ChecksFailed
from simulations.scene import DEFAULT_SCENE
from simulations.studies import sweeping


def run(folder, values, *more):
    command.main(arguments(folder, [f"load.mu={values}"], "--quiet", *more))


def friction_of(folder):
    return [float(row["load.mu"]) for row in rows_of(folder)]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    run(folder, "0.2,0.25", "--folders")
    return folder


@pytest.mark.parametrize("values, more", [("0.5,0.6", ["--folders"]), ("0.2,0.25", []), ("0.25,0.2", ["--folders"])])
def test_another_sweep_is_refused(swept, values, more):
    """With other scenes, without the folders, or with other numbers of the folders."""
    before = contents(swept)
    with pytest.raises(SceneError, match="it holds another sweep; --overwrite replaces it, another folder keeps both"):
        run(swept, values, *more)
    assert contents(swept) == before


def test_python_names_its_own_argument(swept, tmp_path):
    """Not the option of the command."""
    (tmp_path / "file").touch()
    another = "is not allowed: it holds another sweep; overwrite=True replaces it"
    for folder, why in ((swept, another), (tmp_path / "file", "cannot be written")):
        with pytest.raises(SceneError, match=rf"^output = {str(folder)[:20]}.* {why}"):  # long paths are cut
            sweeping.sweep(vary={"load.mu": [0.5]}, sets=COARSE_SETS, output=folder)


def test_a_full_disk_in_the_folder_of_a_run_names_the_sweep(tmp_path, monkeypatch):
    """Not --resume, with which a single run goes on: the sweep would not know of it. It ends: no other run is kept."""
    fill_disk(monkeypatch, 4)  # after both folders and the scene
    with pytest.raises(OutputError) as error:
        sweeping.sweep(vary={"load.cycles": [0, 1]}, sets=COARSE_SETS, output=tmp_path, folders=True)
    why = "No space left on device; go on with the same sweep"
    assert str(error.value) == f"{tmp_path}/run-0001 cannot be written: {why}"
    assert not [*tmp_path.glob("run-0002")]
    monkeypatch.undo()
    (row,) = sweeping.sweep(vary={"load.cycles": [0]}, sets=COARSE_SETS, output=tmp_path, folders=True)
    assert row["status"] == "done"


@pytest.mark.parametrize("lost", ["scene.toml", "history.csv", "summary.json", "what is in scene.toml"])
@pytest.mark.parametrize("more", [(), ("--overwrite",)])
def test_a_run_that_is_not_whole_is_solved_again(swept, tmp_path, lost, more):
    folder = shutil.copytree(swept, tmp_path / "sweep")
    if lost in run_folder.FILES:
        (folder / "run-0002" / lost).unlink()
    else:  # by a power cut
        (folder / "run-0002" / "scene.toml").write_bytes(bytes(300))
    run(folder, "0.2,0.25", "--folders", *more)
    assert read_scene(folder / "run-0002").mu == 0.25 and run_folder.is_whole(folder / "run-0002")
    assert friction_of(folder)[:2] == [0.2, 0.25]


def test_a_larger_sweep_goes_on(swept, monkeypatch):
    solved = []
    run_scene = sweeping.run_scene
    monkeypatch.setattr(sweeping, "run_scene", lambda values: solved.append(values["set"][-1]) or run_scene(values))
    run(swept, "0.2,0.25,0.3", "--folders")
    assert solved == ["load.mu=0.3"] and friction_of(swept) == [0.2, 0.25, 0.3]


def test_a_sweep_that_was_moved_goes_on(tmp_path, monkeypatch):
    """Also where its folder is named in another way."""
    run(tmp_path / "one", "0.2", "--folders")
    (tmp_path / "one").rename(tmp_path / "two")
    monkeypatch.setattr(sweeping, "run_scene", None)
    run(tmp_path / "two", "0.2", "--folders")
    monkeypatch.chdir(tmp_path)
    run("two", "0.2", "--folders")
    assert friction_of(tmp_path / "two") == [0.2]


def test_a_changed_comment_makes_no_other_sweep(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = Path("scene.toml")
    for text in (DEFAULT_SCENE, DEFAULT_SCENE.replace("# m", "# metres")):
        scene.write_text(text)
        command.main([str(scene), *arguments("out", ["load.mu=0.2"], "--quiet")])
        monkeypatch.setattr(sweeping, "run_scene", None)
    assert friction_of(Path("out")) == [0.2]


def test_every_process_writes_into_the_same_folder(tmp_path, monkeypatch):
    """Also one that works in another folder, as where a notebook has changed its own since it made the processes."""
    monkeypatch.chdir(tmp_path)
    (item,) = sweeping.items_of(DEFAULT_SCENE, (), [{"load.mu": 0.2}], "out")
    assert item.values["folder"] == str(tmp_path / "out" / "run-0001")


def test_a_run_whose_folder_is_gone_is_run_again(tmp_path):
    run(tmp_path, "0.2,0.25", "--folders")
    before = rows_of(tmp_path)
    shutil.rmtree(tmp_path / "run-0002")
    (tmp_path / "run-0001" / "fretting.png").unlink()
    run(tmp_path, "0.2,0.25", "--folders")
    assert read_scene(tmp_path / "run-0002").mu == 0.25
    assert not (tmp_path / "run-0001" / "fretting.png").exists()  # this one is complete without
    assert [row["load.mu"] for row in rows_of(tmp_path)] == [row["load.mu"] for row in before]
    assert rows_of(tmp_path)[0] == before[0]


@pytest.mark.parametrize("tail", [b"\0\0\0", b"my notes\n"])
def test_a_line_of_another_hand_does_not_hide_the_finished_rows(tmp_path, monkeypatch, tail):
    """Zeros are what a power cut may leave."""
    run(tmp_path, "0.2,0.25")
    with (tmp_path / "sweep.jsonl").open("ab") as file:
        file.write(tail)
    solved = []
    run_scene = sweeping.run_scene
    monkeypatch.setattr(sweeping, "run_scene", lambda values: solved.append(values["set"][-1]) or run_scene(values))
    for _ in range(2):
        run(tmp_path, "0.2,0.25,0.3")
        assert solved == ["load.mu=0.3"] and friction_of(tmp_path) == [0.2, 0.25, 0.3]


def test_the_file_of_another_hand_is_the_one_that_is_named(tmp_path):
    run(tmp_path, "0.2")
    (tmp_path / "sweep.jsonl").write_text("my notes\n")
    with pytest.raises(SceneError, match="it holds sweep.jsonl, which no sweep wrote"):
        run(tmp_path, "0.2")


def test_what_overwrite_replaces(tmp_path):
    run(tmp_path, "0.2,0.25", "--folders")
    (tmp_path / "run-0002" / "notes.txt").write_text("mine")
    single = shutil.copytree(tmp_path / "run-0001", tmp_path / "run-2024")
    run(tmp_path, "0.5,0.6", "--folders", "--overwrite")
    assert friction_of(tmp_path) == [0.5, 0.6]
    assert [read_scene(tmp_path / f"run-000{n}").mu for n in (1, 2)] == [0.5, 0.6]
    run(tmp_path, "0.7", "--overwrite")
    assert friction_of(tmp_path) == [0.7] and len((tmp_path / "sweep.jsonl").read_text().splitlines()) == 1
    assert contents(tmp_path / "run-0002") == {Path("notes.txt"): b"mine"}
    assert not (tmp_path / "run-0001").exists() and run_folder.is_whole(single)


def test_overwrite_takes_away_a_run_that_failed(tmp_path, monkeypatch):
    """It is in no row, and would be in the way of another scene of its number."""

    def fail(simulation):
        raise SolveError("no solution")
        yield

    with monkeypatch.context() as patch, pytest.raises(SystemExit):
        patch.setattr(sweeping.Simulation, "run", fail)
        run(tmp_path, "0.2", "--folders")
    assert read_scene(tmp_path / "run-0001").mu == 0.2
    run(tmp_path, "0.5", "--overwrite")
    assert sorted(contents(tmp_path)) == [Path("sweep.csv"), Path("sweep.jsonl")]


@pytest.mark.parametrize(
    "name, text, said",
    [
        ("sweep.csv", "my own table\n", "sweep.csv, which no sweep wrote"),
        ("sweep.jsonl", "my notes\n", "sweep.jsonl, which no sweep wrote"),
        ("scene.toml", "mine\n", "scene.toml, of a single run"),
        ("summary.json", "{}\n", "summary.json, of a single run"),
    ],
)
def test_what_no_sweep_wrote_is_not_replaced(tmp_path, name, text, said):
    (tmp_path / name).write_text(text)
    for more in ([], ["--overwrite"]):
        with pytest.raises(SceneError, match=f"it holds {said}; choose another folder"):
            run(tmp_path, "0.5", *more)
    assert contents(tmp_path) == {Path(name): text.encode()}


@pytest.mark.parametrize("more", [(), ("--overwrite",)])
def test_a_single_run_is_not_let_into_the_folder_of_a_sweep(tmp_path, more):
    run(tmp_path, "0.2")
    before = contents(tmp_path)
    with pytest.raises(SceneError, match="it holds sweep.jsonl, of a sweep; choose another folder"):
        fretting.main([*coarse_arguments(tmp_path), *more])
    assert contents(tmp_path) == before


@pytest.mark.parametrize("more", [(), ("--overwrite",)])
@pytest.mark.parametrize("name", ["run-0002", "run-0003"])
def test_a_single_run_does_not_take_the_place_of_a_scene_of_a_sweep(swept, more, name, monkeypatch):
    """The table and the store would go on to tell of the scene; also one that the sweep may have later."""
    before = contents(swept)
    monkeypatch.chdir(swept)
    for folder in (swept / name, Path(name)):
        with pytest.raises(SceneError, match="it is a scene's folder of the sweep around it; choose another folder"):
            fretting.main([*coarse_arguments(folder), *more])
    assert contents(swept) == before


def test_a_run_of_another_scene_in_the_place_of_one_is_kept(swept, tmp_path):
    """The scene is a failed row; that of a stopped sweep is run again."""
    (swept / "run-0001").rename(tmp_path / "run-0001")
    with pytest.raises(SystemExit) as end:
        run(tmp_path, "0.5", "--folders")
    assert end.value.code == 3 and read_scene(tmp_path / "run-0001").mu == 0.2
    assert "it holds a finished run" in rows_of(tmp_path)[0]["reason"]
    run(tmp_path, "0.2", "--folders")
    assert json.loads((tmp_path / "run-0001" / "summary.json").read_text())["converged"]
    assert run_folder.is_run_of(tmp_path / "run-0001", read_scene(tmp_path / "run-0001"))


# --- several at once --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("more", [(), ("--folders",), ("--folders", "--overwrite")])
def test_of_two_sweeps_at_once_one_runs(swept, more):
    before, held = contents(swept), Lock(swept)
    with pytest.raises(Locked, match=f"{swept} is locked"):
        run(swept, "0.2,0.25", *more)
    held.release()
    assert contents(swept) == before


def test_the_folder_is_locked_while_a_sweep_goes_on(tmp_path, monkeypatch):
    """By the command, and by the function."""
    run_scene, tried = sweeping.run_scene, []

    def run_and_try(values):
        with pytest.raises(Locked):
            Lock(tmp_path)
        tried.append(values)
        return run_scene(values)

    monkeypatch.setattr(sweeping, "run_scene", run_and_try)
    run(tmp_path, "0.2")
    sweeping.sweep(vary={"load.mu": [0.3]}, sets=COARSE_SETS, output=tmp_path, overwrite=True)
    assert len(tried) == 2
    Lock(tmp_path).release()


def test_a_run_that_goes_on_is_not_removed(tmp_path):
    run(tmp_path, "0.2", "--folders")
    before, held = contents(tmp_path), Lock(tmp_path / "run-0001")
    with pytest.raises(Locked, match="is locked: "):
        run(tmp_path, "0.3", "--folders", "--overwrite")
    held.release()
    assert contents(tmp_path) == before


def test_a_run_whose_scene_was_changed_stops_overwrite_before_anything_is_removed(tmp_path):
    run(tmp_path, "0.2,0.25", "--folders")
    with open(tmp_path / "run-0002" / "scene.toml", "a") as file:
        file.write("# edited\nload.mu = 0.9\n")
    before = contents(tmp_path)
    with pytest.raises(SceneError, match="scene.toml is not as the run wrote it; it was changed afterwards"):
        run(tmp_path, "0.3,0.4", "--folders", "--overwrite")
    assert contents(tmp_path) == before
    with pytest.raises(SystemExit):
        run(tmp_path, "0.2,0.25", "--folders")
    assert "scene.toml is not as the run wrote it; it was changed" in rows_of(tmp_path)[1]["reason"]


def test_checks_that_fail_are_told(tmp_path, monkeypatch):
    """Their scenes have results, so the exit code is that of a single run whose checks fail."""
    numbers = sweeping.numbers
    monkeypatch.setattr(sweeping, "numbers", lambda *given: numbers(*given) | {"checks": "not held: gap >= 0"})
    with pytest.raises(ChecksFailed, match="^1 of 1 scenes fail their checks: see checks in sweep.csv$"):
        run(tmp_path, "0.2")
    assert friction_of(tmp_path) == [0.2]
