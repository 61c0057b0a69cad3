"""Every Jacobian against finite differences, at states with open, closed, stuck and sliding points."""

import numpy as np
import pytest
from conftest import coarse_overrides
from mpi4py import MPI

from simulations.fem.body import X, Y
from simulations.fem.contact_problem import ContactProblem, Nitsche
from simulations.run.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, parse
from simulations.solvers.condensed.compliance import Compliance
from simulations.solvers.condensed.system import CondensedSystem
from simulations.solvers.full import FullSystem

STEP = 1e-7


@pytest.fixture(scope="module", params=["plain", "mixed"])
def partly_slipping(request):
    """A body in partial slip at Q = +Q_A/2 on the first loading, the load, and the programme's frictional problem."""
    mixed = str(request.param == "mixed").lower()
    simulation = Simulation(MPI.COMM_SELF, parse(DEFAULT_SCENE, coarse_overrides(effects__incompressibility=mixed)))
    states = simulation.run()
    next(states)
    entry = next(states)
    simulation.body.complete()
    return simulation, entry.increment.load


def relative_defect(system, load, rng):
    """|J d - (F(x + h d) - F(x - h d)) / 2h| / |J d| at the fields' state, along a random d."""
    x, direction, image, plus, minus = (system.create_vector() for _ in range(5))
    system.begin(load, x)
    system.linearise(x)
    system.solve(x, image)  # removes what the condensed system carries over from the fields
    system.linearise(x)
    direction.array[:] = rng.standard_normal(direction.local_size)
    if isinstance(system, FullSystem):  # prescribed displacements do not vary
        direction.array[system.problem.body.fixed_dofs] = 0.0
    direction.scale(STEP * x.norm() / direction.norm())
    system.multiply(direction, image)
    system.residual(x + direction, plus)
    system.residual(x - direction, minus)
    defect = (plus - minus) * 0.5 - image
    return defect.norm() / image.norm()


@pytest.mark.parametrize("all_stick", [0.0, 1.0])
@pytest.mark.parametrize("theta", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("friction", [False, True])
def test_full_system(partly_slipping, friction, theta, all_stick):
    simulation, load = partly_slipping
    problem = perturbed_problem(simulation, friction, theta, all_stick)
    assert relative_defect(FullSystem(problem), load, np.random.default_rng(1)) < 1e-6


@pytest.mark.parametrize("friction", [False, True])
def test_condensed_system(partly_slipping, friction):
    simulation, load = partly_slipping
    problem = perturbed_problem(simulation, friction, theta=0.0, all_stick=0.0)
    system = CondensedSystem(problem, Compliance(simulation.body))
    assert relative_defect(system, load, np.random.default_rng(1)) < 1e-6


def perturbed_problem(simulation, friction, theta, all_stick):
    """A problem on the body whose anchor and friction make some points stick and some slide."""
    nitsche, directions = Nitsche(gamma0=3.0, theta=theta), (X, Y) if friction else (Y,)
    problem = ContactProblem(simulation.body, simulation.scaled.indenter.height, nitsche, directions)
    if friction:
        problem.mu.value = simulation.scene.load.mu
        problem.release()
        problem.anchor.x.array[:] -= 1e-2 * np.random.default_rng(2).random(problem.anchor.x.array.size)
    problem.all_stick.value = all_stick
    return problem
