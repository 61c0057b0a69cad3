"""Coupled loops without load steps: closed forms where they are exact, conditions and balances elsewhere."""

from dataclasses import replace
from functools import lru_cache
from math import gamma

import numpy as np
import pytest

from analytic import ContactNotConverged, CylinderContact, GradedHalfPlane, PowerProfile, Profile, ProfileContact
from analytic.coupled import CoupledLoop
from analytic.edge_exponents import edge_exponent, hilbert_ratio
from analytic.coupled.linear import solve
from analytic.coupled.panels import Panels, graded
from analytic.coupled.pressed import NormalStage
from analytic.coupled.work import stick_compliance
from analytic.half_plane.solver import HalfPlaneContact
from analytic.punch_with_friction import Medium

MU, R, P = 0.3, 2.0, 1.5
PROFILE = PowerProfile(1 / (2 * R), 2.0)
BRANCHES = ("initial", *2 * ("unloading",), *2 * ("reloading",))


def solid_of(k, nu=0.3):
    return GradedHalfPlane(7.0, nu, k, 0.6)


def loads(Q_A, *shares):
    return [(P, 0.0), *((P, share * Q_A) for share in shares)]


@lru_cache
def loop(k, nu, mu, share, coupling=True):
    """States at the end of the normal stage, at Q_A, -Q_A/2, -Q_A, Q_A/2, Q_A."""
    path = loads(share * mu * P, 1, -0.5, -1, 0.5, 1)
    return CoupledLoop(solid_of(k, nu), PROFILE, P, mu, coupling).run(path)


def error(state, values, expected):
    """Relative L2 error."""
    return np.sqrt(state.weight @ (values - expected) ** 2 / (state.weight @ expected**2))


def assert_closed_forms(states, contact, mu, Q_A, tolerance, of_energy=2e-7):
    exact = contact.fretting(mu, Q_A)
    for state, branch in zip(states[1:], BRANCHES, strict=True):
        x = state.x
        inside = np.abs(x) < contact.a
        assert error(state, state.pressure, contact.pressure(x)) < tolerance
        assert error(state, state.traction, exact.traction(x, state.Q, branch)) < tolerance
        slip = np.where(inside, exact.slip(np.where(inside, x, 0.0), state.Q, branch), 0.0)
        assert error(state, np.where(inside, -state.slip, 0.0), slip) < tolerance
        d = exact.active_half_width(state.Q, branch)
        assert np.abs(np.array([state.contact, state.stick]) - [[-contact.a, contact.a], [-d, d]]).max() < tolerance * d
    assert states[1].dissipated_energy == pytest.approx(exact.dissipated_energy / 4, rel=of_energy)
    cycle = states[-1].dissipated_energy - states[1].dissipated_energy
    assert cycle == pytest.approx(exact.dissipated_energy, rel=of_energy)


@pytest.mark.parametrize("k, tolerances", [(-0.9, (1e-3, 2e-6)), (-0.7, (2e-8,)), (0.3, (2e-8,)), (0.9, (2e-8,))])
def test_without_coupling_the_closed_forms(k, tolerances):
    """An edge that is known to 5e-7 leaves 5e-4 in q where it ends like distance^0.05."""
    Q_A = 0.6 * MU * P
    assert_closed_forms(loop(k, 0.3, MU, 0.6, False), CylinderContact(solid_of(k), R, P), MU, Q_A, *tolerances)


def test_holl_ratio_decouples():
    """Coupling is on, and vanishes up to rounding of the Holl ratio."""
    nu = GradedHalfPlane.holl_ratio(0.5)
    assert_closed_forms(loop(0.5, nu, MU, 0.6), CylinderContact(solid_of(0.5, nu), R, P), MU, 0.6 * MU * P, 2e-8)


def test_other_profile_without_coupling():
    """A profile of the fourth power, and one that is no polynomial and is refused."""
    profile = PowerProfile(0.3, 4.0)
    contact = ProfileContact.from_load(solid_of(0.3), profile, P, a_max=4.0)
    state = CoupledLoop(solid_of(0.3), profile, P, MU, coupling=False, order=8).run(loads(0.3 * MU * P, 1))[-1]
    exact = contact.fretting(MU, 0.3 * MU * P)
    assert error(state, state.pressure, contact.pressure(state.x)) < 1e-6
    assert error(state, state.traction, exact.traction(state.x, state.Q, "initial")) < 1e-6
    flat = Profile(lambda u: u**2 / 2, lambda u: u, np.ones_like, flat=0.2)
    with pytest.raises(ContactNotConverged, match="no polynomial"):
        CoupledLoop(solid_of(0.3), flat, P, MU).run(loads(0.1, 1))


