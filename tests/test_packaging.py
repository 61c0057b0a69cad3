"""What an installed package holds, its one command, and its metadata."""

import json
import re
import shutil
import subprocess
import sys
import tomllib

import pytest
from running import ROOT, run_command

import simulations
from simulations import __main__ as commands

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PACKAGES = ("analytic", "forms", "simulations")


def python(code, cwd):
    return subprocess.run(
        [sys.executable, "-c", code], cwd=cwd, env={"PATH": "/usr/bin"}, capture_output=True, text=True, timeout=120
    )


def test_what_is_installed_holds_every_file(tmp_path):
    """setuptools packs what ``build_py`` lays out: all modules and data files, and those suffice away from the tree."""
    tree = tmp_path / "tree"
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tree)
    done = python("import setuptools, sys; sys.argv[1:] = 'build_py', '-d', '../built'; setuptools.setup()", tree)
    assert done.returncode == 0, done.stderr
    built = tmp_path / "built"
    expected = {path.relative_to(tree) for name in PACKAGES for path in (tree / name).rglob("*") if path.is_file()}
    assert {path.relative_to(built) for path in built.rglob("*") if path.is_file()} == expected
    done = python("import simulations.scene.accuracy; print(simulations.__file__)", built)
    assert done.returncode == 0 and done.stdout.startswith(str(built)), done.stderr


def test_closed_forms_need_no_fenics(tmp_path):
    """The numbers of README from a process in which nothing of FEniCSx, nor the other rooms, can be imported."""
    names = [*commands.STACK, "forms", "simulations", "sympy", "pydantic", "matplotlib", "h5py"]
    code = f"""
import sys
sys.modules.update(dict.fromkeys({names}))
sys.path.insert(0, {str(ROOT)!r})
from analytic import CylinderContact, FrettingLoop, GradedHalfPlane
solid = GradedHalfPlane(E0=210e9, k=0.3, nu=1/2.3, y0=0.007012069662746237)
contact = CylinderContact(solid, R=0.1, P=1e6)
print(contact.a, FrettingLoop.from_load(contact, mu=0.3, Q_A=0.9 * 0.3e6).dissipated_energy)
"""
    done = python(code, tmp_path)
    assert done.returncode == 0, done.stderr
    a, energy = map(float, done.stdout.split())
    assert a == pytest.approx(0.0010442545, rel=1e-7) and energy == pytest.approx(0.3736713, rel=1e-6)


def test_the_command_is_that_of_the_module():
    """``graded-fretting fretting`` on two ranks refuses what ``python -m simulations.fretting`` refuses."""
    module, _, function = PROJECT["scripts"]["graded-fretting"].partition(":")
    assert module == commands.__name__ and callable(getattr(commands, function))
    done = run_command("fretting", "--set", "solid.k=2", ranks=2, module="simulations")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "solid.k = 2" in done.stderr
    done = run_command("reprot", "x", module="simulations")
    assert (done.returncode, done.stderr) == (2, "command 'reprot' is not known: did you mean report?\n")


def test_every_command_is_listed():
    folder, runs = ROOT / "simulations", 'if __name__ == "__main__"'
    modules = {path.stem for path in folder.glob("*.py") if runs in path.read_text()} - {"__main__"}
    modules |= {f"studies.{path.stem}" for path in (folder / "studies").glob("*.py") if runs in path.read_text()}
    assert {module for module, _, _ in commands.COMMANDS.values()} == modules


def test_metadata_agree():
    """Licence, authors and version are the same wherever they stand."""
    authors, version = "the graded-fretting developers", simulations.__version__
    meta = json.loads((ROOT / "codemeta.json").read_text())
    assert PROJECT["license"] == "MIT" and meta["license"] == "https://spdx.org/licenses/MIT"
    assert [author["name"] for author in PROJECT["authors"]] == [authors] == [meta["author"]["name"]]
    assert meta["version"] == version and meta["name"] == PROJECT["name"]
    assert meta["description"] == PROJECT["description"]
    assert f'name: "{authors}"' in (ROOT / "CITATION.cff").read_text()
    assert f"Copyright (c) 2026 {authors}" in (ROOT / "LICENSE").read_text()


def test_the_paper_cites_what_its_list_has():
    text, references = ((ROOT / name).read_text() for name in ("paper.md", "paper.bib"))
    assert set(re.findall(r"@(\w+)", text)) == set(re.findall(r"^@\w+\{(\w+),", references, re.M))
