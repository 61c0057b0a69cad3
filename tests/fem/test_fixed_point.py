"""Under uniform tractions, where the discrete solution is exact: contact terms vanish at it, and rest stays rest."""

import numpy as np
import pytest
from dolfinx import fem
from test_patch import DEPTH, NU, confined_block, pressed

from forms.contact import CLOSED, X, Y
from simulations.fem.contact_problem import ContactProblem, Nitsche
from simulations.fem.load import Load


@pytest.fixture(scope="module", params=[(0.0, False), (0.3, False), (0.3, True)], ids=["k=0", "k=0.3", "mixed"])
def at_rest(request):
    """The frictional problem of a block pressed and sheared, in equilibrium, and its load."""
    body, _ = confined_block(*request.param)
    load = Load(P=0.8, Q=0.2)
    problem = pressed(body, True, load, "full")
    problem.memory.come_to_rest()
    return problem, load


def test_nitsches_parameter(at_rest):
    """gamma = gamma0 degree² E/((1 - nu²) h), in s = y^(1-k), where E/(dy/ds) = 1 - k and h is a tenth of the depth."""
    terms, k = at_rest[0].terms, at_rest[0].body.modulus.k
    gamma = 10.0 * 2**2 * (1 - k) / (1 - NU**2) / (0.1 * DEPTH ** (1 - k))
    expected = np.finfo(float).eps * gamma * np.linalg.norm(terms.tributary_lengths())
    assert terms.force_per_digit == pytest.approx(expected, rel=1e-12, abs=0)


def slip_memory(problem):
    return problem.memory.anchor.x.array, problem.memory.at_rest.x.array


@pytest.mark.parametrize("theta", [-1.0, 1.0])
def test_nitsches_consistency_term_vanishes(at_rest, theta):
    """p = t_y and q = t_x: the variants of theta have the same forces, and are in equilibrium too."""
    problem, load = at_rest
    other = ContactProblem(problem.body, np.zeros_like, Nitsche(theta=theta), (X, Y), mu=0.5)
    for new, old in zip(slip_memory(other), slip_memory(problem)):
        new[:] = old
    without, forces = (fem.assemble_vector(p.terms.forces_form).array for p in (problem, other))
    assert np.abs(without).max() > 1e-2
    assert forces == pytest.approx(without, abs=1e-11)
    residual, imbalance = other.terms.residual(load)
    assert residual.norm() < 1e-10 and np.abs(imbalance).max() < 1e-10
    other.body.delta.value[Y] -= 1e-3  # away from the solution it does not vanish
    try:
        without, forces = (fem.assemble_vector(p.terms.forces_form).array for p in (problem, other))
        assert np.abs(forces - without).max() > 1e-4
    finally:
        other.body.delta.value[Y] += 1e-3


def test_a_point_at_rest_stays_where_it_is(at_rest):
    problem, _ = at_rest
    anchors = problem.memory.anchors()
    problem.memory.come_to_rest()
    assert problem.memory.anchors() == pytest.approx(anchors, abs=1e-14)
    assert np.all(problem.memory.states_at_rest() == CLOSED)


def test_held_pressure_is_that_of_the_frictionless_problem(at_rest):
    """Held where it is: with no tangential displacement of its own the tangential problem carries no traction."""
    body, _ = confined_block(0.3)
    normal = pressed(body, False, Load(0.8), "full")
    tangential = ContactProblem(body, np.zeros_like, Nitsche(), (X,), mu=0.5)
    tangential.hold_pressure(normal)
    tangential.memory.release()
    assert np.array_equal(tangential.terms.nodal_forces(Y), normal.terms.nodal_forces(Y))
    residual, imbalance = tangential.terms.residual(Load(0.8))
    assert residual.norm() < 1e-10 and abs(imbalance[0]) < 1e-12
    assert np.abs(tangential.held.remove_tangential()).max() == 0.0