@pytest.mark.parametrize(("k", "mu", "share"), [(-0.8, 0.3, 0.9), (0.0, 0.6, 0.6), (0.3, 0.3, 0.9), (0.9, 0.3, 0.6)])
def test_conditions_and_balances_with_coupling(k, mu, share):
    for before, state in zip(loop(k, 0.3, mu, share), loop(k, 0.3, mu, share)[1:], strict=False):
        assert state.weight @ state.pressure == pytest.approx(P, rel=2e-8)
        assert state.weight @ state.traction == pytest.approx(state.Q, abs=2e-8 * mu * P)
        limit = np.abs(state.traction) - mu * state.pressure
        assert state.weight @ np.maximum(limit, 0) < 1e-6 * mu * P
        slipping = (state.x < state.stick[0]) | (state.x > state.stick[1])
        assert state.dissipated_energy > before.dissipated_energy
        stuck = np.linspace(*state.stick, 30)[1:-1]
        step = state.slip_at(stuck) - before.slip_at(stuck)
        assert np.abs(step).max() < 1e-6 * np.abs(state.slip[slipping]).max()


def test_energy_of_loops_with_coupling():
    """Over the uncoupled energy: the limits of load stepping in other half-plane codes, which know three digits."""
    for k, mu, share, expected in ((0.0, 0.6, 0.6, 0.8533), (0.3, 0.3, 0.9, 0.9457)):
        states = loop(k, 0.3, mu, share)
        exact = CylinderContact(solid_of(k), R, P).fretting(mu, share * mu * P)
        cycle = states[-1].dissipated_energy - states[1].dissipated_energy
        assert cycle / exact.dissipated_energy == pytest.approx(expected, abs=2e-4)


def test_nearly_uncoupled_loop():
    """Edges of stick come back to where they turned, up to the square of the weak coupling, as does the energy."""
    nu = 0.495
    states = loop(0.0, nu, 0.3, 0.9)
    exact = CylinderContact(solid_of(0.0, nu), R, P).fretting(0.3, 0.9 * 0.3 * P)
    cycle = states[-1].dissipated_energy - states[1].dissipated_energy
    lost = 1.5 * ((1 - 2 * nu) / (2 - 2 * nu)) ** 2  # docs/coupling.md
    assert 1 - cycle / exact.dissipated_energy == pytest.approx(lost, rel=0.03)
    assert states[-1].stick == pytest.approx(states[1].stick, rel=2e-2)


def test_order_of_the_basis():
    """A basis lower by two orders, and fewer loads, give the same state and energy."""
    path = loads(0.9 * MU * P, 1, -0.5)
    lower, higher = (CoupledLoop(solid_of(0.3), PROFILE, P, MU, order=order).run(path) for order in (8, 10))
    for state, other in zip(higher, lower, strict=True):
        assert other.contact == pytest.approx(state.contact, abs=1e-10 * state.contact[1])
        assert other.dissipated_energy == pytest.approx(state.dissipated_energy, rel=2e-6, abs=1e-12)
        if state.Q:
            assert error(state, other.pressure_at(state.x), state.pressure) < 2e-6
            assert error(state, other.traction_at(state.x), state.traction) < 2e-5


def test_energy_without_states_just_after_a_turn(monkeypatch):
    """There the motion is continued to the turn: from a fifth of the branch on the energy keeps four digits."""
    solver, path = CoupledLoop(solid_of(0.3), PROFILE, P, MU, order=8), loads(0.6 * MU * P, 1, -1)
    usual = [state.dissipated_energy for state in solver.run(path)]
    monkeypatch.setattr("analytic.coupled.branch.FIRST", 0.2)
    assert [state.dissipated_energy for state in solver.run(path)] == pytest.approx(usual, rel=5e-5)


