"""The study of coupled loops."""

import pytest

from simulations.scene import SceneError
from simulations.studies import coupled_loops
from simulations.studies.coupled_loops import ERRORS, GRID, MESH_FREE, OWN, SECONDS
from simulations.studies.store import Store

COARSE = {"mesh.edge_facet": 0.02, "mesh.facet": 0.1, "solver.increments": 2}


def loop(*values):
    """Scene keys of a loop on a coarse mesh: mu, Q_A/(mu P), nu, k."""
    return dict(zip(GRID, values)) | COARSE


def test_cases():
    cases = coupled_loops.cases()
    assert len(cases) == 9 * 4 * 4 * 3
    assert cases[0] == {"load.mu": 0.3, "load.amplitude": 0.6, "solid.nu": 0.0, "solid.k": -0.9}


def test_one_loop():
    """Two orders are close and not the same; the reference is better than the finite elements."""
    row = coupled_loops.solve(loop(0.3, 0.6, 0.2, 0.5))
    assert all(0 < row[mine] < 1e-4 and row[mine] < row[name] < 0.1 for mine, name in zip(OWN, ERRORS))
    assert row["mesh_free_states"] == 0 and not row["mesh_free_energy"]
    assert all(row[name] > 0 for name in SECONDS)
    assert row["fails"] == ""


def test_one_loop_with_states_of_the_mesh_free_solver():
    """Points come into contact in stick after a turn."""
    row = coupled_loops.solve(loop(0.3, 0.6, 0.0, -0.3))
    assert row["mesh_free_states"] > 0
    assert all(0 < row[name] < 0.3 for name in ERRORS + OWN)


def test_at_the_holl_ratio_the_closed_form_is_exact():
    row = coupled_loops.solve(loop(0.3, 0.6, 0.4, 0.5))
    assert not any(row[name] for name in (*OWN, *MESH_FREE))
    assert all(0 < row[name] < 0.1 for name in ERRORS)


def test_one_loop_that_is_not_solved():
    assert "load.amplitude" in coupled_loops.solve(loop(0.3, 1.0, 0.2, 0.5))["why"]


def test_stored_loops(tmp_path):
    words = ["--output", str(tmp_path)]
    with pytest.raises(SceneError, match="holds nothing that is solved"):
        coupled_loops.read([*words, "--stored"])
    item = coupled_loops.read(words)[1][0]
    Store(tmp_path / coupled_loops.KEPT).keep(item.key, item.values, {})
    assert coupled_loops.read([*words, "--stored"])[1] == [item]


def test_table():
    """A row a k in two tables: how many loops, largest errors and the reference's own, seconds in the middle."""
    row = dict.fromkeys(ERRORS, 1e-3) | dict.fromkeys(OWN, 1e-8) | dict.fromkeys(SECONDS, 1.0)
    row |= {"mesh_free_states": 0, "mesh_free_energy": False}
    rows = [row, row | {"pressure_l2": 2e-3}, row | {"mesh_free_states": 1}, {"why": "not solved"}]
    lines = coupled_loops.table([{"solid.k": 0.3}] * len(rows), rows).splitlines()
    first, second = (line for line in lines if line.startswith("| 0.3 "))
    assert first.startswith("| 0.3 | 2 of 4 | 2.0e-03 | 1.0e-03 |") and first.endswith("| 1.0e-08 | 1.0 | 1.0 |")
    assert second.startswith("| 0.3 | 1 of 4 | 1.0e-03 |")
