"""The contact solver: against the closed forms without coupling, known limits with it, and its own balances."""

from functools import lru_cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import ellipk, ellipkm1

from analytic import (
    ContactNotConverged,
    CylinderContact,
    GradedHalfPlane,
    PowerProfile,
    Profile,
    ProfileContact,
    StretchedLoop,
)
from analytic.half_plane.solver import HalfPlaneContact

MU, P, R = 0.3, 1.0, 1.0
Q_A = 0.9 * MU * P
PROFILE = PowerProfile(1 / (2 * R), 2.0)


def solid_of(k, nu=0.3):
    return GradedHalfPlane(1.0, nu, k, 1.0)


def cycle(increments):
    """Loads from Q_A over -Q_A back to Q_A."""
    return [*np.linspace(Q_A, -Q_A, increments // 2 + 1)[1:], *np.linspace(-Q_A, Q_A, increments // 2 + 1)[1:]]


@lru_cache
def loop(k, nu=0.3, coupling=True, increments=8, cycles=1, nodes=300, scale=1.0):
    """States after the normal stage and at the loads Q_A, then of the cycles; lengths times ``scale``."""
    solid = GradedHalfPlane(1.0, nu, k, scale)
    profile = PowerProfile(1 / (2 * R * scale), 2.0)
    loads = [(P * scale, Q * scale) for Q in (0.0, Q_A, *(cycles * cycle(increments)))]
    return HalfPlaneContact(solid, profile, MU, coupling=coupling, nodes=nodes).run(loads)


def error(state, values, expected):
    """Relative L2 error."""
    return np.sqrt(state.weight @ (values - expected) ** 2 / (state.weight @ expected**2))


# -- coupling off: the closed forms --------------------------------------------------------------------------------


def assert_closed_forms(states, contact):
    """States of a loop of eight increments a cycle: p, q, slip and edges at A, B, C, D, E and the energy to 1e-4."""
    exact = contact.fretting(MU, Q_A)
    for index, branch in [(1, "initial"), (2, "unloading"), (3, "unloading"), (4, "unloading"), (5, "unloading")]:
        state = states[index]
        inside = np.abs(state.x) < contact.a
        assert error(state, state.pressure, contact.pressure(state.x)) < 1e-4
        q = exact.traction(state.x, state.Q, branch)
        assert error(state, state.traction, q) < 1e-4
        slip = np.where(inside, exact.slip(np.where(inside, state.x, 0.0), state.Q, branch), 0.0)
        assert error(state, np.where(inside, -state.slip, 0.0), slip) < 1e-4
        assert state.contact == pytest.approx((-contact.a, contact.a), rel=1e-4)
        d = exact.active_half_width(state.Q, branch)
        assert state.stick == pytest.approx((-d, d), rel=1e-4)
    energy = states[-1].dissipated_energy - states[1].dissipated_energy
    assert energy == pytest.approx(exact.dissipated_energy, rel=1e-4)


@pytest.mark.parametrize(("k", "nodes"), [(-0.5, 500), (-0.3, 400), (0.0, 300), (0.3, 300), (0.9, 200)])
def test_without_coupling_the_closed_forms(k, nodes):
    """p, q, slip and edges at A, B, C, D, E and the energy of the loop to 1e-4."""
    contact = CylinderContact(solid_of(k), R, P)
    states = loop(k, coupling=False, nodes=nodes)
    assert_closed_forms(states, contact)


ROUNDED = Profile(lambda u: u**2 / 2, lambda u: u, np.ones_like, flat=0.4)
ARC = Profile(  # of radius 5
    lambda u: u**2 / (5 + np.sqrt(25 - u**2)), lambda u: u / np.sqrt(25 - u**2), lambda u: 25 / (25 - u**2) ** 1.5
)


@pytest.mark.parametrize(
    ("profile", "a_max"),
    [(PowerProfile(0.5, 3.0), 3.0), (PowerProfile(0.5, 4.0), 3.0), (ROUNDED, 4.0), (ARC, 4.9)],
    ids=["cubic", "quartic", "rounded flat", "arc"],
)
@pytest.mark.parametrize(("k", "nodes"), [(0.0, 450), (0.3, 450), (0.9, 450)])
def test_other_profiles_without_coupling(profile, a_max, k, nodes):
    """p, q, slip, edges and energy of the loop against the closed forms of any profile."""
    contact = ProfileContact.from_load(solid_of(k), profile, P, a_max=a_max)
    loads = [(P, Q) for Q in (0.0, Q_A, *cycle(8))]
    states = HalfPlaneContact(solid_of(k), profile, MU, coupling=False, nodes=nodes).run(loads)
    assert_closed_forms(states, contact)


def test_profile_that_ends_is_refused_by_name():
    with pytest.raises(ValueError, match="the profile has no height at x = "):
        HalfPlaneContact(solid_of(0.3), ARC, MU, nodes=60).run([(99 * P, 0.0)])


@pytest.mark.parametrize("k", [-0.3, 0.3])
def test_bulk_strain_moves_the_zone_of_stick(k):
    """[X7] at +Q_A, 0 and -Q_A, 0.7 of the largest strain: q and the zone of stick."""
    contact = CylinderContact(solid_of(k), R, P)
    exact = contact.fretting(MU, Q_A)
    exact = StretchedLoop(exact, 0.7 * StretchedLoop(exact, 0.0).largest_strain)
    shares = [0.0, 0.25, 0.5, 0.75, 1.0, 0.5, 0.0, -0.5, -1.0]
    solver = HalfPlaneContact(solid_of(k), PROFILE, MU, coupling=False, nodes=300)
    states = solver.run([(P, share * Q_A, share * exact.strain) for share in shares])
    for index, branch in [(4, "initial"), (6, "unloading"), (8, "unloading")]:
        state = states[index]
        inside = np.abs(state.x) < contact.a
        q = np.where(inside, exact.traction(np.clip(state.x, -contact.a, contact.a), state.Q, branch), 0.0)
        assert error(state, state.traction, q) < 1e-4
        centre, half_width = exact.zone(state.Q, branch)
        assert state.stick == pytest.approx((centre - half_width, centre + half_width), abs=2e-5 * contact.a)


# -- coupling on ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [0.0, 0.3, 0.9])
def test_holl_ratio_decouples(k):
    nu = GradedHalfPlane.holl_ratio(k)
    coupled, uncoupled = (loop(k, nu, coupling, nodes=200) for coupling in (True, False))
    for state, other in zip(coupled, uncoupled, strict=True):
        assert state.contact == pytest.approx(other.contact, rel=1e-9)
        assert np.abs(state.traction - np.interp(state.x, other.x, other.traction)).max() < 1e-8 * state.pressure.max()
    assert coupled[-1].dissipated_energy == pytest.approx(uncoupled[-1].dissipated_energy, rel=1e-9)


@pytest.mark.parametrize(
    ("k", "nu", "p_percent", "q_percent", "energy_percent"),
    [(0.3, 0.3, 7.3, 8.5, 5.5), (0.0, 0.3, 11, 13.5, 12.5), (-0.1, 0.495, 2.7, 3.5, 0.5)],
)
def test_coupling_is_not_small(k, nu, p_percent, q_percent, energy_percent):
    """Difference to the closed forms at Q_A, as finite elements and another boundary-element solver have it."""
    exact = CylinderContact(solid_of(k, nu), R, P).fretting(MU, Q_A)
    states = loop(k, nu)
    state = states[1]
    assert 100 * error(state, state.pressure, exact.contact.pressure(state.x)) == pytest.approx(p_percent, abs=0.2)
    assert 100 * error(state, state.traction, exact.amplitude.traction(state.x)) == pytest.approx(q_percent, abs=0.2)
    energy = states[-1].dissipated_energy - states[1].dissipated_energy
    assert 100 * (1 - energy / exact.dissipated_energy) == pytest.approx(energy_percent, abs=0.7)


def test_goodman_limit_of_friction_from_first_contact():
    """k = 0, small mu and nearly incompressible: the stick zone of Goodman and Spence, K'(c/a)/K(c/a) = beta/mu.

    beta = (1-2nu)/(2-2nu). Increments of constant ratio have an error of first order, which is extrapolated.
    """
    nu, mu = 0.49, 0.02
    beta = (1 - 2 * nu) / (2 - 2 * nu)
    expected = brentq(lambda m: ellipkm1(m**2) / ellipk(m**2) - beta / mu, 0.01, 0.99, xtol=1e-12)
    ratio = []
    for increments in (10, 20, 40):
        solver = HalfPlaneContact(solid_of(0.0, nu), PROFILE, mu, friction_in_normal_stage=True, nodes=150)
        state = solver.run([(load, 0.0) for load in np.geomspace(0.02, P, increments)])[-1]
        assert state.stick[0] == pytest.approx(-state.stick[1], rel=1e-9)
        ratio.append(state.stick[1] / state.contact[1])
    first = [2 * fine - coarse for coarse, fine in zip(ratio, ratio[1:], strict=False)]
    assert (4 * first[1] - first[0]) / 3 == pytest.approx(expected, rel=2e-3)


# -- conditions, balances, invariances ---------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [-0.3, 0.3])
def test_conditions_of_contact_and_friction(k):
    before = None
    for state in loop(k):
        peak = state.pressure.max()
        assert state.pressure.min() >= 0 and state.gap.min() > -1e-12
        assert np.all(state.pressure * state.gap == 0)
        assert np.all(np.abs(state.traction) <= MU * state.pressure + 1e-11 * peak)
        assert state.weight @ state.pressure == pytest.approx(state.P, rel=1e-12)
        assert state.weight @ state.traction == pytest.approx(state.Q, abs=1e-5 * MU * P)
        if before and before.Q != 0:
            slipping = (state.pressure > 0) & (np.abs(state.traction) >= MU * state.pressure * (1 - 1e-12))
            step = state.slip - CubicSpline(before.x, before.slip)(np.clip(state.x, before.x[0], before.x[-1]))
            assert np.all((state.traction * step)[slipping] < 1e-6 * peak)
            assert np.abs(step[(state.pressure > 0) & ~slipping]).max() < 1e-3 * np.abs(step[slipping]).max()
        before = state


def test_loads_are_checked():
    solver = HalfPlaneContact(solid_of(0.3), PROFILE, MU, nodes=100)
    for loads in ([(0.0, 0.0)], [(P, 0.1)], [(P, 0.0), (P, MU * P)], [(P, 0.0), (P, np.nan)]):
        with pytest.raises(ValueError):
            solver.run(loads)
    for load in ((np.inf, 0.0), (P, 0.0, np.nan)):
        with pytest.raises(ValueError, match="outside the admissible range"):
            solver.run([load])
    with pytest.raises(ValueError, match="mu = -0.3 is outside"):
        HalfPlaneContact(solid_of(0.3), PROFILE, -0.3).run([(P, 0.0)])


def test_what_does_not_converge_raises(monkeypatch):
    monkeypatch.setattr("analytic.half_plane.increment.MAX_ITERATIONS", 1)
    monkeypatch.setattr("analytic.half_plane.path.STEPS_PER_NODE", 0)
    with pytest.raises(ContactNotConverged, match="path"):
        HalfPlaneContact(solid_of(0.3), PROFILE, MU, nodes=100).run([(P, 0.0)])


def test_energy_balance_of_the_steady_loop():
    """Work of the loads over the second cycle is the dissipated energy, up to the rule over the increments."""
    difference = []
    for increments in (12, 24):
        states = loop(0.3, increments=increments, cycles=2, nodes=150)[-increments - 1 :]
        work = sum((b.Q + a.Q) / 2 * (b.delta_x - a.delta_x) for a, b in zip(states, states[1:], strict=False))
        dissipated = states[-1].dissipated_energy - states[0].dissipated_energy
        difference.append(work / dissipated - 1)
    assert abs(difference[1]) < 0.015
    assert abs((4 * difference[1] - difference[0]) / 3) < 1.5e-3


def test_result_does_not_depend_on_units():
    states, others = loop(0.3, nodes=150), loop(0.3, nodes=150, scale=1e-4)
    for state, other in zip(states, others, strict=True):
        assert 1e4 * np.array(other.contact) == pytest.approx(np.array(state.contact), rel=1e-8)
    assert 1e8 * others[-1].dissipated_energy == pytest.approx(states[-1].dissipated_energy, rel=1e-8)


def test_convergence_in_nodes():
    """Coupled edges and energy of the loop against the finest nodes: at least first order per doubling."""
    coarse, middle, fine = (loop(0.0, increments=16, nodes=nodes) for nodes in (100, 200, 400))
    for states, tolerance in ((coarse, 1e-3), (middle, 5e-4)):
        assert states[1].contact == pytest.approx(fine[1].contact, rel=tolerance)
        assert states[1].stick == pytest.approx(fine[1].stick, rel=tolerance)
        assert states[-1].dissipated_energy == pytest.approx(fine[-1].dissipated_energy, rel=tolerance)


def test_convergence_in_increments():
    """Coupled energy of the loop: errors fall at least linearly, as the path between loads does matter."""
    energies = []
    for increments in (4, 8, 16):
        states = loop(0.0, increments=increments)
        energies.append(states[-1].dissipated_energy - states[1].dissipated_energy)
    steps = np.abs(np.diff(energies)) / energies[-1]
    assert steps[1] < 0.5 * steps[0] < 5e-3
