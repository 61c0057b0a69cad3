"""The study of the reference of coupled loops."""

import pytest

from simulations.scene import SceneError
from simulations.studies import coupled_loops
from simulations.studies.coupled_loops import DIFFERENCES, ERRORS
from simulations.studies.store import Store


def test_cases():
    assert len(coupled_loops.cases(["reference"])) == 9 * 4 * 4 * 3
    assert len(coupled_loops.cases(["elements"])) == 18


def test_one_loop_and_one_that_is_not_solved(monkeypatch):
    """Two orders are close and not the same; points that come into contact in stick are said."""
    monkeypatch.setattr(coupled_loops, "ORDER", 8)
    monkeypatch.setattr(coupled_loops, "WAY", (1.0, -1.0, 1.0))
    loop = {"kind": "reference", "k": 0.5, "nu": 0.2, "mu": 0.3, "share": 0.6}
    row = coupled_loops.solve(loop)
    assert all(0 < row[name] < 1e-3 for name in DIFFERENCES)
    assert row["seconds"] > 0
    assert "into contact in stick" in coupled_loops.solve(loop | {"k": -0.5, "nu": 0.0, "mu": 1.0, "share": 0.3})["why"]


def test_stored_runs_are_those_of_the_kinds_asked_for(tmp_path):
    words = ["--output", str(tmp_path)]
    item = coupled_loops.read(words)[1][0]
    Store(tmp_path / coupled_loops.KEPT).keep(item.key, item.values, {})
    assert coupled_loops.read([*words, "--stored"])[1] == [item]
    with pytest.raises(SceneError, match="holds nothing that is solved"):
        coupled_loops.read([*words, "--stored", "--only", "elements"])


def test_table():
    """A row a k: loops solved, largest differences, largest errors of finite elements."""
    values = [{"kind": kind, "k": 0.3} for kind in ("reference", "reference", "reference", "elements")]
    numbers = dict.fromkeys(DIFFERENCES, 1e-8)
    rows = [numbers | {"seconds": 1.0}, numbers | {"seconds": 1.0, "energy": 2e-7}, {"why": "not solved"}]
    lines = coupled_loops.table(values, [*rows, dict.fromkeys(ERRORS, 1e-3) | {"seconds": 9.0}]).splitlines()
    assert len(lines) == 2 + len(coupled_loops.K)
    line = next(line for line in lines if line.startswith("| 0.3 "))
    assert line == "| 0.3 | 2 of 3 | 1.0e-08 | 1.0e-08 | 1.0e-08 | 2.0e-07 | 1.0e-03 | 1.0e-03 | 1.0e-03 | 1.0e-03 |"
