"""The pages of README's three readers: every command and every block of Python runs as it stands, on a coarse mesh."""

import re
import runpy
import shlex
import subprocess
import sys

import numpy as np
import pytest
from running import COARSE, ROOT, environment

from analytic import FrettingLoop

PAGES = ("tribologist", "engineer", "reviewer")
MADE = {  # what the commands of a page leave
    "tribologist": ("mine/surface.h5", "mine/report.html", "study/sweep.csv"),
    "engineer": ("run/surface.h5", "full/surface.h5"),
    "reviewer": ("coupled/summary.json",),
}
ELSEWHERE = {  # run by another test
    "simulations.studies.figures": "tests/studies/test_figures.py",
    "examples/tutorial.py": "tests/test_reader_pages.py",
}
SOLVES = ("simulations.fretting", "simulations.sweep")


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", (ROOT / "docs" / f"{page}.md").read_text(), re.M | re.S)


def words(command: str) -> list[str]:
    """A command of a page without ``docker/run``, which is around the tests already; runs get a coarse mesh."""
    start, *found = shlex.split(command)
    assert start == "./docker/run", command
    place = found.index("python")
    found[place] = sys.executable
    if found[place + 1] == "-m":
        keys = COARSE | {"reference.kind": "none"}  # references are tested elsewhere
        sets = [
            word for key, value in keys.items() if f"{key}={value}" not in found for word in ("--set", f"{key}={value}")
        ]
        return found + (sets if found[place + 2] in SOLVES else [])
    return found


def test_readme_leads_each_reader_to_a_page():
    first_lines = (ROOT / "README.md").read_text().partition("\n## ")[0]
    assert re.findall(r"\]\(docs/(\w+)\.md\)", first_lines) == list(PAGES)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_every_command_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for scene in blocks(page, "toml"):
        (tmp_path / "mine.toml").write_text(scene)
    for command in "".join(blocks(page, "sh")).splitlines():
        if elsewhere := [test for name, test in ELSEWHERE.items() if f" {name} " in f"{command} "]:
            assert (ROOT / elsewhere[0]).exists()
            continue
        done = subprocess.run(
            words(command), cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, (command, done.stderr)
    assert all((tmp_path / name).stat().st_size > 100 for name in MADE[page])
    for code in blocks(page, "python"):
        exec(compile(code, page, "exec"), {})


@pytest.mark.slow
def test_the_four_lines_of_the_readme():
    """As they stand, on the default mesh."""
    section = (ROOT / "README.md").read_text().partition("## Four lines of Python\n")[2].partition("\n## ")[0]
    lines = re.findall(r"^    (.*)$", section, re.M)
    assert len(lines) == 4
    names: dict = {}
    exec(compile("\n".join(lines), "README.md", "exec"), names)
    assert max(map(abs, names["result"].errors().values())) < 1e-3


@pytest.mark.slow
def test_the_tutorial(tmp_path, monkeypatch):
    """Its own numbers: the integral of 4 q h_x is the work of friction, and energies are those of the closed form."""
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(ROOT / "examples" / "tutorial.py"))
    result, contact = names["result"], names["scene"].contact
    exact = FrettingLoop.from_load(contact, mu=0.3, Q_A=0.8 * 0.3e6)
    assert names["energy"] == pytest.approx(result.dissipated_energy, rel=3e-4)
    assert names["energy"] == pytest.approx(exact.dissipated_energy, rel=3e-4)
    peak = np.argmax(names["w"])
    assert names["w"][peak] == pytest.approx(exact.energy_density(result.x[peak]), rel=5e-3)
    assert [state.label[:7] for state in names["states"]][:2] == ["pressed", "A, init"] and len(names["states"]) == 7
    assert [row["status"] for row in names["table"]] == ["done"] * 4
    assert max(abs(row["error_dissipated_energy"]) for row in names["table"]) < 1e-3
    assert names["held"].dissipated_energy < 0.8 * result.dissipated_energy
    made = {path.name for path in (tmp_path / "results" / "tutorial").iterdir()}
    assert {"surface.png", "energy.png", "body.png", "sweep.csv", "mine"} <= made
