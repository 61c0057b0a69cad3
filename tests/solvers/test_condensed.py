"""What the condensed step costs: factorisations of the bulk, inverses and products of the dense step."""

from dataclasses import replace

import numpy as np
import pytest
from solving import coarse_simulation, solved, watched

from simulations.fem.load import NO_LOAD
from simulations.solvers.condensed import surface_compliance
from simulations.solvers.condensed.mirror import parts
from simulations.solvers.condensed.tangent import DenseTangent


@pytest.fixture
def factorised(monkeypatch):
    """Matrices that are factorised in a test."""
    return watched(monkeypatch, surface_compliance, "PartialFactor")


def test_a_loop_factorises_each_half_once(factorised):
    simulation = solved(solver__increments=10)
    assert len(simulation.history.entries) == 51
    assert len(factorised) == 2
    halves = parts(simulation.body)
    assert [half.is_half for half in halves] == [True, True]
    assert sum(len(half.dofs) for half in halves) == simulation.body.unknowns


def test_a_mesh_without_mirror_is_solved_whole(factorised):
    """The same loop on a mesh whose left half is another than its right: no halves, nearly the same numbers."""
    grading = coarse_simulation().cells
    edges = tuple(e if e > 0 else 1.03 * e for e in grading.edges)
    lopsided = replace(grading, edges=edges, sweeps=(), edge_at=-1.0)
    simulation = solved(cells=lopsided)
    assert len(factorised) == 1
    assert [half.is_half for half in parts(simulation.body)] == [False]
    energy = solved().history.dissipated_energy
    assert simulation.history.dissipated_energy == pytest.approx(energy, rel=2e-2)


def test_a_body_that_is_stiffer_on_one_side_has_no_halves():
    body = coarse_simulation().body
    assert [part.is_half for part in parts(body)] == [True, True]
    diagonal, (node, *_) = body.stiffness.getDiagonal(), body.surface_nodes.owned
    diagonal.array[body.dofs[node]] *= 2.0
    body.stiffness.setDiagonal(diagonal)
    assert [part.is_half for part in parts(body)] == [False]


@pytest.mark.parametrize("k", [0.3, -0.5])
def test_compliance_solves_the_whole_body(k):
    """A force on one side and its displacement, recovered in the whole body, leave no residual in the stiffness."""
    simulation = coarse_simulation(solid__k=k, solid__nu=0.3)
    body, compliance = simulation.body, simulation._compliance
    matrix = compliance.matrix((0, 1))
    forces = np.zeros(2 * compliance.n)
    forces[[3, compliance.n + 5]] = 1.0, -2.0
    compliance.body.set_far_field(NO_LOAD)
    compliance.put(matrix.apply(forces))
    compliance.recover()
    residual = body.stiffness.createVecLeft()
    body.stiffness.mult(body.state.x.petsc_vec, residual)
    residual.array[body.fixed_dofs] = 0.0
    residual.array[compliance._surface_dofs.T.ravel()] -= forces
    assert np.abs(residual.array).max() < 1e-9 * 2.0


@pytest.mark.parametrize("lost, inversions", [(1e-8, 0), (0.1, 1)])
def test_a_step_whose_inverse_has_lost_digits_is_refined_or_gets_another(monkeypatch, lost, inversions):
    dense = solved(load__cycles=0, solid__nu=0.3).stepping._newton.system.dense
    inverted = watched(monkeypatch, DenseTangent, "_invert")
    b = np.random.default_rng(1).standard_normal(dense._inverse.shape[0])
    dense._inverse = (1 + lost) * dense._inverse
    assert len(dense._rows)
    assert dense.multiply(dense.solve(b, 1.0)) == pytest.approx(b, abs=1e-11 * np.abs(b).max())
    assert len(inverted) == inversions


def test_dense_steps_reuse_what_they_know(monkeypatch):
    """One inverse serves a stage; only rows that neither opened nor slid are multiplied with the compliance
    matrix again, and those of a node that sticks are kept.
    """

    def further_products():
        with monkeypatch.context() as patch:
            inverted, multiplied = (watched(patch, DenseTangent, name) for name in ("_invert", "_full_rows"))
            simulation = solved(solver__increments=6, solid__nu=0.3)  # with coupling, where edges move
        dense = simulation.stepping._newton.system.dense
        assert [tangent for tangent, *_ in inverted].count(dense) == 1
        return sum(len(rows) for tangent, _, rows in multiplied if tangent is dense) - 2 * simulation.sampler.x.size

    kept = further_products()
    monkeypatch.setattr(DenseTangent, "_known_rows", lambda tangent, *rows: tangent._full_rows(*rows))
    assert kept < 0.1 * further_products()
