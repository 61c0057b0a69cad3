"""The package from Python, as docs/library.md has it."""

import re
import runpy
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from running import COARSE, ROOT

import simulations
from simulations import ChecksWarning, SceneError, make_scene, parse, run
from simulations.scene import SceneError as OneError

QUICK = COARSE | {"load.cycles": 0}


def test_everything_that_is_exported_exists():
    for name in simulations.__all__:
        assert getattr(simulations, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        simulations.nothing
    assert SceneError is OneError


def test_a_run_gives_arrays_and_leaves_no_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    seen = []
    result = run(QUICK, progress=seen.append)
    s, n = len(seen), result.x.size
    assert result.pressure.shape == result.traction.shape == result.slip.shape == (s, n)
    assert result.pressure @ result.weight == pytest.approx(result.P, rel=1e-8)
    assert result.traction @ result.weight == pytest.approx(result.Q, abs=1e-8 * result.P.max())
    assert result.P[-1] == pytest.approx(1e6)
    assert result.delta.shape == (s, 2)
    assert result.a == pytest.approx(0.00104425, rel=1e-3) and 0 < result.c < result.a
    assert abs(result.errors()["pressure_l2"]) < 1e-2
    assert list(tmp_path.iterdir()) == []


def test_without_friction_there_is_no_stick_zone():
    result = run(QUICK | dict.fromkeys(("load.mu", "load.amplitude", "load.cycles")))
    assert np.isnan(result.c) and result.a > 0
    assert result.traction.shape == result.slip.shape == (1, result.x.size)
    assert not result.traction.any() and not result.slip.any() and result.dissipated_energy == 0


def test_run_stays_a_function_whatever_was_imported_before():
    from simulations import Simulation, run

    assert Simulation and len(run(QUICK).x) > 10


def test_checks_that_fail_are_a_warning(monkeypatch):
    assert all(check.holds for check in run(QUICK).checks.values())
    monkeypatch.setattr("simulations.runs.checks.PENETRATION", -1.0)
    with pytest.warns(ChecksWarning, match="checks that fail: gap >= 0"):
        result = run(QUICK)
    assert not result.checks["gap >= 0"].holds
    with warnings.catch_warnings():
        warnings.simplefilter("error", ChecksWarning)
        with pytest.raises(ChecksWarning):
            run(QUICK)


def test_scenes_are_made_of_keys_or_tables():
    one = make_scene({"solid.k": 0.5, "load": {"amplitude": 0.6}})
    assert one.solid.k == 0.5 and one.load.amplitude == 0.6
    assert make_scene(base=one) == one
    assert make_scene({"solid.y0": 0.5}, one).solid.y0 == 0.5
    assert make_scene({"solid.nu": 0.3}, parse(one.to_toml())).solid.nu == 0.3
    without = make_scene({"load.mu": None, "load.amplitude": None, "load.cycles": None})
    assert without.effects.friction is False
    with pytest.raises(SceneError, match="did you mean solid.k"):
        make_scene({"solid": {"K": 0.5}})
    with pytest.raises(SceneError, match="solid.E0 is missing"):
        make_scene({}, base=None)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.dictionaries(st.text(max_size=5), st.one_of(st.none(), st.floats(), st.text(max_size=3)), max_size=3))
def test_nothing_but_scene_errors(changes):
    try:
        make_scene(changes)
    except SceneError as error:
        assert "\n" not in str(error)


@pytest.mark.slow
def test_the_example(tmp_path, capsys, monkeypatch):
    """A flatter profile makes the contact wider; a hyperbolic cosine is a parabola near its tip."""
    example = runpy.run_path(str(ROOT / "examples" / "profiles.py"))
    example["main"](str(tmp_path / "picture.png"))
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    lines = capsys.readouterr().out.splitlines()
    row = re.compile(r"(\S+) +(k = \S+) +a = ([\d.]+) mm")
    width = {(profile, grading): float(a) for profile, grading, a in map(lambda line: row.match(line).groups(), lines)}
    assert len(width) == 6 and width["x^4", "k = 0"] > 3 * width["parabola", "k = 0"]
    # cosh is a parabola as long as the contact is small beside R
    assert width["cosh", "k = 0.3"] == pytest.approx(width["parabola", "k = 0.3"], rel=1e-3)


def test_the_documented_lines_run(tmp_path, monkeypatch):
    """The Python blocks of docs/library.md, one after the other, on a coarse mesh."""
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "library.md").read_text()
    code = "\n".join(re.findall(r"^```python\n(.*?)^```", text, re.M | re.S))
    names = {"QUICK": {name: value for name, value in COARSE.items()}}
    exec(compile(code, "docs/library.md", "exec"), names)
    assert np.all(np.diff(names["energies"]) > 0)
