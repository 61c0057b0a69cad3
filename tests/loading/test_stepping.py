"""Load stepping: load steps in halves, and states that come back."""

from dataclasses import replace
from itertools import count, cycle
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI
from solving import coarse_simulation, solved, watched

from simulations.fem.load import Load
from simulations.loading import present_state
from simulations.loading.anchors import EnteringPoints
from simulations.loading.fallbacks import Limits
from simulations.loading.schedule import LoadStep
from simulations.loading.stepping import LoadStepping, SolveError
from simulations.runs import checks
from simulations.runs.simulation import Simulation
from simulations.scene import make_scene
from simulations.solvers.newton import FORCE_TOLERANCE, NewtonResult

STEEP_LOOP = {
    "solid.E0": 210e9,
    "solid.y0_over_a0": 10.0,
    "indenter.R": 0.1,
    "solid.k": -0.472,
    "solid.nu": -0.309,
    "load.P": 1e6,
    "load.mu": 0.256,
    "load.amplitude": 0.219,
    "solver.increments": 2,
    "reference.kind": "none",
}


def test_a_load_step_after_which_tractions_zigzag_is_taken_in_halves(request):
    def after_the_turn():
        simulation = Simulation(MPI.COMM_SELF, make_scene(STEEP_LOOP, base=None))
        entry = next(entry for entry in simulation.run() if entry.number == 4)
        return entry.cuts, checks.largest_zigzag(entry.surface)

    cuts, zigzag = after_the_turn()
    assert cuts == 1 and zigzag < 0.03
    request.getfixturevalue("whole_steps")
    cuts, zigzag = after_the_turn()
    assert cuts == 0 and zigzag > 0.1


def test_where_halves_are_not_smoother_the_load_step_is_as_if_they_had_not_been_tried(monkeypatch):
    def states(zigzag):
        monkeypatch.setattr(Simulation, "_zigzag", lambda simulation: zigzag)
        loop = {"solid__k": 0.0, "load__mu": 0.6, "load__amplitude": 0.6, "solver__increments": 2}
        return solved(**loop, solid__nu=0.3).history.entries

    for tried, whole in zip(states(2.0), states(0.0), strict=True):
        assert tried.cuts == 0 and (tried.step.branch == "normal" or tried.iterations > whole.iterations)
        for name in ("pressure", "traction", "relative_displacement"):
            expected = getattr(whole.surface, name)
            largest = np.abs(expected).max(initial=1e-3)
            assert getattr(tried.surface, name) == pytest.approx(expected, abs=1e-8 * largest)


def test_where_halves_have_no_answer_the_residual_told_is_that_of_the_state_that_stays(monkeypatch):
    """Not that with which the last way of solving a half ended: the run's check of residuals would fail."""

    def in_halves(self, before, step):
        self._results.append(NewtonResult(False, 60, 0.1, "too many iterations"))
        raise SolveError("no equilibrium")

    monkeypatch.setattr(Simulation, "_zigzag", lambda simulation: 2.0)
    monkeypatch.setattr(LoadStepping, "_in_halves", in_halves)
    entries = solved(solid__nu=0.3, load__cycles=0, solver__increments=2).history.entries
    assert [entry.iterations > 60 for entry in entries] == [False, True, True]
    assert max(entry.residual for entry in entries) <= FORCE_TOLERANCE


@pytest.mark.parametrize("of_halves, unsettled", [(1.5, 0.3), (2.5, 0.1)])
def test_how_far_anchors_are_from_settled_is_told_of_the_states_that_stay(of_halves, unsettled, monkeypatch):
    zigzags, found = cycle([2.0, of_halves]), cycle([0.1, 0.3, 0.2])  # of the load step, and of its halves
    monkeypatch.setattr(Simulation, "_zigzag", lambda simulation: next(zigzags))
    monkeypatch.setattr(EnteringPoints, "end", lambda self: setattr(self.iteration, "unsettled", next(found)))
    entries = solved(solid__nu=0.3, load__cycles=0, solver__increments=2).history.entries
    assert [entry.unsettled for entry in entries if entry.step.branch != "normal"] == [unsettled] * 2


@pytest.mark.parametrize("is_uncoupled, expected", [(False, 1e-3), (True, 1e-5)])
def test_where_anchors_do_not_settle_the_state_that_asks_for_least_stays(is_uncoupled, expected, monkeypatch):
    """Without coupling, where they are exact, they settle to what is a hundred times closer."""
    states, best, back = count(), iter([True, True, False]), []
    monkeypatch.setattr(present_state, "save", lambda system: next(states))
    monkeypatch.setattr(present_state, "restore", lambda system, saved: back.append(saved))
    iteration = SimpleNamespace(is_best=False, go_back=lambda: None)

    def renew(clearance, settled):
        assert settled == expected
        iteration.is_best = next(best)
        return True

    stepping = SimpleNamespace(
        limits=Limits(anchor_passes=2),
        system=None,
        entering=SimpleNamespace(renew=renew, iteration=iteration),
        _is_uncoupled=is_uncoupled,
        _clearance=lambda: None,
        _solve=lambda load: [SimpleNamespace(converged=True)],
        _results=[],
        _newton=SimpleNamespace(balance=lambda load: "balanced"),
    )
    LoadStepping._settle_anchors(stepping, Load(1.0))
    assert back == [1] and stepping._results == ["balanced"]