def test_energy_where_stick_soon_passes_an_earlier_turn():
    """Only up to there the motion is smooth: continued to the turn by what lies beyond, the energy was off by 13 %.

    Another order of the basis begins where the first known load of this one is not near any more.
    """
    solver = CoupledLoop(solid_of(0.5, 0.0), PROFILE, P, 1.0)
    path = loads(0.3 * P, *np.linspace(0, 1, 7)[1:], *np.linspace(1, -1, 13)[1:])
    states = solver.where_known(path)
    known = [state for state in states if not isinstance(state, ContactNotConverged)]
    other = replace(solver, order=solver.order - 2).where_known(path, known)
    assert other[-1].dissipated_energy == pytest.approx(states[-1].dissipated_energy, rel=5e-3)


def test_pressure_in_closed_form():
    """Where p follows from r alone, u_y + f is constant in contact and u_x in stick as the kernels have it."""
    state = loop(0.0, 0.3, 0.6, 0.6)[1]
    inner = state._state
    x = np.linspace(*inner.contact, 30)[1:-1]
    u_x, u_y = inner.displacements(x) - inner.base.displacements(x) * [[1], [0]]
    assert np.abs(u_y + inner.problem.height(x)).max() < 1e-7
    stuck = (x > inner.stick[0]) & (x < inner.stick[1])
    assert np.abs(u_x[stuck]).max() < 1e-7


def test_conditions_just_after_a_turn():
    """A narrow zone of slip beside the old edge of contact: contact as the kernels have it, and both loads."""
    state = CoupledLoop(solid_of(-0.3, 0.2), PROFILE, P, MU, order=8).run(loads(0.6 * MU * P, 1, 0.92, -1))[2]
    inner = state._state
    assert 0 < inner.stick[0] - inner.base.contact[0] < 0.02
    x = np.linspace(*inner.stick, 30)[1:-1]
    u_x, u_y = inner.displacements(x) - inner.base.displacements(x) * [[1], [0]]
    assert np.abs(u_y + inner.problem.height(x)).max() < 1e-7 and np.abs(u_x).max() < 1e-7
    assert [state.weight @ state.pressure, state.weight @ state.traction] == pytest.approx([P, state.Q], rel=1e-6)


def test_rates_of_the_amplitudes():
    """Derivatives of the amplitudes at the right edges: by the own edge as said, by the others none."""
    inner = loop(0.3, 0.3, 0.3, 0.9)[2]._state
    edges = np.array([inner.contact[0], *inner.stick, inner.contact[1]])
    widths = np.array([edges[1] - edges[0]] * 2 + [edges[3] - edges[2]] * 2)

    def solution(moved):
        return solve(inner.base, inner.friction, moved, inner.Q)

    outwards = np.array([-1, -1, 1, 1])
    steps = 1e-4 * widths * outwards
    columns = [
        (solution(edges + s * e).amplitudes - solution(edges - s * e).amplitudes) / 2e-4
        for s, e in zip(steps, np.eye(4), strict=True)
    ]
    rates = solution(edges).rates
    assert np.stack(columns, axis=1) == pytest.approx(-np.diag(rates), abs=1e-6 * rates.max())


@pytest.mark.parametrize(("k", "nu"), [(0.0, 0.3), (0.3, 0.2), (0.7, 0.0)])
def test_compliance_of_full_stick(k, nu):
    """The tractions that it names move the contact as a rigid body without tilt, under Q = 1; without coupling (13)."""
    problem, half = NormalStage(solid_of(k, nu), PROFILE, P, MU, True, 8).problem, 1.3
    panels = Panels.between(graded(-1.0, 1.0, 14, 14, 0.15))
    D = problem.d / np.sqrt(problem.bk * problem.gk)
    turning = np.arctanh(hilbert_ratio(problem.k) * D) / np.pi * np.log((1 + panels.nodes) / (1 - panels.nodes))
    root = ((1 + panels.nodes) * (1 - panels.nodes)) ** ((k - 1) / 2)
    q, p = root * np.cos(turning), root * np.sin(turning) * np.sqrt(problem.gk / problem.bk)
    p, q = p / (half * panels.weights @ q), q / (half * panels.weights @ q)
    scaled = Panels.between(half * np.append(panels.low, 1.0))
    even, odd = scaled.matrices(half * np.array([-0.8, -0.3, 0.0, 0.5]), k)
    u_x, u_y = problem.displacements(even @ p, odd @ p, even @ q, odd @ q)
    assert scaled.weights @ p == pytest.approx(0.0, abs=1e-9)
    assert u_x == pytest.approx(np.full(4, stick_compliance(problem, half)), abs=1e-7)
    assert u_y == pytest.approx(np.zeros(4), abs=1e-7)


