"""Wrong input: one line that names key, value and what is allowed; exit code 2; nothing written."""

import pytest
from conftest import run_command

from simulations.language import SceneError
from simulations.scene import DEFAULT_SCENE, parse

WRONG = {
    "misspelt key": (("--set", "load.amplitud=0.5"), ("load.amplitud", "did you mean load.amplitude?")),
    "k": (("--set", "solid.k=1.2"), ("solid.k = 1.2", "]-1, 1[")),
    "nu": (("--set", "solid.nu=0.6"), ("solid.nu = 0.6", "]-1, 0.5]")),
    "negative P": (("--set", "load.P=-1e6"), ("load.P = -1000000.0", "]0, inf[")),
    "amplitude": (("--set", "load.amplitude=1.0"), ("load.amplitude = 1.0", "[1e-06, 1[")),
    "not a number": (("--set", "load.mu=high"), ("load.mu = 'high'", "a number")),
    "nan": (("--set", "indenter.R=nan"), ("indenter.R = nan", "a number")),
    "no Holl ratio": (("--set", "solid.k=-0.3"), ('"holl"', "k = -0.3")),
    "--set without value": (("--set", "load.mu"), ("KEY=VALUE",)),
    "unknown option": (("--ouput", "x"), ("--ouput",)),
    "theta": (("--set", "solver.theta=1", "--set", "solver.method=condensed"), ("solver.theta", "full")),
    "huge integer": (("--set", "load.P=1" + "0" * 400), ("load.P", "a number")),
    "friction off, but mu": (("--set", "effects.friction=false"), ("load.mu", "beside effects.friction = false")),
    "overflow": (("--set", "load.P=1e300", "--set", "solid.E0=1e-300"), ("do not fit together",)),
    "table for a number": (("--set", "solid.k={a=1}"), ("solid.k", "a number")),
    "missing scene": (("absent.toml",), ("absent.toml", "No such file")),
}


@pytest.mark.parametrize("arguments, words", WRONG.values(), ids=WRONG.keys())
def test_one_line_and_nothing_written(tmp_path, arguments, words):
    check(tmp_path, arguments, words, ranks=1)


@pytest.mark.parametrize("ranks", [2, 3])
@pytest.mark.parametrize("name", ["misspelt key", "k", "missing scene"])
def test_on_several_ranks(tmp_path, name, ranks):
    check(tmp_path, *WRONG[name], ranks=ranks)


def check(folder, arguments, words, ranks):
    done = run_command(*arguments, ranks=ranks, cwd=folder, timeout=60)
    assert done.returncode == 2
    assert done.stdout == ""
    own = done.stderr.split("-" * 40)[0].strip().splitlines()
    if ranks > 1:  # mpirun has a box of its own above, and lines in brackets on how its ranks ended
        own = [line for line in own if line and not line.startswith("[")]
    assert len(own) == 1, done.stderr
    for word in words:
        assert word in own[0]
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("content", [b"this is no scene", b"\x89PNG\r\n\x1a\n\xff\xfe", b""])
def test_scene_that_is_no_toml(tmp_path, content):
    scene, results = tmp_path / "scene.toml", tmp_path / "results"
    scene.write_bytes(content)
    done = run_command(scene, "--output", results)
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert not results.exists()


@pytest.mark.parametrize("ranks", [1, 3])
def test_output_folder_that_cannot_be_written(tmp_path, ranks):
    (tmp_path / "file").touch()  # root may write anywhere, but not below a file
    done = run_command("--output", tmp_path / "file" / "results", ranks=ranks)
    assert done.returncode == 2
    assert "cannot be written" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    "key", ["solid.E0", "solid.k", "solid.nu", "indenter.R", "load.P", "load.mu", "load.amplitude"]
)
def test_missing_key_is_named(key):
    name = key.partition(".")[2]
    text = "\n".join(line for line in DEFAULT_SCENE.splitlines() if not line.startswith(f"{name} "))
    with pytest.raises(SceneError, match=f"{key} is missing"):
        parse(text)


def test_y0_is_given_once():
    with pytest.raises(SceneError, match="exactly one of"):
        parse(DEFAULT_SCENE.replace("y0_over_a0 = 10.0", "y0_over_a0 = 10.0\ny0 = 1.0"))
