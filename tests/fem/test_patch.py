"""Patch tests: under uniform pressure and traction the discrete solution is exact, graded or not."""

import numpy as np
import pytest
from mpi4py import MPI

from forms.contact import X, Y
from forms.modulus import PowerLaw
from simulations.fem.body import ElasticBody
from simulations.fem.contact_problem import ContactProblem, Nitsche
from simulations.fem.load import Load
from simulations.fem.mesh import create_mesh
from simulations.fem.surface import SurfaceSampler
from simulations.solvers.condensed.surface_compliance import SurfaceCompliance
from simulations.solvers.condensed.system import CondensedSystem
from simulations.solvers.full import FullSystem
from simulations.solvers.newton import Newton

WIDTH, DEPTH, NU = 2.0, 1.5, 0.3


def confined_block(k, mixed=False):
    """A block on a rigid base, sides guided; its u under uniform p = P/WIDTH, q = Q/WIDTH is linear in y^(1-k)."""
    modulus = PowerLaw.of(k)
    depth = modulus.depth_map()
    constrained = (1 - NU) / ((1 + NU) * (1 - 2 * NU))
    shear = 1 / (2 * (1 + NU))

    def exact(x, y, P=0.0, Q=0.0):
        compression = (DEPTH ** (1 - k) - y ** (1 - k)) / (1 - k)
        return np.stack([Q / WIDTH / shear * compression, P / WIDTH / constrained * compression])

    x = np.array([-1.0, -0.7, -0.2, 0.1, 0.6, 1.0])
    mesh, facets = create_mesh(MPI.COMM_SELF, x, depth.s(DEPTH) * np.array([0.0, 0.1, 0.3, 1.0]))
    return ElasticBody(mesh, facets, modulus, NU, exact, WIDTH, mixed), exact


def pressed(body, friction, load, method) -> ContactProblem:
    """In equilibrium with a flat punch that covers the whole surface: pressed first, then sheared."""
    compliance = SurfaceCompliance(body)
    body.delta.value[:] = (0.0, 0.1)
    stages = [(False, Load(load.P)), (True, load)]
    for with_friction, stage_load in stages[: 1 + friction]:
        problem = ContactProblem(body, np.zeros_like, Nitsche(), (X, Y) if with_friction else (Y,), mu=0.5)
        if with_friction:
            problem.memory.release()
        system = FullSystem(problem) if method == "full" else CondensedSystem(problem, compliance)
        result = Newton(system).solve(stage_load, predict=with_friction)
        assert result.converged, result.reason
    return problem


def test_a_modulus_infinite_on_the_surface_is_exact_in_the_mean():
    """Twice the energy of a uniform compression: its stiffness times the integral of y^k, to the last digits."""
    body, _ = confined_block(k := -0.4)
    body.state.interpolate(lambda x: np.stack([0 * x[1], x[1]]))
    force = body.stiffness.createVecLeft()
    body.stiffness.mult(body.state.x.petsc_vec, force)
    constrained = (1 - NU) / ((1 + NU) * (1 - 2 * NU))
    expected = constrained * WIDTH * DEPTH ** (1 + k) / (1 + k)
    assert body.state.x.petsc_vec.dot(force) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("method", ["full", "condensed"])
@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("k, mixed", [(0.0, False), (0.3, False), (0.7, False), (0.0, True), (0.3, True)])
def test_uniform_tractions(k, mixed, friction, method):
    body, exact = confined_block(k, mixed)
    load = Load(P=0.8, Q=0.2 if friction else 0.0)
    problem = pressed(body, friction, load, method)
    state = SurfaceSampler(problem).sample(problem)
    u = exact(0.0, 0.0, P=load.P, Q=load.Q)
    assert state.pressure == pytest.approx(load.P / WIDTH, rel=1e-9)
    assert state.traction == pytest.approx(load.Q / WIDTH, rel=1e-9, abs=1e-12)
    assert state.u[1] == pytest.approx(u[1], rel=1e-9)
    assert state.delta[1] == pytest.approx(u[1], rel=1e-9)
    if friction:
        assert state.delta[0] == pytest.approx(u[0], rel=1e-9)