@pytest.mark.parametrize("k", [-0.99, -0.5, -1e-9, 0.0, 0.3, 0.97, 0.99])
def test_compliance_of_full_stick_without_coupling(k):
    """The closed form (13), up to the ends of the range of k."""
    problem, half = NormalStage(solid_of(k), PROFILE, P, MU, False, 8).problem, 1.3
    scale = gamma(1 + k / 2) * gamma((1 - k) / 2) / np.sqrt(np.pi)
    expected = problem.gk * ((half**-k * scale - 1) / k if abs(k) > 1e-8 else np.log(2 / half))
    assert stick_compliance(problem, half) == pytest.approx(expected, rel=1e-8 if 0 < abs(k) < 1e-8 else 1e-13)


@pytest.mark.parametrize("k", [-0.99, 0.99])
def test_energy_at_the_ends_of_the_range(k):
    """Of a small loop without coupling, which takes most from the compliance of full stick."""
    states = loop(k, 0.3, MU, 0.1, False)
    exact = CylinderContact(solid_of(k), R, P).fretting(MU, 0.1 * MU * P)
    cycle = states[-1].dissipated_energy - states[1].dissipated_energy
    assert cycle == pytest.approx(exact.dissipated_energy, rel=1e-7)


def test_points_that_come_into_contact_in_stick_are_said():
    """Far from the Holl ratio, under strong friction, the contact moves faster than slip spreads: no state there."""
    solver, path = CoupledLoop(solid_of(0.0, 0.0), PROFILE, P, 1.0, order=8), loads(P, 0.1, 0.6, 0.8, 0.5, 0, -0.8)
    pressed, early, stuck, turn, back, *later = solver.where_known(path)
    assert "Q = 0.1 P: points come into contact in stick" in str(early) and "contact in stick" in str(back)
    assert "Q = 0.6 P: a point slips backwards" in str(stuck)  # that came in stick: not all have slipped yet
    assert [state.Q / P for state in (pressed, turn, *later)] == pytest.approx([0, 0.8, 0, -0.8])
    with pytest.raises(ContactNotConverged, match="Q = 0.1 P"):
        solver.run(path)


def test_states_just_after_such_loads_are_not_certain():
    """Beside the solver with load steps: points that came in stick stick still, and q is off by 6 %; later by 1e-3."""
    solid, mu = solid_of(-0.161, -0.256), 0.16
    path = [(P, 0.0), *((P, P * mu * 0.742 * share) for share in (7 / 16, 10 / 16, 1.0))]
    _, early, later, turn = CoupledLoop(solid, PROFILE, P, mu).where_known(path)
    assert not early.is_certain and later.is_certain and turn.is_certain
    back = CoupledLoop(solid, PROFILE, P, mu).where_known([*path[:2], (P, -path[1][1])])[-1]
    assert not back.is_certain and back.branch.is_certain(back.Q / P)  # after a turn in such a state
    shares = np.append(np.geomspace(1 / 16, 7 / 16, 21), np.geomspace(7 / 16, 10 / 16, 5)[1:])
    steps = HalfPlaneContact(solid, PROFILE, mu, nodes=150).run([(P, 0.0), *((P, turn.Q * s) for s in shares)])
    assert error(early, early.traction, steps[21].traction_at(early.x)) > 0.03
    assert error(later, later.traction, steps[-1].traction_at(later.x)) < 3e-3
    with pytest.raises(ContactNotConverged, match="may stick still"):
        CoupledLoop(solid, PROFILE, P, mu).run(path)


