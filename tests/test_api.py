"""The package from Python, as docs/library.md has it."""

import re
import runpy
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpi4py import MPI
from running import COARSE, ROOT, run_python

import simulations
from simulations import ChecksWarning, SceneError, make_scene, parse, run, sweep
from simulations.runs.comparison import compare_all
from simulations.runs.reference import closed_form
from simulations.runs.report_data import quantities
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
    assert {type(error) for error in result.errors().values()} == {float}  # numbers of numpy print their type
    assert list(tmp_path.iterdir()) == []


def test_threads_run_one_after_the_other():
    """Side by side they end in a crash of gmsh or PETSc."""
    shares, steps = [0.5, 0.7], []

    def stick(share):
        return run(QUICK | {"load.amplitude": share}, progress=lambda entry: steps.append(share)).c

    with ThreadPoolExecutor(2) as threads:
        found = [*threads.map(stick, shares)]
    assert steps == sorted(steps, key=steps.index) and found == [stick(share) for share in shares]


def test_without_friction_there_is_no_stick_zone():
    result = run(QUICK | dict.fromkeys(("load.mu", "load.amplitude", "load.cycles")))
    assert np.isnan(result.c) and result.a > 0
    assert result.traction.shape == result.slip.shape == (1, result.x.size)
    assert not result.traction.any() and not result.slip.any() and result.dissipated_energy == 0


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


PLAIN = """
import logging, warnings
from pathlib import Path
{before}
from simulations import run
warnings.warn("the user's own")
run({changes!r}, base=Path("scenes/path.toml"))
"""


@pytest.mark.parametrize("before", ["", "import dolfinx", "logging.basicConfig(); logging.captureWarnings(True)"])
def test_a_plain_script_shows_warnings(before):
    """Though ffcx has them logged; what the user set up for logs is kept."""
    coarse = {"mesh.facet": 0.1, "mesh.edge_facet": 0.02, "mesh.first_layer": 0.02, "reference.kind": "none"}
    done = run_python("-c", PLAIN.format(before=before, changes=coarse))
    assert done.returncode == 0 and "the user's own" in done.stderr
    assert "ChecksWarning: checks that fail: traction zigzags" in done.stderr
    assert ("WARNING:py.warnings" in done.stderr) == ("captureWarnings" in before)


def test_the_energy_of_a_path_is_checked_beside_its_closed_form():
    """Little slips here while P changes much: four load steps a part leave 23 % on any mesh, and p and q are right."""
    P, Q = [392448.38, 392448.38, 713586.39, 273740.63, 531714.73], [0, -41923.25, -21370.01, -28711.38, 1975.89]
    solid = {"solid.k": None, "solid.y0_over_a0": None, "solid.modulus": "homogeneous", "solid.nu": 0.3}
    load = {"load.P": None, "load.amplitude": None, "load.cycles": None, "load.points": list(zip(P, Q))}
    changes = COARSE | solid | load | {"effects.coupling": False, "solver.increments": 4}
    with pytest.warns(ChecksWarning, match="error of dissipated_energy .*more solver.increments"):
        result = run(changes)
    failing = {name: check.value for name, check in result.checks.items() if not check.holds}
    assert failing == {"error of dissipated_energy": pytest.approx(0.23, abs=0.02)}
    a_over_a0 = quantities(result.simulation)["a_over_a0"]  # under the last P, which is not the largest
    assert a_over_a0 == pytest.approx(1.0, abs=0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ChecksWarning)
        assert "error of a" not in run(changes | {"reference.kind": "none"}).checks


def test_no_slip_to_compare_with_is_no_warning_of_numpy(monkeypatch):
    """There is no relative deviation from a slip that is 0 in every state."""
    simulation = run(COARSE | {"load.cycles": 0}).simulation
    exact = closed_form(simulation)
    monkeypatch.setattr(exact, "slip", lambda entry, x: np.zeros_like(x))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = compare_all(simulation.history, exact).worst
    assert np.isnan(found["slip_l2"]) and found["pressure_l2"] < 1e-2


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
    with pytest.raises(SceneError, match="solid.foo = None is not a key"):
        make_scene({"solid.foo": None})
    with pytest.raises(SceneError, match="solid.E0 is missing"):
        make_scene({}, base=None)


def test_a_scene_may_be_a_file(tmp_path):
    (tmp_path / "mine.toml").write_text(make_scene({"solid.k": 0.5}).to_toml())
    assert make_scene(base=tmp_path / "mine.toml").solid.k == 0.5
    with pytest.raises(SceneError, match="scene nowhere.toml cannot be read"):
        make_scene(base=Path("nowhere.toml"))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda: run("mine.toml"), "changes = 'mine.toml' are not allowed"),
        (lambda: run(make_scene(), base=make_scene()), "base is not allowed beside a Scene"),
        (lambda: run(comm=None), "comm = None is not allowed: an MPI communicator"),
        (lambda: run(comm=MPI.COMM_NULL), "comm = .* is not allowed: an MPI communicator that this process is in"),
        (lambda: make_scene([1, 2]), "changes = .1, 2. are not allowed"),
        (lambda: make_scene({}, base="mine.toml"), "base = 'mine.toml' is not allowed: TOML text, a pathlib.Path"),
        (lambda: make_scene({}, base=3), "base = 3 is not allowed"),
        (lambda: sweep("mine.toml", {"load.mu": [0.3]}), "scene = 'mine.toml' is not allowed: TOML text"),
        (lambda: sweep(Path("nowhere.toml"), {"load.mu": [0.3]}), "scene nowhere.toml cannot be read"),
        (lambda: sweep(vary={"load.mu": 0.3}), "load.mu = 0.3 is not allowed: a list"),
        (lambda: sweep(vary={"load.mu": "0.1,0.2"}), "load.mu = '0.1,0.2' is not allowed: a list"),
        (lambda: sweep(vary=None), "vary = None is not allowed: lists of values by key, or a list of dictionaries"),
        (lambda: sweep(vary="load.mu=0.2,0.3"), "vary = 'load.mu=0.2,0.3' is not allowed: lists of values by key"),
        (lambda: sweep(vary=[["load.mu", 1]]), "vary = .*'load.mu', 1.* is not allowed: lists of values by key"),
        (lambda: sweep(vary={"load.mu": [0.3]}, sets="load.P=1e6"), "sets = 'load.P=1e6' is not allowed: a list of"),
        (lambda: sweep(vary={"load.mu": [0.3]}, sets=[3]), "sets = .3. is not allowed: a list of KEY=VALUE"),
        (lambda: sweep(vary={"load.mu": [0.3]}, output=3), "output = 3 is not allowed: the name of a folder"),
    ],
)
def test_values_of_the_wrong_kind_are_named(wrong, said):
    with pytest.raises(SceneError, match=said):
        wrong()


@settings(max_examples=50)
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
    scenes = [make_scene(example["COMMON"] | keys | {"solid.k": 0.3}) for keys in example["PROFILES"].values()]
    assert len({scene.solid for scene in scenes}) == 1, "profiles on different solids are not compared"
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
    names: dict = {}
    exec(compile(code, "docs/library.md", "exec"), names)
    assert np.all(np.diff(names["energies"]) > 0)
