"""Adding an effect takes an integrand and an entry: shown by adding one that the package does not have.

The effect: springs between the surface and the ground, as of a soft film, which resist its displacement.
"""

import numpy as np
import pytest
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from pydantic import Field
from running import coarse_overrides
from solving import coarse_simulation, solved

from forms.contact import X, Y
from simulations.runs.reference import NoReference, of_same_physics
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, effects, parse
from simulations.scene.effects import Effect, Verdict
from simulations.scene.fields import Number
from simulations.solvers.bulk_solver import bulk_solver

STIFFNESS = 2e14  # Pa/m


# --- what a new file in forms/ would hold ------------------------------------------------------------------


def spring_work(stiffness, u, v):
    """Integrand of the virtual work of springs,  ∫ κ u · v dx ."""
    return stiffness * (u[0] * v[0] + u[1] * v[1])


# --- the entry ---------------------------------------------------------------------------------------------


def springs(scene):
    """On where they have a stiffness."""
    stiffness = scene.effects.springs
    return Verdict(stiffness > 0, f"effects.springs = {stiffness:g}", "the surface is held")


def spring_term(scene, scales):
    """The term of the virtual work, stiffness in Pa/m."""
    stiffness = scene.effects.springs * scales.displacement / scales.stress
    return lambda body, v: spring_work(body.constant(stiffness), body.u, v) * body.surface_measure


ENTRY = Effect(
    "springs",
    springs,
    keys={"springs": (Number, Field(0.0, ge=0, le=1e30, description="stiffness of springs on the surface, Pa/m"))},
    work=spring_term,
)


@pytest.fixture
def with_springs():
    effects.add(ENTRY)
    yield
    effects.remove(ENTRY)


def test_the_new_effect_is_a_key_a_reason_and_a_term(with_springs):
    scene = parse(DEFAULT_SCENE, coarse_overrides(effects__springs=STIFFNESS))
    simulation = Simulation(MPI.COMM_SELF, scene)
    assert "springs" in simulation.effects
    assert "the surface is held" in str(simulation.effects)
    with pytest.raises(NoReference, match="no reference describes springs"):
        of_same_physics(simulation)
    bare = coarse_simulation(cells=simulation.cells)
    more = simulation.body.constrained_stiffness.norm() - bare.body.constrained_stiffness.norm()
    assert abs(more) > 1e-9 * bare.body.constrained_stiffness.norm()


def test_an_effect_whose_keys_are_none_is_not_added():
    """In a notebook all scenes after it would be refused."""
    before = [*effects.ALL]
    with pytest.raises(Exception, match="zed"):
        effects.add(Effect("wrong", springs, keys={"zed": 0.0}))
    assert effects.ALL == before and parse(DEFAULT_SCENE)


def test_off_it_leaves_no_trace(with_springs):
    off = coarse_simulation()
    assert off.scene.effects.springs == 0 and not off.effects.works(off.scene, off.scaled.scales)


def test_the_springs_push_back_as_the_body_without_them_says(with_springs):
    """The same surface displacement from the body alone, loaded by the contact and by the springs' own forces."""
    stiff = solved(effects__springs=STIFFNESS, load__cycles=0)
    scales, last = stiff.scaled.scales, stiff.history.entries[-1].surface
    kappa = STIFFNESS * scales.displacement / scales.stress
    forces = np.stack([last.traction - kappa * last.u[X], last.pressure - kappa * last.u[Y]], axis=1)
    bare = coarse_simulation(cells=stiff.cells)
    body, nodes = bare.body, bare.body.surface_nodes.collect(bare.body.surface_nodes.owned)
    right, u = body.stiffness.createVecLeft(), body.stiffness.createVecRight()
    right.array[body.dofs[nodes]] = last.weight[:, None] * forces
    body.set_far_field(stiff.schedule[-1].load)
    lifted = body.stiffness.createVecLeft()
    body.stiffness.mult(body.far_value.x.petsc_vec, lifted)
    right.axpy(-1.0, lifted)
    fem_petsc.set_bc(right, body.boundary_conditions)
    bulk_solver(body.constrained_stiffness, "cholesky").solve(right, u)
    for i in (X, Y):
        assert u.array[body.dofs[nodes, i]] == pytest.approx(last.u[i], abs=1e-8 * np.abs(last.u[Y]).max())
    held = np.abs(last.weight @ last.u[Y]) * kappa
    assert held > 0.05  # of P: an effect that can be seen
