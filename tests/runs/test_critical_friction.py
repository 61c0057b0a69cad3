"""The critical coefficient of friction of a run: what is told of it, and the bound of its own mesh."""

import numpy as np
import pytest
from mpi4py import MPI
from running import COARSE
from solving import coarse_simulation

from simulations import Simulation, make_scene
from simulations.loading.stepping import SolveError
from simulations.runs import critical_friction, limits, zigzag_cause
from simulations.runs.checks import check
from simulations.runs.explain import explain
from simulations.runs.report_data import find, summary

SHORT = {"load.cycles": 0, "solver.increments": 1}
COUPLED = {"solid__k": 0.0, "solid__nu": 0.0, "reference__kind": "none", "mesh__first_layer": 0.02}


@pytest.mark.parametrize("mu, side", [(0.3, "is below the bounds"), (1.5, "is between"), (2.0, "is above")])
def test_explain_tells_the_side(mu, side):
    assert side in explain(coarse_simulation(**COUPLED, load__mu=mu))


def test_of_a_coating_it_is_said_that_the_bounds_are_those_of_its_surface():
    """Elements on the body as it is may have others: a film of k = 0.5, 0.003 a thick, has 3.39 in place of 5.75."""
    thin = {"solid.modulus": "power-law coating", "solid.k": 0.5, "solid.nu": 0.3, "solid.thickness_over_a0": 0.01}
    surface = "5.75 of 12 equal half-plane elements with E(y) as at the surface of the coating"
    assert surface in critical_friction.side(make_scene(thin))
    whole = critical_friction.side(make_scene({"solid.k": 0.5, "solid.nu": 0.3}))
    assert "5.75 of 12 equal half-plane elements: " in whole


def test_without_coupling_there_is_none():
    simulation = coarse_simulation(effects__coupling="false")
    assert "critical friction" not in explain(simulation)
    assert critical_friction.expected(simulation.scene, simulation.effects) is None


def test_summary_has_both_bounds_and_a_run_that_zigzags_says_where_it_lies():
    simulation = coarse_simulation(**COUPLED, load__mu=0.3, load__cycles=0, solver__increments=1).run_to_end()
    told = summary(simulation, find(simulation))["critical_friction"]
    assert told["lower"] == pytest.approx(1.235, abs=1e-3) and told["upper"] == pytest.approx(1.764, abs=1e-3)
    own = zigzag_cause.critical_of_mesh(simulation)
    assert 1.0 < own < 2.0  # 1.4 with equal facets of degree 2
    assert "is below" in zigzag_cause.cause(simulation)
    surface = simulation.history.entries[-1].surface
    surface.traction[:] += 0.3 * surface.pressure * (-1.0) ** np.arange(surface.x.size)
    found = check(simulation.history, lambda x: x**2 / 2, lambda: zigzag_cause.cause(simulation))
    assert not found["traction zigzags"].holds and "mu = 0.3 is below" in found["traction zigzags"].cause


ABOVE = "no equilibrium; mu = 2 is above the bounds"


@pytest.mark.parametrize(
    "mu, rubs, told", [(0.3, True, "no equilibrium"), (2.0, True, ABOVE), (2.0, False, "no equilibrium")]
)
def test_a_run_without_an_answer_says_so_where_rates_are_not_unique(monkeypatch, mu, rubs, told):
    """And where there is friction in the load step: while the cylinder is pressed on there is none."""
    simulation = coarse_simulation(**COUPLED, load__mu=mu)
    if rubs:
        simulation.stepping.problem = simulation.stepping.frictional

    def fail(*_):
        raise SolveError("no equilibrium")
        yield

    monkeypatch.setattr(simulation.stepping, "run", fail)
    with pytest.raises(SolveError) as failure:
        simulation.run_to_end()
    said = str(failure.value).partition("): ")[2]
    assert said.startswith(told) and ("effects.elastic_slip = " in said) == (told == ABOVE) == (said != told)


def test_pressing_without_an_answer_says_that_the_surface_is_too_stiff():
    """For k near -1; friction has no part in it."""
    keys = {"solid.k": -0.95, "solid.nu": 0.3, "mesh.edge_facet": 5e-4, "mesh.first_layer": 5e-4}
    simulation = Simulation(MPI.COMM_SELF, make_scene(COARSE | SHORT | keys))
    with pytest.raises(SolveError, match="k is so close to -1 .* a larger mesh.first_layer") as said:
        simulation.run_to_end()
    assert "friction" not in str(said.value) and "load.mu or" not in str(said.value)
    assert limits.too_stiff(make_scene({"solid.k": -0.9, "solid.nu": 0.3})) == ""  # another reason
    keys |= {"mesh.edge_facet": 3e-3, "mesh.first_layer": 3e-3}
    Simulation(MPI.COMM_SELF, make_scene(COARSE | SHORT | keys)).run_to_end()


def test_a_longer_elastic_slip_is_advised_than_the_one_that_did_not_help():
    first = critical_friction.elastic_slip(coarse_simulation(**COUPLED, load__mu=2.0))
    tried = float(first.removeprefix("effects.elastic_slip = ").removesuffix(" m"))
    second = critical_friction.elastic_slip(coarse_simulation(**COUPLED, load__mu=2.0, effects__elastic_slip=tried))
    assert second == f"effects.elastic_slip = {3 * tried:.1g} m"
