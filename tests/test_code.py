"""The code itself: style, types, one version, and files that belong to a package."""

import ast
import re
import shutil
import subprocess
import sys
import tomllib

import pytest
from running import ROOT

import simulations

FOLDERS = ("analytic", "forms", "simulations", "tests", "examples")


def run(*command):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)


@pytest.mark.slow
@pytest.mark.parametrize("tool, arguments", [("flake8", FOLDERS), ("mypy", ())])
def test_style_and_types(tool, arguments, tmp_path):
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed (docker/versions.txt names it)")
    cache = ("--cache-dir", str(tmp_path)) if tool == "mypy" else ()
    done = run(tool, *cache, *arguments)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_version_is_in_one_place():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert "version" not in project and project["dynamic"] == ["version"]
    version = simulations.__version__
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text()


def test_brackets_of_docstrings_are_no_links():
    """Markdown takes ``[a] [b]`` for a link to b, and `mkdocs build --strict` ends with an error. Code is indented."""
    for path in (path for room in ("analytic", "forms", "simulations") for path in (ROOT / room).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                lines = (ast.get_docstring(node) or "").splitlines()
                assert not [line for line in lines if not line.startswith("    ") and "] [" in line], path


def test_importing_the_package_loads_no_solver():
    """The commands set PETSc up first; a look at the scene language needs none of it."""
    code = "import sys, simulations; assert not {'dolfinx', 'petsc4py', 'numpy'} & set(sys.modules)"
    assert run(sys.executable, "-c", code).returncode == 0