def test_load_steps_keep_what_sticks():
    """So many small load steps do not wear off q where it sticks: at old edges of stick it was off by 1.3 %.

    The indenter moves as far as in the loop without load steps.
    """
    solid, Q_A = solid_of(-0.3, 0.0), 0.6 * MU * P
    shares = np.geomspace(0.05, 1.0, 30)
    up, down = ([(P, share * Q_A) for share in way] for way in (shares, 1 - shares))
    states = HalfPlaneContact(solid, PROFILE, MU, nodes=150).run([(P, 0.0), *up, *down])
    _, turned, exact = CoupledLoop(solid, PROFILE, P, MU).where_known(loads(Q_A, 1, 0))
    assert error(states[-1], states[-1].traction, exact.traction_at(states[-1].x)) < 4.5e-3
    for state, other in ((states[len(up)], turned), (states[-1], exact)):
        assert (state.delta_x, state.delta_y) == pytest.approx((other.delta_x, other.delta_y), rel=1e-3)


@pytest.mark.parametrize("k, nu, mu, share", [(0.627, 0.493, 0.0211, 0.323), (0.369, 0.06, 0.0317, 0.214)])
def test_loops_of_little_friction_close(k, nu, mu, share):
    """Back at Q_A the edges of stick come to where one turned at -Q_A: amplitudes have a kink or a small jump there."""
    _, first, _, turned, _, last = loop(k, nu, mu, share)
    assert last.contact == pytest.approx(first.contact, abs=1e-6)
    assert np.abs(last.stick) == pytest.approx([np.abs(turned.stick).max()] * 2, abs=5e-6)


def test_paths_that_are_no_loops_are_refused():
    solver = CoupledLoop(solid_of(0.3), PROFILE, P, MU)
    with pytest.raises(ContactNotConverged, match="while Q acts"):
        solver.run([(P, 0.0), (1.1 * P, 0.1)])
    for path in ([(0.0, 0.0)], [(P, 0.1)], [(P, 0.0), (P, MU * P)], [(P, 0.0), (P, np.nan)]):
        with pytest.raises(ValueError):
            solver.run(path)
    with pytest.raises(ValueError, match="mu = -0.3 is outside"):
        replace(solver, mu=-0.3).run([(P, 0.0)])


def test_fields_at_no_points():
    for state in loop(0.3, 0.3, 0.3, 0.9)[:2]:
        for field in (state.pressure_at, state.traction_at, state.slip_at):
            assert field([]).shape == (0,) and field(np.empty((2, 0))).shape == (2, 0)


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.3])
def test_kernels_over_panels(k):
    """∫ R(x - t) t dt and ∫ O(x - t) t dt over 0 < t < 1 against antiderivatives, near, in and far from panels."""
    panels = Panels.between(np.array([0.0, 0.3, 1.0]))
    for x in (-0.2, 1e-3, 0.3, 0.77, 1.01, 1.5):
        even, odd = (m[0] @ panels.nodes for m in panels.matrices(np.array([x]), k))

        def moment(z, sign):  # ∫_0^z |s|^-k (x - s) ds, s = x - t, signed as the kernel is
            power = np.abs(z) ** (1 - k)
            return np.sign(z) ** sign * (np.sign(z) * x * power / (1 - k) - np.abs(z) * power / (2 - k))

        assert odd == pytest.approx(moment(x, 1) - moment(x - 1, 1), abs=1e-11)
        if k:
            assert even == pytest.approx((moment(x, 0) - moment(x - 1, 0) - 0.5) / k, abs=1e-11)


def test_kernels_of_the_smallest_k_are_those_of_none():
    panels, x = Panels.between(np.array([0.0, 0.3, 1.0])), np.array([-0.2, 1e-3, 0.77, 1.5])
    for tiny, none in zip(panels.matrices(x, 1e-12), panels.matrices(x, 0.0)):
        assert tiny == pytest.approx(none, abs=1e-11)


def test_exponents():
    """(1+k)/2 without friction, and the half-plane of constant modulus: cot(pi exponent) = 2 mu d/(pi b k)."""
    assert edge_exponent(Medium(0.3, 0.5, 0.5, -0.2, 0.0), 0.0) == pytest.approx(0.65)
    homogeneous = edge_exponent(Medium(0.0, 0.6, 0.6, -0.2, 0.5), 0.5)
    assert 1 / np.tan(np.pi * homogeneous) == pytest.approx(-2 * 0.5 * 0.2 / (np.pi * 0.6))
