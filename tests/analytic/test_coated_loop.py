"""Loops on coated bodies without load steps, beside the mesh-free solver with load steps on the same kernel."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.special import beta, betainc

from analytic import ContactNotConverged, CoupledLoop, GradedHalfPlane, LayeredKernel, PowerProfile
from analytic.coupled.pressed import NormalStage
from analytic.coupled.rule import ContactRule, smooth_rule
from analytic.coupled.weight import ContactInterval
from analytic.half_plane.solver import HalfPlaneContact

MU, PROFILE, Q_A = 0.3, PowerProfile(0.5, 2.0), 0.25
SHARES = 1, 0.5, 0, -0.5, -1, -0.5, 0, 0.5, 1
LOADS = [(1.0, 0.0), (1.0, Q_A / 2), *((1.0, share * Q_A) for share in SHARES)]


def kernel_of(law, k, thickness):
    """E = law(depth over the thickness) in the coating, constant below."""
    surface = GradedHalfPlane(1.0, 0.3, k, thickness)
    return LayeredKernel(
        lambda y: law(np.minimum(y / thickness, 1.0)), surface, thickness, 1e-4 * min(1.0, thickness), 8.0
    )


@lru_cache
def coated(k, thickness):
    """E = (y/thickness)^k in the coating, 1 below."""
    return kernel_of(lambda y: y**k, k, thickness)


@lru_cache
def sloped(law, ratio, thickness):
    """E from 1 at the surface to the ratio below."""
    laws = {"linear": lambda y: 1 + (ratio - 1) * y, "exponential": lambda y: ratio**y}
    return kernel_of(laws[law], 0.0, thickness)


def l2(state, values, expected):
    return np.sqrt(state.weight @ (values - expected) ** 2 / (state.weight @ expected**2))


def cycle(states):
    return states[-1].dissipated_energy - states[2].dissipated_energy


@pytest.mark.slow
@pytest.mark.parametrize(
    "body, coupling, between",
    [
        ((coated, 0.3, 1.0), True, 1e-4),
        ((coated, -0.4, 0.5), True, 1e-4),
        ((coated, 0.6, 0.2), True, 1e-4),
        ((coated, 0.3, 0.5), False, 1e-4),
        ((sloped, "linear", 3.0, 1.0), True, 2e-4),
        ((sloped, "linear", 0.5, 1.0), False, 2e-4),
        ((sloped, "exponential", 0.3, 0.5), True, 5e-4),
    ],
)
def test_both_solvers_agree(body, coupling, between):
    """To what the one with load steps knows. Between orders of the basis this one differs by far less."""
    kernel = body[0](*body[1:])
    states, lower = (CoupledLoop(kernel, PROFILE, 1.0, MU, coupling, order).run(LOADS) for order in (10, 8))
    stepped = HalfPlaneContact(kernel, PROFILE, MU, coupling=coupling, nodes=300).run(LOADS)
    for state, other, expected in list(zip(states, lower, stepped, strict=True))[1:]:
        for name, limit in (("pressure_at", 1e-3), ("traction_at", 5e-3), ("slip_at", 2e-3)):
            found, less, apart = (getattr(solution, name)(state.x) for solution in (state, other, expected))
            assert l2(state, apart, found) < limit, name
            assert l2(state, less, found) < between, name
        assert state.contact == pytest.approx(expected.contact, abs=2e-4)
        assert state.stick == pytest.approx(expected.stick, abs=2e-3)
        assert other.stick == pytest.approx(state.stick, abs=between / 5)
    assert cycle(stepped) == pytest.approx(cycle(states), rel=2e-3)
    assert cycle(lower) == pytest.approx(cycle(states), rel=between / 5)


@pytest.mark.parametrize(
    "body, rest",
    [
        ((coated, 0.5, 0.3), 1e-6),
        ((coated, -0.4, 0.5), 1e-6),
        ((sloped, "linear", 3.0, 1.0), 5e-6),
        ((sloped, "linear", 0.3, 1.0), 5e-6),
        ((sloped, "exponential", 3.0, 0.6), 5e-6),
    ],
)
def test_conditions_and_balances_on_a_coating(body, rest):
    """On kernels with kinks edges rest at amplitudes of 1e-6."""
    states = CoupledLoop(body[0](*body[1:]), PROFILE, 1.0, MU).run(LOADS[:5])
    for before, state in zip(states, states[1:], strict=False):
        assert state.weight @ state.pressure == pytest.approx(1.0, rel=rest)
        assert state.weight @ state.traction == pytest.approx(state.Q, abs=rest)
        assert (np.abs(state.traction) - MU * state.pressure).max() < 1e-5 * state.pressure.max()
        stuck = np.linspace(*state.stick, 30)[1:-1]
        slipping = (state.x < state.stick[0]) | (state.x > state.stick[1])
        step = state.slip_at(stuck) - before.slip_at(stuck)
        assert np.abs(step).max() < 1e-5 * np.abs(state.slip[slipping]).max()
        assert state.dissipated_energy > before.dissipated_energy


@pytest.mark.parametrize("body", [(coated, 0.5, 0.3), (sloped, "linear", 3.0, 1.0)])
def test_displacements_are_those_of_the_kernel(body):
    """Summed over the tractions with another rule, up to a constant."""
    kernel = body[0](*body[1:])
    pressed, *_, state = CoupledLoop(kernel, PROFILE, 1.0, MU).run(LOADS[:3])

    def summed(x, state):
        s, weight = smooth_rule(*state.contact, [*state.contact, *np.ravel(state.stick_zones), x])
        N, T, D = kernel.values(np.abs(x - s))
        p, q, D = state.pressure_at(s), state.traction_at(s), np.sign(x - s) * D
        return np.array([weight @ (T * q + D * p), weight @ (N * p - D * q)])

    assert np.ptp([summed(x, state)[1] + PROFILE.height(x) for x in np.linspace(*state.contact, 6)[1:-1]]) < 1e-4
    scaled = state._state
    x = np.linspace(*scaled.contact, 20)[1:-1]
    assert np.abs(scaled.displacements(x)[1] + scaled.problem.height(x)).max() < 1e-4
    points = np.array([-1.3, 0.95, 0.1, 0.2]) * state.contact[1]
    expected = [summed(x, state)[0] - summed(x, pressed)[0] for x in points]
    assert np.diff(state.slip_at(points)) == pytest.approx(np.diff(expected), abs=5e-5 * np.ptp(expected))


@pytest.mark.parametrize("place", [1e-3, 8e-3, 0.3, 0.6])
def test_tractions_up_to_a_point(place):
    """∫ sgn(x - s) w f ds, also where x is in the piece at an edge that has a rule of its own."""
    stage = NormalStage(sloped("linear", 3.0, 1.0), PROFILE, 1.0, MU, True, 10)
    area = ContactInterval(stage.problem, MU, -1.0, 1.0)
    rule, x = ContactRule(area, (-0.3, 0.3)), np.array([-1.0 + place, 1.0 - place])
    shares = betainc(area.left + 1, area.right + 1, (x + 1) / 2)
    whole = 2 ** (area.left + area.right + 1) * beta(area.left + 1, area.right + 1)
    assert rule.sign(x) @ rule.w == pytest.approx((2 * shares - 1) * whole, rel=1e-9)


def test_without_coupling_the_contact_stays():
    pressed, *states = CoupledLoop(sloped("linear", 3.0, 1.0), PROFILE, 1.0, MU, False).run(LOADS[:3])
    assert all(state.contact == pytest.approx(pressed.contact, abs=2e-6) for state in states)


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


@pytest.mark.parametrize("solver", [HalfPlaneContact, lambda *args: CoupledLoop(*args[:2], 1.0, MU)])
def test_contacts_wider_than_their_kernel_are_refused(solver):
    """Beyond its largest distance a kernel is extrapolated: the pressure was off by 2 % without a word."""
    kernel = replace(coated(0.3, 0.5), largest=0.5)
    with pytest.raises(ValueError, match="up to distances of 0.5 only"):
        solver(kernel, PROFILE, MU).run(LOADS[:1])