def test_a_state_that_is_put_back_has_all_that_the_next_load_step_takes():
    """Contact states at rest too: they tell which points slid before."""
    simulation = coarse_simulation(solid__nu=0.3)
    states = simulation.run()
    for _ in range(3):
        next(states)
    system, memory, body = simulation.stepping.system, simulation.stepping.problem.memory, simulation.body

    def told():
        fields = body.state.x.array, body.delta.value, memory.anchors(), memory.states_at_rest()
        return [values.copy() for values in fields]

    saved, before = present_state.save(system), told()
    next(states)
    assert all(np.any(mine != old) for mine, old in zip(told(), before, strict=True))
    present_state.restore(system, saved)
    assert all(np.array_equal(mine, old) for mine, old in zip(told(), before, strict=True))


def test_anchors_are_those_of_pressing_while_there_is_nothing_else(monkeypatch):
    solid = "solid.E0 = 210e9\nsolid.k = 0.3\nsolid.nu = 0.3\nsolid.y0 = 0.01\nindenter.R = 0.1\nload.mu = 0.3\n"
    path = "load.points = [[5e5, 0], [1e6, 1e5]]\neffects.friction_in_normal_stage = true\n"
    simulation = coarse_simulation(solid + path, solver__increments=1)
    begun = watched(monkeypatch, EnteringPoints, "begin")
    simulation.run_to_end()
    assert [stuck is not None for *_, stuck in begun[-2:]] == [True, False]


def test_quarters_of_a_harmonic_load_step_lie_on_the_arc():
    step = LoadStep(Load(1.0, 0.0, 1.0), angle=np.pi / 2)
    loads = [step.on_the_way(Load(1.0, 1.0, 0.0), share) for share in (0.25, 0.5, 0.75, 1.0)]
    assert [np.arctan2(load.strain, load.Q) for load in loads] == pytest.approx(np.pi / 8 * np.arange(1, 5))
    assert [np.hypot(load.strain, load.Q) for load in loads] == pytest.approx([1.0] * 4)


def test_a_half_of_a_harmonic_load_step_lies_on_the_arc(monkeypatch):
    """Q and the strain a quarter behind it are on an ellipse, which the chord between two load steps is inside of."""
    monkeypatch.setattr(Simulation, "_zigzag", lambda simulation: 2.0)
    solve, loads = LoadStepping._solve, []

    def kept(self, load, *newton):
        loads.append(load)
        return solve(self, load, *newton)

    monkeypatch.setattr(LoadStepping, "_solve", kept)
    scene = {"solid__nu": 0.3, "load__amplitude": 0.5, "load__bulk_strain": 1e-4, "load__bulk_phase": 90}
    schedule = solved(**scene, solver__increments=2).schedule
    Q_A, strain = schedule[-1].Q, max(step.load.strain for step in schedule)
    begun = next(n for n, load in enumerate(loads) if abs(load.strain) > 1e-6 * strain)
    places = np.array([load.Q / Q_A + 1j * load.strain / strain for load in loads[begun:]])
    assert np.abs(places) == pytest.approx(1.0)
    half = [22.5, 45, 67.5, 90, 112.5, 135, 157.3125, 179.625, 179.8125, 180]  # a short load step comes last
    found = set(np.round(np.angle(places, deg=True), 4) % 360)
    assert found == {*half, *((180 + place) % 360 for place in half)}


def test_a_restored_state_balances_as_it_did(monkeypatch):
    """Where a pass for the anchors fails, the last state and its forces are back: displacements lose their digits."""
    solve, loads = LoadStepping._solve, []

    def second_fails(self, load):
        loads.append(load)
        return [replace(solve(self, load)[-1], converged=len(loads) < 2 or loads[-2] is not load)]

    monkeypatch.setattr(LoadStepping, "_solve", second_fails)
    scene = {"solid__nu": 0.0, "solid__k": -0.5, "load__mu": 1.0, "load__cycles": 0, "solver__increments": 2}
    history = solved(**scene).history
    assert any(a is b for a, b in zip(loads, loads[1:]))
    assert all(entry.residual <= entry.tolerance for entry in history.entries[1:])
