"""Documents that say what the code does are checked against it."""

import json
import re

import pytest
from conftest import ROOT, coarse_arguments

from forms import contact, elasticity
from simulations import fretting
from simulations.scene.scene import language


def rows(path, columns):
    """Rows of the tables of a document that have so many columns, without their heads."""
    lines = (line for line in (ROOT / path).read_text().splitlines() if line.startswith("| `"))
    cells = ([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines)
    return [row for row in cells if len(row) == columns]


def test_every_key_is_documented_as_it_is():
    documented = {row[0].strip("`"): row for row in rows("docs/scene.md", 5)}
    keys = language()
    assert list(documented) == list(keys)
    for name, key in keys.items():
        _, unit, allowed, default, meaning = documented[name]
        assert allowed == key.allowed, name
        assert default == ("" if key.default is None else f"`{json.dumps(key.default)}`"), name
        assert meaning, name


@pytest.mark.parametrize("changes", [{}, {"solid__nu": 0.3}], ids=["closed form", "coupled"])
def test_the_schema_of_the_summary(changes, tmp_path):
    """summary.json has the documented keys: all that must be there, and no other."""
    fretting.main([*coarse_arguments(tmp_path, **changes), "--quiet"])
    summary = json.loads((tmp_path / "summary.json").read_text())
    kinds = {"text": str, "integer": int, "true or false": bool, "number": float}
    documented: dict[str, str] = {}
    for names, kind, _ in rows("docs/files.md", 3):
        documented |= {name: kind for name in re.findall(r"`(\w+)`", names)}
    assert set(summary) <= set(documented)
    optional = {name for name in documented if name.startswith("differences")} | {"accuracy"}
    assert set(documented) - set(summary) <= optional
    for name, value in summary.items():
        kind = documented[name].split(" or null")[0]
        if kind in kinds and value is not None:
            assert isinstance(value, kinds[kind]), name
        elif "→" in kind:
            assert isinstance(value, dict), name


def test_the_forms_named_are_there():
    text = (ROOT / "docs" / "method.md").read_text()
    for line in re.findall(r" {3}\(([a-z_]+(?:, [a-z_]+)*)\)$", text, re.M):
        for name in line.split(", "):
            assert hasattr(contact, name) or hasattr(elasticity, name), name
    for path in re.findall(r"`((?:forms|simulations|analytic)/\w+\.py)`", text):
        assert (ROOT / path).exists(), path


def test_links_lead_somewhere():
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
            assert (page.parent / target).exists(), (page.name, target)
