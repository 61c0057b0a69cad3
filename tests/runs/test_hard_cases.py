"""Hard cases: each cure, and that without it the case fails; refusals by name."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI
from running import coarse_arguments, run_command
from solving import coarse_simulation, limit_stepping, solved

from simulations.fem import body, edge_place
from simulations.loading import anchors, stopped_points
from simulations.loading.fallbacks import Limits
from simulations.loading.stepping import LoadStepping, SolveError
from simulations.runs import checks
from simulations.runs import expected_edges as edges
from simulations.runs.limits import expected_error
from simulations.runs.simulation import Simulation
from simulations.scene import SceneError, make_scene
from simulations.solvers import newton, path
from simulations.solvers.condensed import tangent

UNCOUPLED = {"effects__coupling": "false", "solid__nu": 0.3}


def iterations(**changes) -> int:
    """Newton iterations of a coarse loop."""
    return sum(entry.iterations for entry in solved(**changes).history.entries)


# --- each cure, and the case without it -----------------------------------------------------------------------


def test_contact_terms_are_integrated_at_the_nodes(monkeypatch):
    thin = {"solver__method": "full", "mesh__facet": 0.2, "mesh__first_layer": 1e-3, "solver__increments": 1}
    solved(**thin)
    monkeypatch.setattr(body, "SURFACE_RULE", {"quadrature_degree": 4})
    limit_stepping(monkeypatch, halvings=0)
    with pytest.raises(SolveError):
        solved(**thin)


def test_increments_start_with_all_points_sticking(monkeypatch):
    """Where the load turns; without the predictor a coupled loop takes a sixth more iterations."""
    coupled = {"solid__nu": 0.3, "solid__k": 0.0}
    predicted, solve = iterations(**coupled), newton.Newton.solve
    monkeypatch.setattr(newton.Newton, "solve", lambda self, load, predict=False, **how: solve(self, load, **how))
    assert iterations(**coupled) > 1.15 * predicted


def test_near_incompressibility_chatters_without_the_mean_stress(monkeypatch):
    mixed = iterations(solid__nu=0.49, solid__k=0.0)
    monkeypatch.setattr("simulations.scene.scene.LOCKING", 0.499)
    assert iterations(solid__nu=0.49, solid__k=0.0) > 1.5 * mixed


def test_tolerance_follows_round_off(monkeypatch):
    thin = UNCOUPLED | {"solid__k": -0.7, "mesh__first_layer": 1e-4}
    history = solved(**thin).history
    assert newton.FORCE_TOLERANCE < max(entry.residual for entry in history.entries) < newton.ATTAINABLE
    monkeypatch.setattr(newton, "ATTAINABLE", newton.FORCE_TOLERANCE)  # whatever round-off there is
    solved(**UNCOUPLED)
    with pytest.raises(SolveError):
        solved(**thin)


def test_edges_of_a_box_have_their_own_place(monkeypatch):
    """Pressure that ends nearly like a box goes up at the last node where the edge is placed as for a root."""
    box = {"solid.k": -0.8, "solid.nu": -0.3, "load.mu": 0.3, "load.amplitude": 0.6, "load.cycles": 0}

    def zigzag():
        simulation = Simulation(MPI.COMM_SELF, make_scene(box | {"solver.increments": 1, "effects.coupling": False}))
        return max(checks.zigzags(e.surface.pressure, e.peak_pressure) for e in simulation.run())

    assert zigzag() < checks.ZIGZAGS / 2
    monkeypatch.setattr("simulations.runs.plan.best_place", lambda degree, k: edge_place.best_place(degree, -0.6))
    assert zigzag() > checks.ZIGZAGS


def test_what_round_off_leaves_of_the_load_balance_ends_a_solve():
    """k = -0.9: the sum of so many stiff nodes' forces is off by more than each of them, however often it is solved."""
    box = UNCOUPLED | {"solid__k": -0.9, "mesh__first_layer": 1e-3, "mesh__edge_facet": 1e-3, "load__cycles": 0}
    simulation = coarse_simulation(**box, load__mu=0.1, load__amplitude=0.9, solver__increments=1)
    pressed = next(simulation.run())
    assert pressed.iterations <= 15
    assert 10 * newton.FORCE_TOLERANCE < checks.imbalance(pressed) < 10 * pressed.tolerance < newton.ATTAINABLE * 10
    found = checks.check(simulation.history, simulation.scaled.indenter.height)
    assert found["residual"].holds and found["load balance"].holds


def test_first_contact_has_facets_enough(monkeypatch):
    """Pressed on with little friction, few points all slide at first: a singular tangent. Of more some stick."""
    monkeypatch.setattr(path, "_fix_indenter", lambda *_: False)
    scene = {"solid__k": 0.0, "solid__nu": 0.3, "load__mu": 0.003, "effects__friction_in_normal_stage": "true"}
    simulation = solved(**scene)
    assert len(simulation.history.entries) == len(simulation.schedule)
    monkeypatch.setattr(edges, "FIRST", 0.5)
    with pytest.raises(SolveError, match="singular"):
        solved(**scene)


