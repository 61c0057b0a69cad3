"""Documents that say what the code does are checked against it."""

import json
import re
from pathlib import Path

import pytest
from running import ROOT, coarse_arguments

from forms import contact, elasticity, weak_form
from simulations import fretting

PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))


def rows(path, columns):
    """Rows of the tables of a document that have so many columns, without their heads."""
    lines = (line for line in (ROOT / path).read_text().splitlines() if line.startswith("| `"))
    cells = ([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines)
    return [row for row in cells if len(row) == columns]


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
    modules = {"contact": contact, "elasticity": elasticity, "weak_form": weak_form}
    named = re.findall(r"`(contact|elasticity|weak_form)\.(\w+)`", text)
    assert len(named) >= 12
    for module, name in named:
        assert hasattr(modules[module], name), name


def test_the_weak_form_has_the_numbers_of_the_document():
    """Each term (F1), (F2) ... stands in both, in the code beside a function that the document names for it."""
    rows = re.findall(r"^\| \((F\d+)\) \| .* \| (.*) \|$", (ROOT / "docs" / "method.md").read_text(), re.M)
    assert [number for number, _ in rows] == [f"F{n}" for n in range(1, 13)]
    code = Path(weak_form.__file__).read_text()
    assert set(re.findall(r"# \((F\d+)\)$", code, re.M)) == {number for number, _ in rows}
    for number, functions in rows:
        where = [m.start() for m in re.finditer(rf"# \({number}\)$", code, re.M)]
        for name in re.findall(r"`\w+\.(\w+)`", functions):
            near = [code[max(0, place - 700) : place] for place in where]
            assert any(name in text for text in near), (number, name)


def anchors(text):
    """Those of the headings of a page."""
    return {re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in re.findall(r"^#+ (.*)$", text, re.M)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    """To a file and a heading of it; and files that are named in the text are there."""
    text = page.read_text()
    for target, anchor in re.findall(r"\]\(([^)#:]*)#?([^):]*)\)", text):
        linked = page.parent / target if target else page
        assert linked.exists() and (not anchor or anchor in anchors(linked.read_text())), (target, anchor)
    for path in re.findall(r"`((?:forms|simulations|analytic|tests|docs|docker|examples|scenes)/[\w/.-]+)`", text):
        assert (ROOT / path).exists(), path


def test_ci_runs_the_tests_as_the_readme_says():
    command = re.search(r"^    (./docker/run pytest.*)$", (ROOT / "README.md").read_text(), re.M)[1]
    assert command in (ROOT / ".ci" / "run").read_text().splitlines()
