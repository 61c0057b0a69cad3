"""The study of cost: what it keeps of an older table, and what it calibrates."""

import pytest
from running import ROOT

from simulations.scene import accuracy
from simulations.studies import cost
from simulations.studies.store import Store


def test_only_what_was_measured_is_calibrated(tmp_path, monkeypatch):
    """Rows of an older table, which the study takes over, leave their lines as they are."""
    before, table = accuracy.TABLE.read_text(), tmp_path / "accuracy.csv"
    rows = (ROOT / "docs/cost/cost.csv").read_text().splitlines(keepends=True)
    (tmp_path / "cost.csv").write_text("".join(row for row in rows if ",k=0.7,8," not in row))
    monkeypatch.setattr(accuracy, "TABLE", table)
    monkeypatch.setattr("simulations.studies.costs.plots.draw", lambda *_: [])
    monkeypatch.setattr(cost, "measured_apart", lambda values: {"largest": 0.5, "largest_of_states": 0.6, "cpu_s": 7.0})
    cost.main(["--output", str(tmp_path), "--only", "/k=0.7/8", "--calibrate"])
    new = [line for line in table.read_text().splitlines() if line not in before.splitlines()]
    assert new == ["0,0.7,8,6.00e-01,5.00e-01,7.00"]
    assert len(table.read_text()) == len(before)


def test_a_table_is_taken_over_whole_or_not_at_all(tmp_path, monkeypatch):
    """Else the next call would take the rows kept before a stop for all, and write the table without the others."""
    path, store, keep, kept = ROOT / "docs/cost/cost.csv", Store(tmp_path / "cost.jsonl"), Store.keep, []

    def stopped(self, *row):
        kept.append(row)
        if len(kept) == 3:
            raise KeyboardInterrupt
        keep(self, *row)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Store, "keep", stopped)
        cost.adopt(path, store)
    cost.adopt(path, store)
    assert len(store.read()) == len(cost.read_rows(path)) > 300
