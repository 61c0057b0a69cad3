"""The map of what coupling changes: known changes, none at the Holl ratio, a table that goes on where it ended."""

import pytest
from running import csv_rows

from simulations.studies import coupling as coupling_map
from simulations.studies.coupling import COLUMNS, changes


def test_known_changes():
    """7.3 % in p, 8.5 % in q, -5.4 % in energy at k = 0.3, nu = 0.3, as finite elements have them."""
    values = changes(0.3, 0.3, 0.3)
    assert values["pressure"] == pytest.approx(0.073, abs=1e-3)
    assert values["traction"] == pytest.approx(0.085, abs=1e-3)
    assert values["energy"] == pytest.approx(-0.054, abs=1e-3)


def test_no_change_at_the_holl_ratio():
    assert all(abs(value) < 1e-6 for value in changes(0.5, 0.4, 0.6).values())


def test_table_is_resumed_and_drawn(tmp_path, monkeypatch):
    """A store that lacks one loop: only that one is computed."""
    computed = []

    def quick(*point):
        computed.append(point)
        return dict.fromkeys(coupling_map.SHOWN, 0.01 * (1 + point[0]) * (0.6 - point[1]))

    monkeypatch.setattr(coupling_map, "changes", quick)
    arguments = ["--output", str(tmp_path), "--values", "4", "3"]
    coupling_map.main(arguments)
    table = tmp_path / "coupling.csv"
    rows, store = table.read_text().splitlines(), tmp_path / "loops.jsonl"
    assert len(computed) == len(rows) - 1 == 36 and rows[0] == ",".join(COLUMNS)
    store.write_text("".join(store.read_text().splitlines(True)[:-1]))
    coupling_map.main(arguments)
    assert len(computed) == 37 and computed[-1] == computed[-2] == pytest.approx((0.7, 0.5, 0.6))
    assert len(csv_rows(table)) == 36
    assert all((tmp_path / f"coupling.{suffix}").stat().st_size > 1e4 for suffix in ("png", "svg"))


@pytest.mark.parametrize("known", [0.3, 0.0], ids=["one column failed", "one column is left"])
def test_a_ratio_at_which_every_loop_failed_is_left_out(tmp_path, monkeypatch, known):
    def quick(k, nu, mu):
        if nu > known:
            raise ArithmeticError("no state")
        return dict.fromkeys(coupling_map.SHOWN, 0.01 * (1 + k))

    monkeypatch.setattr(coupling_map, "changes", quick)
    coupling_map.main(["--output", str(tmp_path), "--values", "2", "3"])
    rows = csv_rows(tmp_path / "coupling.csv")
    assert {row["pressure"] == "nan" for row in rows if float(row["nu"]) > known} == {True}
    assert (tmp_path / "coupling.png").stat().st_size > 1e4
