"""What ends Newton's method: loads and forces that balance, and one step more; or round-off, which is then stated."""

from mpi4py import MPI
from running import coarse_overrides

from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, parse
from simulations.solvers import newton


def run(tolerance) -> Simulation:
    """A first loading, with Newton's tolerance."""
    scene = parse(DEFAULT_SCENE, coarse_overrides(solid__nu=0.3, solver__increments=4, load__cycles=0))
    return Simulation(MPI.COMM_SELF, scene, tolerance=tolerance).run_to_end()


def test_a_balanced_state_gets_one_more_step():
    """However little is asked for: then ranks do not change numbers."""
    assert max(entry.residual for entry in run(1e-3).history.entries) < newton.SETTLED


def test_what_round_off_leaves_is_stated_as_the_tolerance(monkeypatch):
    monkeypatch.setattr(newton, "OVER_ROUND_OFF", 0.0)
    for entry in run(1e-30).history.entries:
        assert 0.0 < entry.residual <= entry.tolerance < 1e-11


def test_forces_that_balance_are_not_enough_without_loads_that_do():
    solver, load = (done := run(1e-9)).stepping._newton, done.schedule[-1].load
    assert solver.balance(load).converged
    assert not solver.balance(load._replace(Q=load.Q + 1e-7)).converged
    solver._norms = 0.0, 1e-7
    assert not solver._balanced()
