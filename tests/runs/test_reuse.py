"""A body is taken over by scenes whose solid and mesh are the same, and by no others."""

from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI
from running import COARSE
from solving import watched

from simulations.runs.plan import Plan
from simulations.runs.simulation import Simulation
from simulations.runs.timing import Stopwatch
from simulations.scene import SceneError, make_scene
from simulations.solvers.condensed import surface_compliance

BASE = COARSE | {"load.cycles": 0, "solid.y0": 0.01, "solid.nu": 0.3}
UNCOUPLED = BASE | {"effects.coupling": False}
STRAINED, ELASTIC = UNCOUPLED | {"load.bulk_strain": 1e-4}, UNCOUPLED | {"effects.elastic_slip": 2e-7}
NO_LOOP = dict.fromkeys(("load.P", "load.amplitude", "load.cycles"))
PATH = BASE | NO_LOOP | {"load.points": [[1e6, 0.0], [1e6, 1e5], [6e5, 1e5]], "effects.elastic_slip": 2e-7}
RELIEVED = BASE | NO_LOOP | {"load.mu": None, "load.points": [[1e6, 0], [7e5, 0], [4e5, 0]], "solver.increments": 1}
TWO_STEPS = UNCOUPLED | NO_LOOP | {"load.points": [[1e6, 0.0], [1e6, 1e5]], "solver.increments": 2}


def made(keys, like=None) -> Simulation:
    return Simulation(MPI.COMM_SELF, make_scene(keys), like=like)


def planned(keys) -> Plan:
    return Plan(make_scene(keys), Stopwatch())


@pytest.fixture(scope="module")
def first():
    return made(UNCOUPLED)


@pytest.mark.parametrize(
    "changes, is_shared",
    [
        ({"load.mu": 0.5}, True),
        ({"load.P": 2e6}, True),
        ({"load.amplitude": 0.5}, False),
        ({"load.cycles": 1}, False),
        ({"load.mu": None, "load.amplitude": None, "load.cycles": None}, False),
        ({"solver.increments": 12}, False),
        ({"solid.k": 0.2}, False),
        ({"solid.nu": 0.2}, False),
        ({"mesh.facet": 0.05}, False),
        ({"mesh.degree": 3}, False),
        ({"mesh.edges": "states"}, False),
        ({"effects.coupling": True}, False),
        ({"indenter.profile": "circle"}, False),
    ],
)
def test_friction_load_and_cylinder_alone_only_scale_an_uncoupled_contact(changes, is_shared):
    assert (planned(UNCOUPLED | changes).graded_for == planned(UNCOUPLED).graded_for) == is_shared


def test_tables_of_moduli_share_where_all_their_points_are_the_same():
    def table(deepest):
        others = dict.fromkeys(("E0", "k", "y0", "y0_over_a0"))
        table = {"modulus": "tabulated", "points": [[0.0, 2e11], [1e-3, 2e11], [2e-3, deepest]]}
        return planned(UNCOUPLED | {f"solid.{name}": value for name, value in (others | table).items()}).graded_for

    assert table(1e11) == table(1e11) != table(1.1e11)


@pytest.mark.parametrize(
    "keys, changes",
    [
        (BASE, {"load.mu": 0.5}),
        (RELIEVED, {"solver.increments": 2, "load.points": RELIEVED["load.points"][::2]}),  # the same load steps
        (STRAINED, {"load.P": 1.1e6}),
        (STRAINED, {"load.P": 2e6}),
        (STRAINED, {"load.mu": 0.5}),
        (ELASTIC, {"load.mu": 0.5}),
        (PATH, {"solid.E0": 70e9}),
        (TWO_STEPS, {"load.points": [[1e6, 0.0], [1e6, 5e4], [1e6, 1e5]], "solver.increments": 1}),
    ],
)
def test_a_body_is_not_shared_where_the_edges_are_others(keys, changes):
    """With coupling friction moves them; strain and elastic slip are values of their own, which nothing scales. The
    mesh of a path is graded to the edges at its points.
    """
    one, other = planned(keys), planned(keys | changes)
    assert other.graded_for != one.graded_for and other.grading() != one.grading()


def test_what_is_reused_has_the_numbers_of_its_own_body(first, monkeypatch):
    """Without another factorisation."""
    changed = UNCOUPLED | {"load.mu": 0.5, "solid.E0": 70e9, "load.P": 2e6, "indenter.R": 0.2}
    first.run_to_end()
    factorised = watched(monkeypatch, surface_compliance, "PartialFactor")
    shared = made(changed, first).run_to_end()
    assert shared.body is first.body and not factorised
    alone = made(changed).run_to_end()
    for mine, own in zip(shared.history.entries, alone.history.entries, strict=True):
        for name in ("pressure", "traction"):
            one, other = getattr(mine.surface, name), getattr(own.surface, name)
            assert np.abs(one - other).max() <= 1e-8 * own.surface.pressure.max()
        assert mine.surface.delta == pytest.approx(own.surface.delta, abs=1e-8)  # also where it is nowhere asked for
    shared.body.recover = pytest.fail  # of the state before
    shared.body.reset()
    shared.body.complete()
    assert not shared.body.state.x.array.any()


def test_dense_matrices_have_their_limit_on_the_mesh_of_a_run_without_them(first, monkeypatch):
    full = made(UNCOUPLED | {"solver.method": "full"}, first)
    assert full.body is first.body
    monkeypatch.setattr("simulations.runs.limits.MOST_MATRIX", 1e-4)
    with pytest.raises(SceneError, match="surface nodes make dense matrices"):
        made(UNCOUPLED, full)


def test_seconds_of_a_phase_within_another_are_counted_once(monkeypatch):
    now = iter([0.0, 1.0, 2.0, 7.0, 10.0])  # made, mesh and edges begin, end
    monkeypatch.setattr("simulations.runs.timing.time", SimpleNamespace(perf_counter=lambda: next(now)))
    watch = Stopwatch()
    with watch("mesh"):
        with watch("edges"):
            pass
        assert watch.last == 5.0
    assert watch.last == 9.0 and watch.seconds == {"mesh": 4.0, "edges": 5.0}


def test_a_phase_that_fails_is_told_to_its_end():
    """Else what is said of the failure stands behind "mesh ... "."""
    told: list = []
    watch = Stopwatch(lambda name, seconds: told.append(name if seconds is None else float))
    with pytest.raises(SceneError), watch("mesh"):
        raise SceneError("too coarse")
    assert told == ["mesh", float]