def zigzags(**changes) -> float:
    """Of pressure or traction, the most of all states of a loop."""
    simulation = solved(**changes)
    found = checks.check(simulation.history, simulation.scaled.indenter.height)
    return max(found[name].value for name in ("pressure zigzags", "traction zigzags"))


def test_entering_points_are_anchored_where_the_edge_passed_them(monkeypatch):
    """Pressed on with friction: anchored where the load step began they leave a tooth of traction a load step.

    Under a circle, whose contact does not grow similar to itself: where points stick is not known beforehand.
    """
    pressed = {"solid__nu": 0.3, "effects__friction_in_normal_stage": "true", "load__cycles": 0}
    pressed["indenter__profile"] = "circle"
    assert zigzags(**pressed) < checks.ZIGZAGS
    limit_stepping(monkeypatch, anchor_passes=0)
    assert zigzags(**pressed) > 2 * checks.ZIGZAGS


def test_points_that_the_next_load_step_reaches_are_in_line_with_those_passed(monkeypatch):
    """An edge of contact sticks as it advances: without this each load step leaves a kink."""
    stuck = {"solid__k": -0.3, "solid__nu": 0.0, "load__mu": 1.0, "load__amplitude": 0.3, "solver__increments": 6}
    stuck |= {"mesh__facet": 0.05, "mesh__edge_facet": 0.004, "mesh__first_layer": 0.004, "mesh__layer_growth": 1.5}
    assert zigzags(**stuck) < checks.ZIGZAGS / 2
    monkeypatch.setattr(anchors, "BESIDE", 0)
    assert zigzags(**stuck) > checks.ZIGZAGS


def test_a_load_step_ends_with_the_best_state_where_new_anchors_have_no_answer(monkeypatch):
    """Here that is the first: the second asks for a larger change of anchors."""
    scene = {"solid.k": 0.0, "solid.nu": 0.0, "load.mu": 1.0, "load.amplitude": 0.3, "solver.increments": 2}
    entries = Simulation(MPI.COMM_SELF, make_scene(scene | {"mesh.facet": 0.1, "mesh.edge_facet": 0.01})).run()
    next(entries), next(entries)  # pressed, and a load step
    asks, solves, renew, solve = [], [], anchors.EnteringPoints.renew, LoadStepping._solve

    def renewed(self, *arguments):
        changes = renew(self, *arguments)
        asks.append(self.iteration.unsettled)
        return changes

    def third_fails(self, load):
        solves.append(load)
        tried = solve(self, load)
        return [replace(result, converged=result.converged and len(solves) != 3) for result in tried]

    monkeypatch.setattr(anchors.EnteringPoints, "renew", renewed)
    monkeypatch.setattr(LoadStepping, "_solve", third_fails)
    monkeypatch.setattr(LoadStepping, "_take", LoadStepping._advance)  # its tractions zigzag: no halves here
    assert next(entries).unsettled == asks[0] < asks[1] and len(solves) == 3


LEADING = {"solid__k": -0.4, "solid__nu": -0.2, "load__mu": 0.4, "load__amplitude": 0.2, "solver__increments": 3}
LEADING |= {"mesh__facet": 0.05, "mesh__edge_facet": 0.003, "mesh__first_layer": 0.004, "mesh__layer_growth": 1.5}


def test_anchors_settle_that_change_by_little_in_each_solve(monkeypatch):
    assert not any(entry.unsettled for entry in solved(**LEADING).history.entries)
    monkeypatch.setattr(stopped_points, "FASTEST", 0.0)
    unsettled = [entry.unsettled for entry in solved(**LEADING).history.entries if entry.unsettled]
    assert unsettled and min(unsettled) > Limits().anchors_settled


def test_mesh_is_fine_where_steep_edges_move(monkeypatch):
    steep = {"solid__nu": 0.35, "solid__k": -0.7, "mesh__edge_facet": 0.01, "mesh__facet": 0.05, "mesh__growth": 1.3}
    assert zigzags(**steep) < checks.ZIGZAGS
    monkeypatch.setattr(edges.ExpectedEdges, "sweeps", lambda *sizes: ())
    assert zigzags(**steep) > 2 * checks.ZIGZAGS


def test_steps_are_refined(monkeypatch):
    """Box-like pressure on fine facets: forces of 1e7 P cancel in the first step, whose round-off others then carry."""
    box = {"solid__k": -0.9, "solid__nu": 0.3, "mesh__facet": 0.05, "mesh__edge_facet": 5e-3, "mesh__first_layer": 5e-3}

    def needed():
        try:
            return next(coarse_simulation(**box, load__cycles=0).run()).iterations
        except SolveError:
            return np.inf

    refined = needed()
    assert refined <= 15
    monkeypatch.setattr(tangent, "REFINED", (np.inf, np.inf))
    assert needed() > 3 * refined


def test_thin_cells_are_kept():
    """gmsh merges points closer than 1e-8 of the domain by default."""
    solved(**UNCOUPLED, solid__k=0.0, mesh__first_layer=1e-6, solver__increments=1)


