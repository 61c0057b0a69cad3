"""Coupled contact on any path of the tangential load: turns within earlier turns and past them."""

from itertools import pairwise

import numpy as np
import pytest

from analytic import CylinderContact, GradedHalfPlane, PowerProfile, SpringPath
from analytic.coupled import CoupledLoop
from analytic.coupled.loop import branches_of
from analytic.half_plane.solver import HalfPlaneContact

MU, R, P = 0.3, 2.0, 1.5
PROFILE = PowerProfile(1 / (2 * R), 2.0)


def solid_of(k):
    return GradedHalfPlane(7.0, 0.3, k, 0.6)


def states(k, *shares, coupling=True, order=8):
    """At the end of the normal stage, and at these shares of mu P."""
    path = [(P, share * MU * P) for share in (0.0, *shares)]
    return CoupledLoop(solid_of(k), PROFILE, P, MU, coupling, order).run(path)


@pytest.mark.parametrize("k", [-0.4, 0.3])
def test_without_coupling_the_springs(k):
    """The last turn goes past the two of a loop within a loop, and on to where the larger one began."""
    shares = 0.5, -0.8, 0.3, 0.0, 0.6
    exact = SpringPath(CylinderContact(solid_of(k), R, P), MU).run([(P, share * MU * P) for share in (0.0, *shares)])
    for state, springs in zip(states(k, *shares, coupling=False)[1:], exact[1:], strict=True):
        assert np.abs(state.stick) == pytest.approx(springs.stick_half_width, rel=1e-7)
        assert state.dissipated_energy == pytest.approx(springs.dissipated_energy, rel=1e-5)


@pytest.mark.parametrize("k", [-0.3, 0.0])
def test_a_nested_loop_leaves_no_trace_beyond_it(k):
    """What sticks at 0.9 never slid, and elsewhere q = mu p: the way back from 0.6 to 0.2 is forgotten."""
    nested, direct = states(k, 0.6, 0.2, 0.9)[-1], states(k, 0.9)[-1]
    assert nested.stick == pytest.approx(direct.stick, rel=1e-6)
    inner = np.linspace(*direct.contact, 60)[1:-1]
    assert nested.traction_at(inner) == pytest.approx(direct.traction_at(inner), rel=1e-5)
    assert nested.dissipated_energy > direct.dissipated_energy


def test_energy_of_loops_that_grow():
    """Past each turn before, a stretch of stick slides all at once: guessed without that, the energy was 0.3 % off."""
    solid, mu = GradedHalfPlane(1.0, 0.17, 0.54, 1.0), 0.46
    path = [(1.0, mu * share) for share in (0.0, 0.2, -0.2, 0.55, -0.55, 0.9)]
    energy = CoupledLoop(solid, PROFILE, 1.0, mu, order=8).run(path)[-1].dissipated_energy
    ways = [(before, after, t) for (_, before), (_, after) in pairwise(path) for t in np.arange(1, 11) / 10]
    steps = [(1.0, 0.0), *((1.0, before + (after - before) * t) for before, after, t in ways)]
    stepped = HalfPlaneContact(solid, PROFILE, mu=mu, nodes=100).run(steps)[-1]
    assert energy == pytest.approx(stepped.dissipated_energy, rel=1e-3)


def test_energy_since_a_turn_needs_nothing_from_before():
    """Equal to the difference of energies since first contact, without the states that the first way would need."""
    _, turn, state = CoupledLoop(solid_of(0.3), PROFILE, P, MU, order=6).run([(P, Q) for Q in (0.0, 0.2, -0.1)])
    since = state.dissipated_since(turn)
    assert "nodes" not in vars(turn.branch)
    assert since == pytest.approx(state.dissipated_energy - turn.dissipated_energy, rel=1e-12)
    assert since > 0 == turn.dissipated_since(turn)


def test_branches():
    assert branches_of([0.5, 1.0, 1.0, 0.5, -1.0, 0.0]) == [(1.0, [0.5, 1.0, 1.0]), (-1.0, [0.5, -1.0]), (1.0, [0.0])]


def test_rounding_of_loads_is_no_turn():
    """0.1 + 0.2 is above 0.3: loads that rounding tells apart are one load, also where they should be none."""
    noisy, exact = (
        CoupledLoop(solid_of(0.3), PROFILE, P, MU).run([(P, Q) for Q in (0.0, zero, Q_A, 0.3, 0.1)])
        for zero, Q_A in ((-1e-17, 0.1 + 0.2), (0.0, 0.3))
    )
    for state, other in zip(noisy, exact, strict=True):
        assert (state.stick, state.delta_x) == (pytest.approx(other.stick, nan_ok=True), pytest.approx(other.delta_x))
        assert state.dissipated_energy == pytest.approx(other.dissipated_energy)
