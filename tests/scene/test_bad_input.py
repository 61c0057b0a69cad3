"""Wrong input: one line that names key, value and what is allowed; exit code 2; nothing written; at once."""

import importlib
import json
import os
import subprocess
import time
from subprocess import PIPE

import pytest
from refusals import REFUSED, SCENES, refusal, write_scenes
from running import ROOT, coarse_arguments, environment, python, run_command, run_python, start_python

from simulations.scene import DEFAULT_SCENE, SceneError, parse

SECONDS = 5  # of the processor: a busy machine counts for nothing


@pytest.fixture
def folder(tmp_path, monkeypatch):
    write_scenes(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(line, words):
    assert line is not None, "not refused"
    assert line.isprintable() and len(line) < 1000, line
    for word in words:
        assert word in line


@pytest.mark.parametrize("case", REFUSED)
def test_one_line_and_nothing_written(case, folder, capfd):
    arguments, words = REFUSED[case]
    start = time.process_time()
    check(refusal(arguments), words)
    assert time.process_time() - start < SECONDS
    assert capfd.readouterr() == ("", "")
    assert sorted(path.name for path in folder.iterdir()) == sorted(SCENES)


def test_all_of_them_on_three_ranks(folder):
    """Every rank raises the same line, in step with the others."""
    done = run_python(ROOT / "tests" / "scene" / "refusals.py", ranks=3, timeout=300, cwd=folder)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert set(found) == set(REFUSED)
    for case, by_rank in found.items():
        for line in by_rank:
            check(line, REFUSED[case][1])
    assert sorted(path.name for path in folder.iterdir()) == sorted(SCENES)


@pytest.mark.parametrize("case, ranks", [("misspelt key", 1), ("output below a file", 3)])
def test_commands_end_with_code_2(case, ranks, folder):
    arguments, words = REFUSED[case]
    done = run_command(*arguments, ranks=ranks, cwd=folder, timeout=60)
    assert done.returncode == 2
    assert done.stdout == ""
    own = done.stderr.split("-" * 40)[0].strip().splitlines()
    if ranks > 1:  # mpirun has a box of its own above, and lines in brackets on how its ranks ended
        own = [line for line in own if line and not line.startswith("[")]
    assert len(own) == 1, done.stderr
    check(own[0], words)


NEEDED = ("solid.E0", "solid.k", "solid.nu", "indenter.R", "load.P", "load.mu", "load.amplitude")


@pytest.mark.parametrize("key", NEEDED)
def test_missing_key_is_named(key):
    name = key.partition(".")[2]
    text = "\n".join(line for line in DEFAULT_SCENE.splitlines() if not line.startswith(f"{name} "))
    with pytest.raises(SceneError, match=f"{key} is missing"):
        parse(text)


def test_no_room_for_results(tmp_path):
    """A limit on the size of files stands for a disk that has no room: it needs no rights."""
    program = (
        "import resource; from simulations.command.command import run; from simulations.fretting import main; "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)); run(main)"
    )
    done = run_python("-B", "-c", program, "--output", tmp_path / "a" / "b", timeout=60)
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.splitlines()) == 1 and "cannot be written: File too large" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_indentation_has_no_friction(folder):
    scene = folder / "scene.toml"
    scene.write_text(DEFAULT_SCENE)
    done = run_command(scene, cwd=folder, module="simulations.indentation")
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert done.stderr.startswith("load.mu = 0.3 is not allowed with simulations.indentation")
    assert not (folder / "results").exists()


@pytest.mark.parametrize(
    "module, arguments",
    [
        ("sweep", ["--vary", "load.mu=0.1,0.2", "--output", ""]),
        ("report", [""]),
        ("studies.figures", ["--output", ""]),
        ("studies.stability", ["--page", ""]),
        ("studies.body_stress", [""]),
    ],
)
def test_no_command_takes_the_empty_text_for_this_folder(module, arguments, folder):
    main = importlib.import_module(f"simulations.{module}").main
    with pytest.raises(SceneError, match="^argument .*: '' is not allowed: the name of a file or folder"):
        main(arguments)
    assert sorted(path.name for path in folder.iterdir()) == sorted(SCENES)


@pytest.mark.parametrize("page", [".", "scene.toml/page.md"])
def test_a_page_that_cannot_be_written_leaves_no_folder_of_results(page, folder):
    (folder / "scene.toml").write_text(DEFAULT_SCENE)
    before = sorted(folder.rglob("*"))
    with pytest.raises(SceneError, match="^--page .*(a folder, not a file|cannot be written)"):
        importlib.import_module("simulations.studies.maps").main(["--page", page])
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("stream", ["/dev/full", "closed pipe"])
def test_nobody_listens(stream, tmp_path):
    """Where standard output cannot take any more the run goes on and its files are whole."""
    if stream == "closed pipe":
        read, write = os.pipe()
        os.close(read)
    else:
        write = os.open(stream, os.O_WRONLY)
    run = start_python("-m", "simulations.fretting", *coarse_arguments(tmp_path / "run"), stdout=write, stderr=PIPE)
    _, said = run.communicate(timeout=120)
    os.close(write)
    assert run.returncode == 0, said
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["converged"]


def test_nobody_listens_to_the_list_of_commands():
    """As at the end of ``| head -1``."""
    read, write = os.pipe()
    os.close(read)
    run = start_python("-m", "simulations", stdout=write, stderr=PIPE, text=True)
    os.close(write)
    assert (run.communicate(timeout=60)[1], run.returncode) == ("", 0)


def test_no_standard_stream_is_there(tmp_path):
    """As some batch systems start a command: all three are closed, and the first files would get their numbers."""
    words = python("-m", "simulations.fretting", *coarse_arguments(tmp_path / "run"))
    shell = ["/bin/sh", "-c", '"$@" <&- >&- 2>&-', "sh"]
    done = subprocess.run([*shell, *words], env=environment(), cwd=ROOT, timeout=120)
    assert done.returncode == 0
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["converged"]