# --- refusals ------------------------------------------------------------------------------------------------

REFUSALS = {
    "slip zone": ({"load__amplitude": 0.01}, ("mesh.edge_facet", "slip zone", "load.amplitude = 0.01")),
    "steep ends": ({"solid__k": -0.9, "solid__nu": 0.3}, ("mesh.edge_facet", "k = -0.9")),
    "steep ends, facet": (
        {"solid__k": -0.9, "solid__nu": 0.3, "mesh__facet": 0.08, "mesh__edge_facet": 0.1},
        ("mesh.facet = 0.08", "k = -0.9"),
    ),
    "round-off": ({"solid__k": -0.7, "solid__nu": 0.3, "mesh__first_layer": 1e-6}, ("mesh.first_layer", "round-off")),
    "gamma0": ({"solver__gamma0": 0.1}, ("solver.gamma0 = 0.1", "0.3")),
    "surface nodes": ({"mesh__facet": 1e-3, "mesh__extent": 1e4}, ("surface nodes", "mesh.facet")),
    "unknowns": (
        {"mesh__edge_facet": 1e-6, "mesh__growth": 1.02, "mesh__layer_growth": 1.02},
        ("unknowns", "mesh.growth"),
    ),
}


@pytest.mark.parametrize("changes, words", REFUSALS.values(), ids=REFUSALS.keys())
def test_refused_by_name(changes, words):
    with pytest.raises(SceneError) as refusal:
        coarse_simulation(**changes)
    assert "\n" not in str(refusal.value)
    for word in words:
        assert word in str(refusal.value)


def number_before(words, refusal) -> float:
    """The last number before these words of a refusal."""
    return float(str(refusal.value).rsplit(words, 1)[0].rsplit(maxsplit=1)[-1])


@pytest.mark.parametrize("name", ["slip zone", "steep ends"])
def test_what_a_refusal_asks_for_is_accepted(name):
    """And twice as much is not: the number is rounded down to one digit."""
    changes, _ = REFUSALS[name]

    def with_cells_of(size):
        return coarse_simulation(**changes | {"mesh__edge_facet": size, "mesh__first_layer": size})

    with pytest.raises(SceneError) as refusal:
        coarse_simulation(**changes)
    needed = number_before(" or less", refusal)
    with_cells_of(needed)
    with pytest.raises(SceneError, match=" or less"):
        with_cells_of(2 * needed)


def test_with_theta_of_minus_1_a_small_gamma0_is_stable():
    (entry, *_) = coarse_simulation(solver__gamma0=0.1, solver__theta=-1).run()
    assert entry.residual < entry.tolerance and entry.a == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("k", [-0.3, 0.3])
def test_a_first_layer_that_a_refusal_asks_for_is_accepted(k):
    """For k > 0 the height of the surface cells is that of the mesh depth s = y^(1-k)."""
    stiff = UNCOUPLED | {"solid__k": k, "solver__gamma0": 1e6}
    with pytest.raises(SceneError, match="too thin") as refusal:
        coarse_simulation(**stiff, mesh__first_layer=1e-7)
    needed = number_before(" or more", refusal)
    coarse_simulation(**stiff, mesh__first_layer=needed)


def test_no_first_layer_is_asked_for_that_is_refused():
    """At k = -0.9 the ends of the traction allow 0.015 at most, and with this gamma0 round-off wants 0.02."""
    steep = {"solid__k": -0.9, "solid__nu": 0.3, "mesh__edge_facet": 5e-3, "mesh__first_layer": 1e-3}
    with pytest.raises(SceneError, match="too thin .*: a smaller solver.gamma0 is needed$"):
        coarse_simulation(**steep, solver__gamma0=1e4)
    with pytest.raises(SceneError, match="mesh.first_layer = 0.02 is too coarse"):
        coarse_simulation(**steep | {"mesh__first_layer": 0.02}, solver__gamma0=1e4)


def test_refusal_as_the_user_sees_it(tmp_path):
    done = run_command(*coarse_arguments(tmp_path, load__amplitude=0.01), ranks=2, timeout=120)
    assert done.returncode == 2
    assert sum("slip zone" in line for line in done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("k, measured", [(-0.5, 7.1e-3), (-0.7, 3.1e-2), (-0.8, 3.2e-2)])
def test_expected_error_is_about_the_measured_one(k, measured):
    size = 0.02 if k > -0.8 else 0.01
    assert 0.5 * measured < expected_error(k, size) < 2 * measured


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_too_many_unknowns(monkeypatch, degree):
    """The limit is met to the unknown, at every degree; a mixed form's mean stress comes on top."""
    unknowns = coarse_simulation(mesh__degree=degree).body.unknowns
    monkeypatch.setattr("simulations.runs.limits.MOST_UNKNOWNS", unknowns)
    coarse_simulation(mesh__degree=degree)
    monkeypatch.setattr("simulations.runs.limits.MOST_UNKNOWNS", unknowns - 1)
    with pytest.raises(SceneError, match="too fine"):
        coarse_simulation(mesh__degree=degree)
