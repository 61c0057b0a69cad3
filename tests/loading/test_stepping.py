"""Load stepping: load steps in halves, and states that come back."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI
from solving import solved

from simulations.loading.stepping import LoadStepping
from simulations.runs import checks
from simulations.runs.simulation import Simulation
from simulations.scene import make_scene

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
    assert set(np.round(np.angle(places, deg=True) / 22.5, 6) % 16) == set(range(16))


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
