"""What a loop costs, counted: factorisations of the bulk, inverses and products of the dense step. Seconds are in
docs/cost.md, and what the study writes of them.
"""

import numpy as np
import pytest
from running import ROOT
from solving import coarse_simulation, solved

from simulations.fem.mesh import Grading
from simulations.scene import accuracy
from simulations.solvers.condensed import schur
from simulations.solvers.condensed.mirror import parts
from simulations.solvers.condensed.tangent import DenseTangent
from simulations.studies import cost
from simulations.studies.store import Store


def factorisations(work):
    before = schur.factorisations
    result = work()
    return schur.factorisations - before, result


def test_a_loop_factorises_each_half_once():
    count, simulation = factorisations(lambda: solved(solver__increments=10))
    assert len(simulation.history.entries) == 51
    assert count == 2
    halves = parts(simulation.body)
    assert [half.is_half for half in halves] == [True, True]
    assert sum(len(half.dofs) for half in halves) == simulation.body.unknowns


def test_a_mesh_without_mirror_is_solved_whole():
    """The same loop on a mesh whose left half is another than its right: no halves, nearly the same numbers."""
    grading = coarse_simulation().cells
    lopsided = Grading(
        tuple(e if e > 0 else 1.03 * e for e in grading.edges),
        grading.facet,
        grading.edge_facet,
        grading.growth,
        grading.first_layer,
        grading.layer_growth,
        grading.extent,
    )
    count, simulation = factorisations(lambda: solved(cells=lopsided))
    assert count == 1
    assert [half.is_half for half in parts(simulation.body)] == [False]
    energy = solved().history.dissipated_energy
    assert simulation.history.dissipated_energy == pytest.approx(energy, rel=2e-2)


@pytest.mark.parametrize("k", [0.3, -0.5])
def test_compliance_solves_the_whole_body(k):
    """A force on one side and its displacement, recovered in the whole body, leave no residual in the stiffness."""
    simulation = coarse_simulation(solid__k=k, solid__nu=0.3)
    body, compliance = simulation.body, simulation._compliance
    matrix = compliance.matrix((0, 1))
    forces = np.zeros(2 * compliance.n)
    forces[[3, compliance.n + 5]] = 1.0, -2.0
    compliance.body.set_far_field((0.0, 0.0))
    compliance.put(matrix.apply(forces))
    compliance.recover()
    residual = body.stiffness.createVecLeft()
    body.stiffness.mult(body.state.x.petsc_vec, residual)
    residual.array[body.fixed_dofs] = 0.0
    residual.array[compliance._surface_dofs.T.ravel()] -= forces
    assert np.abs(residual.array).max() < 1e-9 * 2.0


def test_dense_steps_reuse_what_they_know(monkeypatch):
    """One inverse serves a stage; only rows that neither opened nor slid are multiplied with the compliance
    matrix again, and those of a node that sticks are kept.
    """

    def further_products():
        simulation = solved(solver__increments=6, solid__nu=0.3)  # with coupling, where edges move
        counts = simulation.solver._newton.system.dense.counts
        iterations = sum(entry.iterations for entry in simulation.history.entries)
        rows = 2 * simulation.sampler.x.size
        assert counts.inverses == 1
        assert counts.rows < 0.5 * iterations * rows
        return counts.products - rows

    kept = further_products()
    monkeypatch.setattr(DenseTangent, "_known_rows", DenseTangent._full_rows)
    assert kept < 0.1 * further_products()


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
