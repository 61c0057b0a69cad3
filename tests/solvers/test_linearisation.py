"""Every Jacobian against finite differences, at states with open, closed, stuck and sliding points."""

from contextlib import ExitStack

import numpy as np
import pytest
from mpi4py import MPI
from running import coarse_overrides
from scipy.sparse import identity

from forms.contact import BACKWARD, CLOSED, DRIVEN_BACKWARD, DRIVEN_FORWARD, FORWARD, LIFTED, OPEN, PINNED, X, Y
from simulations.fem.contact_problem import ContactProblem, Nitsche
from simulations.fem.surface import SurfaceSampler
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, parse
from simulations.solvers.condensed.surface_compliance import SurfaceCompliance
from simulations.solvers.condensed.system import CondensedSystem
from simulations.solvers.full import FullSystem

STEP = 1e-7
FRICTIONLESS, FRICTIONAL, HELD_PRESSURE = (Y,), (X, Y), (X,)
EVERY_CASE = pytest.mark.parametrize(
    "directions", [FRICTIONLESS, FRICTIONAL, HELD_PRESSURE], ids=["frictionless", "frictional", "held pressure"]
)


@pytest.fixture(scope="module", params=["plain", "mixed"])
def partly_slipping(request):
    """A simulation on the first loading, its frictionless state, that in partial slip at Q = +Q_A/2, and the load."""
    mixed = str(request.param == "mixed").lower()
    simulation = Simulation(MPI.COMM_SELF, parse(DEFAULT_SCENE, coarse_overrides(effects__incompressibility=mixed)))
    states = simulation.run()
    next(states)
    simulation.body.complete()
    pressed = simulation.body.state.x.array.copy()
    entry = next(states)
    simulation.body.complete()
    return simulation, pressed, simulation.body.state.x.array.copy(), entry.step.load


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


@pytest.mark.parametrize("all_stick", [False, True])
@pytest.mark.parametrize("theta", [-1.0, 0.0, 1.0])
@EVERY_CASE
def test_full_system(partly_slipping, directions, theta, all_stick):
    problem, load = perturbed_problem(partly_slipping, directions, theta), partly_slipping[-1]
    with ExitStack() as stack:
        if all_stick and problem.safeguards:
            stack.enter_context(problem.safeguards.all_stick())
        assert relative_defect(FullSystem(problem), load, np.random.default_rng(1)) < 1e-6


@EVERY_CASE
def test_condensed_system(partly_slipping, directions):
    problem, load = perturbed_problem(partly_slipping, directions, theta=0.0), partly_slipping[-1]
    system = CondensedSystem(problem, SurfaceCompliance(problem.body))
    assert relative_defect(system, load, np.random.default_rng(1)) < 1e-6


def test_the_frictionless_form_is_symmetric_with_theta_1(partly_slipping):
    tangent = perturbed_problem(partly_slipping, FRICTIONLESS, theta=1.0).terms.force_tangent()
    assert abs(tangent - tangent.T).max() < 1e-12 * abs(tangent).max()


@EVERY_CASE
def test_rows_of_the_compliance_matrix_and_its_products(partly_slipping, directions):
    """Rows are kept; a product solves for the inside of the strip. The surface's own share is symmetric (Maxwell)."""
    compliance = SurfaceCompliance(partly_slipping[0].body)
    matrix = compliance.matrix(directions)
    forces = np.random.default_rng(3).standard_normal(matrix.shape[1])
    rows = matrix.times(identity(matrix.shape[0], format="csr"))
    assert matrix.apply(forces) == pytest.approx(rows @ forces, abs=1e-11 * np.abs(rows @ forces).max())
    nodal = compliance.nodal(np.ones(compliance.n, bool))
    assert nodal == pytest.approx(nodal.T, abs=1e-10 * nodal.max())


@EVERY_CASE
def test_the_states_are_all_there(partly_slipping, directions):
    """What the differences are taken at: open and closed points, with friction also points that slide.

    Those and no others have a clearance that are open: the trial pressure over gamma, which is one number here.
    """
    terms = perturbed_problem(partly_slipping, directions, theta=0.0).terms
    if terms.clearance:
        clearance = terms.clearance.values()
        opened = terms.contact_states() == OPEN
        assert np.array_equal(clearance > 0, opened)
        gamma = -terms.trials()[Y][opened] / clearance[opened]
        assert gamma == pytest.approx(gamma[0], rel=1e-9)
    states = set(terms.contact_states())
    assert {OPEN, CLOSED} <= states
    assert bool({FORWARD, BACKWARD} & states) == (X in directions)


@pytest.mark.parametrize(
    "imposed, state", [(DRIVEN_BACKWARD, BACKWARD), (PINNED, CLOSED), (DRIVEN_FORWARD, FORWARD), (LIFTED, OPEN)]
)
def test_points_in_contact_have_the_state_that_is_imposed(partly_slipping, imposed, state):
    """Open ones have no traction, whatever is imposed on them."""
    problem = perturbed_problem(partly_slipping, FRICTIONAL, theta=0.0)
    free = problem.terms.contact_states()
    with problem.safeguards.imposed(np.full(len(free), imposed)):
        assert np.array_equal(problem.terms.contact_states(), np.where(free == OPEN, OPEN, state))
        surface = SurfaceSampler(problem).sample(problem)
        assert not np.any(surface.traction[surface.pressure == 0])
    assert np.array_equal(problem.terms.contact_states(), free)


def test_without_coupling_the_gap_is_that_of_the_pressure_alone(partly_slipping):
    """And slip that of the traction."""
    problem = perturbed_problem(partly_slipping, HELD_PRESSURE, theta=0.0)
    sampler = SurfaceSampler(problem, uncoupled=True)
    sheared = sampler.sample(problem)
    problem.held.remove_tangential()
    pressed = sampler.sample(problem)
    assert np.abs(sheared.u[Y] - pressed.u[Y]).max() > 1e-5
    assert sheared.approach == pytest.approx(pressed.approach, abs=1e-12)
    assert pressed.relative_displacement == pytest.approx(-pressed.delta[X], abs=1e-12)


def test_points_that_are_released_have_no_traction(partly_slipping):
    """Friction starts so after pressing, whatever the traction of the displacements is then."""
    problem = perturbed_problem(partly_slipping, FRICTIONAL, theta=0.0)
    problem.memory.release()
    assert np.abs(problem.terms.trials()[X]).max() < 1e-12


def perturbed_problem(partly_slipping, directions, theta):
    """A problem on the body whose anchor and friction make some points stick and some slide."""
    simulation, pressed, slipping, _ = partly_slipping
    body, height, mu = simulation.body, simulation.scaled.indenter.height, simulation.scene.load.mu
    nitsche = Nitsche(gamma0=3.0, theta=theta)
    body.state.x.array[:] = slipping  # other tests have moved it
    problem = ContactProblem(body, height, nitsche, directions, mu)
    if directions == HELD_PRESSURE:
        body.state.x.array[:] = pressed
        problem.hold_pressure(ContactProblem(body, height, nitsche, FRICTIONLESS))
        body.state.x.array[:] = slipping
    if problem.friction:
        problem.memory.release()
        anchor = problem.memory.anchor.x.array
        anchor -= 1e-2 * np.random.default_rng(2).random(anchor.size)
    return problem
