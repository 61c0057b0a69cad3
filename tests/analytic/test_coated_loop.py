"""Loops on coated bodies without load steps, beside the mesh-free solver with load steps on the same kernel."""

from functools import lru_cache

import numpy as np
import pytest

from analytic import ContactNotConverged, CoupledLoop, GradedHalfPlane, LayeredKernel, PowerProfile
from analytic.half_plane.solver import HalfPlaneContact

MU, PROFILE, Q_A = 0.3, PowerProfile(0.5, 2.0), 0.25
SHARES = 1, 0.5, 0, -0.5, -1, -0.5, 0, 0.5, 1
LOADS = [(1.0, 0.0), (1.0, Q_A / 2), *((1.0, share * Q_A) for share in SHARES)]


@lru_cache
def coated(k, thickness):
    """E = (y/thickness)^k in the coating, 1 below."""

    def modulus(y):
        return np.minimum(y / thickness, 1.0) ** k

    surface = GradedHalfPlane(1.0, 0.3, k, thickness)
    return LayeredKernel(modulus, surface, thickness, 1e-4 * min(1.0, thickness), 8.0)


def l2(state, values, expected):
    return np.sqrt(state.weight @ (values - expected) ** 2 / (state.weight @ expected**2))


def cycle(states):
    return states[-1].dissipated_energy - states[2].dissipated_energy


@pytest.mark.slow
@pytest.mark.parametrize(
    "k, thickness, coupling", [(0.3, 1.0, True), (-0.4, 0.5, True), (0.6, 0.2, True), (0.3, 0.5, False)]
)
def test_both_solvers_agree(k, thickness, coupling):
    """To what the one with load steps knows. Between orders of the basis this one differs by a hundredth of that."""
    kernel = coated(k, thickness)
    states, lower = (CoupledLoop(kernel, PROFILE, 1.0, MU, coupling, order).run(LOADS) for order in (10, 8))
    stepped = HalfPlaneContact(kernel, PROFILE, MU, coupling=coupling, nodes=300).run(LOADS)
    for state, other, expected in list(zip(states, lower, stepped, strict=True))[1:]:
        for name, limit in (("pressure_at", 1e-3), ("traction_at", 5e-3), ("slip_at", 2e-3)):
            found, less, apart = (getattr(solution, name)(state.x) for solution in (state, other, expected))
            assert l2(state, apart, found) < limit, name
            assert l2(state, less, found) < 1e-4, name
        assert state.contact == pytest.approx(expected.contact, abs=2e-4)
        assert state.stick == pytest.approx(expected.stick, abs=2e-3)
        assert other.stick == pytest.approx(state.stick, abs=2e-5)
    assert cycle(stepped) == pytest.approx(cycle(states), rel=2e-3)
    assert cycle(lower) == pytest.approx(cycle(states), rel=2e-5)


@pytest.mark.parametrize("k, thickness", [(0.5, 0.3), (-0.4, 0.5)])
def test_conditions_and_balances_on_a_coating(k, thickness):
    states = CoupledLoop(coated(k, thickness), PROFILE, 1.0, MU).run(LOADS[:5])
    for before, state in zip(states, states[1:], strict=False):
        assert state.weight @ state.pressure == pytest.approx(1.0, rel=1e-6)
        assert state.weight @ state.traction == pytest.approx(state.Q, abs=1e-6)
        assert (np.abs(state.traction) - MU * state.pressure).max() < 1e-5 * state.pressure.max()
        stuck = np.linspace(*state.stick, 30)[1:-1]
        slipping = (state.x < state.stick[0]) | (state.x > state.stick[1])
        step = state.slip_at(stuck) - before.slip_at(stuck)
        assert np.abs(step).max() < 1e-5 * np.abs(state.slip[slipping]).max()
        assert state.dissipated_energy > before.dissipated_energy


def test_a_coating_like_its_substrate():
    """The energy too, though the compliance of full stick is continued from a few loads and not in closed form."""
    states = CoupledLoop(coated(0.0, 0.5), PROFILE, 1.0, MU).run(LOADS[:7])
    plain = CoupledLoop(GradedHalfPlane(1.0, 0.3, 0.0, 1.0), PROFILE, 1.0, MU).run(LOADS[:7])
    for state, expected in zip(states[1:], plain[1:], strict=True):
        edges = (*expected.contact, *expected.stick)
        assert (*state.contact, *state.stick) == pytest.approx(edges, abs=1e-8)
        assert state.dissipated_energy == pytest.approx(expected.dissipated_energy, rel=2e-6)


def test_a_coating_pressed_with_friction_is_refused():
    with pytest.raises(ContactNotConverged, match="on layers"):
        CoupledLoop(coated(0.3, 0.5), PROFILE, 1.0, MU, friction_first=True).run(LOADS[:2])
