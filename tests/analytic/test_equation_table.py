"""The table of equations lists every equation, and the functions and tests that it names exist."""

import re
from pathlib import Path

import pytest

import analytic

HERE = Path(__file__).parent
TABLE = (HERE.parents[1] / "docs" / "equations.md").read_text(encoding="utf-8")
ROWS = [line.split("|")[1:5] for line in TABLE.splitlines() if re.match(r"\| [(\[]", line)]


def test_every_equation_is_listed():
    """(1)-(59), [X1]-[X7], in order."""
    numbers = []
    for cell in (row[0] for row in ROWS):
        ends = [int(n) for n in re.findall(r"\((\d+)\)", cell)]
        numbers += range(ends[0], ends[-1] + 1) if ends else []
    assert numbers == list(range(1, 60))
    beyond = [row[0].strip() for row in ROWS if "X" in row[0]]
    assert beyond == ["[X1]", "[X2]", "[X3]", "[X4]", "[X5]", "[X6]", "[X7]"]


@pytest.mark.parametrize("row", ROWS, ids=[row[0].strip() for row in ROWS])
def test_names_exist(row):
    """Functions can be imported, or are fields of their class; tests are defined."""
    owner = ""
    for name in re.findall(r"`([\w.]+)`", row[2]):
        owner, _, attribute = (owner + name if name.startswith(".") else name).partition(".")
        holder = getattr(analytic, owner)
        fields = getattr(holder, "__dataclass_fields__", {})
        assert not attribute or attribute in fields or hasattr(holder, attribute)
    tests = "".join(path.read_text(encoding="utf-8") for path in HERE.glob("test_*.py"))
    named = re.findall(r"`(\w+)`", row[3])
    assert named
    for name in named:
        assert f"def {name}(" in tests
