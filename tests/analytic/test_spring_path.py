"""Any history of P and Q: against [X5], springs in small steps, energy balances and the friction law."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from analytic import CylinderContact, GradedHalfPlane, PowerProfile, Profile, ProfileContact, SpringPath
from analytic.load_memory import LoadMemory
from analytic.special import punch_rigid_factor

MU, P, R = 0.4, 1.5, 2.0
EXPONENTS = [-0.5, 0.0, 0.3, 0.7]


def cylinder(k):
    return CylinderContact(GradedHalfPlane(2.0, 0.3, k, 0.7), R, P)


def power(k, m):
    return ProfileContact(GradedHalfPlane(2.0, 0.3, k, 0.7), PowerProfile(0.3, m), 1.0)


def with_flat(k):
    shape = Profile(lambda u: u**2 / 2, lambda u: u, np.ones_like, flat=0.3)
    return ProfileContact(GradedHalfPlane(2.0, 0.3, k, 0.7), shape, 1.0)


CONTACTS = [*map(cylinder, EXPONENTS), power(0.3, 1.3), power(-0.4, 4.0), with_flat(0.2)]


def random_loads(number, seed, largest=P):
    """P up and down by a factor of up to ten, any admissible Q."""
    random = np.random.default_rng(seed)
    normal = largest * random.uniform(0.1, 1, number)
    return [(1.0 * largest, 0.0), *zip(normal, MU * normal * random.uniform(-0.95, 0.95, number), strict=True)]


def lines(loads, pieces):
    """The same path in many steps."""
    result = [loads[0]]
    for start, end in zip(loads[:-1], loads[1:], strict=True):
        way = np.linspace(0, 1, pieces + 1)[1:, None]
        result += [tuple(point) for point in np.array(start) + way * (np.array(end) - np.array(start))]
    return result


# -- constant P: the fretting loop ---------------------------------------------------------------------------------


@pytest.mark.parametrize("contact", CONTACTS[:5])
def test_fretting_loop_at_every_state(contact):
    """[X5]: q, slip and d on every branch; [X4], (52) on the second cycle, whose first turn is wiped out."""
    Q_A = 0.85 * MU * contact.P
    loop = contact.fretting(MU, Q_A)
    branches = [("initial", 0.0, Q_A), ("unloading", Q_A, -Q_A), ("reloading", -Q_A, Q_A), ("unloading", Q_A, -Q_A)]
    loads = [(Q, name) for name, a, b in branches for Q in np.linspace(a, b, 5)[1:]]
    states = SpringPath(contact, MU).run([(contact.P, Q) for Q in (0.0, *(Q for Q, _ in loads))])[5:]
    x = contact.a * np.array([0.0, 0.2, 0.6, 0.9, 0.99, 1.3])
    for (Q, name), state in zip(loads[4:], states, strict=True):
        np.testing.assert_allclose(state.traction(x), loop.traction(x, Q, name), atol=1e-12 * contact.pressure(0.1))
        np.testing.assert_allclose(state.slip(x), loop.slip(x, Q, name), atol=1e-12 * loop.amplitude.slip(x[-1]))
        d = loop.active_half_width(Q, name)
        assert state.stick_half_width == pytest.approx(d, rel=1e-12)
        assert state.half_width_below_limit == pytest.approx(d, rel=1e-12)
        assert state.traction_within(0.7) == pytest.approx(loop.traction_within(0.7, Q, name), abs=1e-12 * Q_A)
    assert len(states[7].memory.P) == 3
    cycle = 2 * (states[-1].dissipated_energy - states[7].dissipated_energy)
    assert cycle == pytest.approx(loop.dissipated_energy, rel=1e-11)


def test_nested_loops_are_forgotten():
    """A closed inner loop leaves no trace but its energy, that of a loop of its amplitude."""
    contact = cylinder(0.3)
    loads = [(P, Q * MU * P) for Q in (0.9, -0.2, 0.5, 0.1, 0.5, -0.2, 0.9)]
    plain = SpringPath(contact, MU).run([*loads[:3], *loads[5:]])
    nested = SpringPath(contact, MU).run(loads)
    for one, other in ((plain[2], nested[4]), (plain[3], nested[5]), (plain[4], nested[6])):
        np.testing.assert_allclose(one.memory.P, other.memory.P, rtol=1e-13)
        np.testing.assert_allclose(one.memory.Q, other.memory.Q, rtol=1e-13)
    inner = contact.fretting(MU, 0.2 * MU * P).dissipated_energy
    assert nested[-1].dissipated_energy - plain[-1].dissipated_energy == pytest.approx(inner, rel=1e-11, abs=0)
    again = SpringPath(contact, MU).run([(P, Q * MU * P) for Q in (0.0, 0.9, -0.3, 0.1, -0.3, 0.1, -0.3, 0.9, 0.9)])
    assert [len(state.memory.P) for state in again] == [2, 3, 4, 5, 4, 5, 4, 3, 3]  # whatever the last digits of turns
    assert again[-1].stick_half_width == again[-2].stick_half_width  # a dwell changes nothing


def test_loads_that_go_back_leave_traction_at_its_limit():
    """On the way back nothing slips, so that all sticks; beyond 0.62 a the traction is at its limit all the same."""
    contact = cylinder(0.3)
    way = [(0.2, 0.0), (0.2, 0.04), (1.0, 0.04), (0.2, 0.04), (1.0, -0.04), (0.2, 0.04)]
    state = SpringPath(contact, MU).run([(share * P, Q * MU / 0.3 * P) for share, Q in way])[-1]
    assert state.stick_half_width == state.contact_half_width
    edge = state.half_width_below_limit
    assert edge / state.contact_half_width == pytest.approx(0.6216, rel=3e-3)  # of discrete springs
    for x, at_limit in ((0.999 * edge, False), (1.001 * edge, True), (0.99 * state.contact_half_width, True)):
        assert (abs(state.traction(x)) > (1 - 1e-9) * MU * state.pressure(x)) == at_limit


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_a_way_back_along_the_limit_of_friction_leaves_no_trace(slope):
    """P grows and falls again with dQ = ±mu dP: nothing slips, and where |q| < mu p is as before, whatever rounds."""
    before, path = [(0.9 * P, 0.54 * MU * P), (0.2 * P, -0.18 * MU * P)], SpringPath(cylinder(0.3), MU)
    state = path.run(before)[-1]
    for share in (0.06, 0.17, 0.29, 0.41):
        way = [(0.2 + share * i / 5, -0.18 + slope * share * i / 5) for i in (1, 2, 3, 4, 5, 4, 3, 2, 1)]
        back = path.run([*before, *((N * P, T * MU * P) for N, T in way), before[-1]])[-1]
        assert back.half_width_below_limit == pytest.approx(state.half_width_below_limit, rel=1e-12)
        assert len(back.memory.P) == len(state.memory.P)
        assert back.dissipated_energy == pytest.approx(state.dissipated_energy, rel=1e-12)


# -- P grows while Q acts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("slope", [0.5, -1.0])
def test_full_stick_while_both_loads_grow(contact, slope):
    """|dQ/dP| <= mu: q = dQ/dP [p(P1) - p(P0)], no slip of any point in contact, no energy, in any number of steps."""
    P0, P1 = 0.4 * P, 1.3 * P
    ratio = slope * MU
    for pieces in (1, 7):
        steps = lines([(P0, 0.0), (P1, ratio * (P1 - P0))], pieces)
        state = SpringPath(contact, MU).run(steps)[-1]
        before, after = (state.path.contact_under(load) for load in (P0, P1))
        x = after.a * np.array([0.0, 0.3, 0.5, 0.8, 0.99, 1.2])
        expected = ratio * (after.pressure(x) - before.pressure(x))
        scale = abs(ratio) * after.pressure(0.5 * after.a)
        np.testing.assert_allclose(state.traction(x), expected, atol=1e-12 * scale)
        assert state.stick_half_width == state.contact_half_width == after.a
        assert state.dissipated_energy == 0
        assert len(state.memory.P) == 3


def test_full_stick_of_a_graded_half_plane_at_its_holl_ratio():
    """P from 0.25 to 1 MN/m while Q grows to 0.12 MN/m: q = 0.16 [p(P1) - p(P0)], c = a."""
    R, k = 0.1, 0.3
    a0 = CylinderContact(GradedHalfPlane(210e9, 1 / 2.3, 0.0, 1.0), R, 1e6).a0
    contact = CylinderContact(GradedHalfPlane(210e9, 1 / 2.3, k, 10 * a0), R, 1e6)
    state = SpringPath(contact, 0.3).run([(2.5e5, 0.0), (1e6, 1.2e5)])[-1]
    before = CylinderContact(contact.solid, R, 2.5e5)
    x = np.linspace(0, 1, 9) * contact.a
    np.testing.assert_allclose(state.traction(x), 0.16 * (contact.pressure(x) - before.pressure(x)), atol=1e-3)
    np.testing.assert_allclose(state.slip(x[x < before.a]), 0, atol=1e-20)
    assert state.dissipated_energy == 0
    assert state.stick_half_width == contact.a


# -- any path ------------------------------------------------------------------------------------------------------


def springs(k, loads, steps, number=400):
    """Springs on the axis in small steps, for n_y = 2 s: places, tangential elongations, energy over D at the loads."""
    edges = (max(load for load, _ in loads) * (2 + k) / 2) ** (1 / (2 + k)) * np.linspace(0, 1, number + 1)
    s = (edges[1:] + edges[:-1]) / 2
    elongation, energy, states = np.zeros(number), 0.0, []
    for P, Q in lines([(0.0, 0.0), *loads], steps)[1:]:
        limit = MU * np.maximum((P * (2 + k) / 2) ** (2 / (2 + k)) - s**2, 0)

        def excess(shift, limit=limit, Q=Q):
            new = np.clip(elongation + shift, -limit, limit)
            return -np.diff(new, append=0.0) @ edges[1:] ** k - Q

        bound = 4 * MU * edges[-1] ** 2
        shifted = elongation + brentq(excess, -bound, bound, xtol=1e-14)
        new = np.clip(shifted, -limit, limit)
        energy += np.sum(s ** (k - 1) * np.diff(edges) * np.abs(new * (shifted - new)))
        elongation = new
        states.append((elongation, energy))
    return s, states[steps - 1 :: steps]


@pytest.mark.parametrize("k", EXPONENTS)
def test_against_springs_in_small_steps(k):
    """Random paths: the density n_x by (19), and the energy."""
    solid = GradedHalfPlane(2.0, 0.3, k, 0.7)
    unit = 1 / (solid.normal_compliance * punch_rigid_factor(k))  # n_y of x², of (42), over 2 s
    contact = CylinderContact(solid, 0.5, 2 / (2 + k) * unit)
    loads = random_loads(6, 3, 2 / (2 + k))
    states = SpringPath(contact, MU).run([(P * unit, Q * unit) for P, Q in loads])
    s, expected = springs(k, loads, 100)
    _, coarse = springs(k, loads, 50)
    energy_unit = unit**2 * solid.tangential_compliance * punch_rigid_factor(k)
    tiny = 1e-3 * expected[-1][1]
    for state, (elongation, energy), (_, half) in zip(states, expected, coarse, strict=True):
        edges = np.array([state.path.contact_under(load).a if load else 0.0 for load in state.memory.P])
        ratios = np.diff(state.memory.Q) / np.diff(state.memory.P)
        pieces = zip(ratios, edges[:-1], edges[1:], strict=True)
        exact = sum(r * np.maximum(high**2 - np.maximum(s, low) ** 2, 0) for r, low, high in pieces)
        np.testing.assert_allclose(elongation, exact, atol=4e-3 * MU)
        # a force at the end of its step: first order in the steps
        assert state.dissipated_energy / energy_unit == pytest.approx(2 * energy - half, rel=1e-3, abs=tiny)


@pytest.mark.parametrize("contact", [c for c in CONTACTS if c.solid.k > 0])
def test_energy_is_the_work_that_is_not_stored(contact):
    """∫ Q d(delta_x) minus the elastic energy ∫ q u_x dx/2, delta_x at Gauss points of every line of the path."""
    path, loads = SpringPath(contact, MU), random_loads(3, 5)
    states = path.run(lines(loads, 100))
    shift = np.array([state.rigid_shift for state in states])
    Q = np.array([state.Q for state in states])
    work = np.sum((Q[1:] + Q[:-1]) / 2 * np.diff(shift))
    last = states[-1]
    x, weight = graded_nodes([path.contact_under(load).a for load in last.memory.P[1:]])
    stored = (last.Q * shift[-1] - 2 * np.sum(weight * last.traction(x) * last.slip(x))) / 2
    assert last.dissipated_energy == pytest.approx(work - stored, rel=1e-4)
    direct = path.run(loads)[-1].dissipated_energy
    assert last.dissipated_energy == pytest.approx(direct, rel=1e-9)
    back = [(P, 0.0), (0.47 * P, -0.07 * MU * P), (0.92 * P, 0.58 * MU * P), (0.14 * P, -0.13 * MU * P)]
    whole, pieces = (path.run(steps)[-1].dissipated_energy for steps in (back, lines(back, 20)))
    assert whole == pytest.approx(pieces, rel=1e-9)  # punches that leave contact slip in both directions on the way


def graded_nodes(edges, number=60):
    """Gauss rule over (0, edges[-1]) that resolves roots at every edge."""
    t, weight = np.polynomial.legendre.leggauss(number)
    angle, weight = (1 + t) / 2, weight / 2
    blend, slope = angle**4 * (35 - 84 * angle + 70 * angle**2 - 20 * angle**3), 140 * (angle * (1 - angle)) ** 3
    edges = np.unique([0.0, *edges])
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * blend).ravel(), (width * slope * weight).ravel()


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.3])
def test_energy_is_friction_times_slip(k):
    """∫∫ q dx dh_x over a path, by the mean traction of small steps."""
    contact = cylinder(k)
    loads = lines([(P, 0.0), (P, 0.5 * P * MU), (0.6 * P, -0.3 * P * MU), (0.9 * P, 0.5 * P * MU)], 120)
    states = SpringPath(contact, MU).run(loads)
    x = contact.a * (np.arange(200) + 0.5) / 200
    q, slip = (np.array([getattr(state, name)(x) for state in states]) for name in ("traction", "slip"))
    a = np.array([state.contact_half_width for state in states])
    together = np.minimum(a[1:], a[:-1])[:, None] > x
    work = 2 * contact.a / 200 * np.sum((q[1:] + q[:-1]) / 2 * np.diff(slip, axis=0) * together)
    assert states[-1].dissipated_energy == pytest.approx(work, rel=3e-3)  # 5e-3 with half the steps


@settings(max_examples=60)
@given(st.floats(-0.95, 0.95), st.integers(0, 10**6), st.integers(1, 8))
def test_friction_law_and_equilibrium(k, seed, number):
    """|q| <= mu p, q = ±mu p where it slips, ∫ q dx = Q, no loss of energy, mirrored paths."""
    contact, loads = cylinder(k), random_loads(number, seed)
    states = SpringPath(contact, MU).run(loads)
    mirrored = SpringPath(contact, MU).run([(N, -T) for N, T in loads])[-1]
    before = 0.0
    for state, (N, T) in zip(states, loads, strict=True):
        x = np.linspace(0, 1.1, 12) * state.contact_half_width
        q, limit = state.traction(x), MU * state.pressure(x)
        assert np.all(np.abs(q) <= limit + 1e-13 * limit[0])
        slipping = x > state.stick_half_width
        np.testing.assert_allclose(np.abs(q[slipping]), limit[slipping], rtol=1e-11)
        assert state.traction_within(2 * contact.a) == pytest.approx(T, abs=1e-12 * N)
        assert state.dissipated_energy >= before
        before = state.dissipated_energy
    np.testing.assert_array_equal(mirrored.traction(x), -q)
    assert mirrored.dissipated_energy == before


@pytest.mark.parametrize("k", EXPONENTS)
def test_withdrawal_to_a_small_load(k):
    """P falls to 1e-9 of itself at the same Q/P: q = (Q/P) p at the end, and energy adds up over its parts."""
    path, loads = SpringPath(cylinder(k), MU), [(P, 0.0), (P, 0.3 * MU * P), (1e-9 * P, 0.3e-9 * MU * P)]
    state, parts = path.run(loads)[-1], path.run(lines(loads, 5))[-1]
    x = state.contact_half_width * np.array([0.2, 0.7, 0.95])
    assert np.all(np.abs(state.traction(x)) <= MU * state.pressure(x) * (1 + 1e-12))
    assert state.traction_within(1.0) == pytest.approx(0.3e-9 * MU * P, rel=1e-6)
    assert parts.dissipated_energy == pytest.approx(state.dissipated_energy, rel=1e-10, abs=0)


@pytest.mark.parametrize("rest", [1e-10, 1e-15])
def test_nearly_full_slip(rest):
    """mu P - Q of a few roundings: along a ray nothing slips and q = mu p; else all that stuck before is wiped out."""
    path, Q = SpringPath(cylinder(0.3), MU), MU * P * (1 - rest)
    ray = path.run([(P, Q)])[-1]
    assert ray.half_width_below_limit == 0 and ray.stick_half_width == ray.contact_half_width
    state = path.run([(0.5 * P, 0.1 * MU * P), (0.8 * P, -0.1 * MU * P), (P, 0.0), (P, Q)])[-1]
    x = ray.contact_half_width * np.array([0.1, 0.5, 0.99])
    for one in (ray, state):
        np.testing.assert_allclose(one.traction(x), MU * one.pressure(x), rtol=1e-9)
    assert state.stick_half_width == state.half_width_below_limit < 1e-4 * state.contact_half_width


def test_without_tangential_load_the_infinite_pressure_of_a_sharp_tip_has_no_traction():
    state = SpringPath(power(-0.2, 1.0), MU).run([(P, 0.0)])[-1]
    assert state.pressure(0.0) == np.inf and state.traction(0.0) == 0


def test_refusals():
    path = SpringPath(cylinder(0.3), MU)
    for loads in ([(P, MU * P)], [(P, 0.0), (P / 2, -0.6 * MU * P)], [(0.0, 0.0)], [(-1.0, 0.0)], [(np.nan, 0.0)]):
        with pytest.raises(ValueError, match=r"needs P > 0 and \|Q\| < mu P"):
            path.run(loads)
    with pytest.raises(ValueError, match="P = inf is outside"):
        path.run([(np.inf, 0.0)])
    with pytest.raises(ValueError, match="mu"):
        SpringPath(cylinder(0.3), 0.0)


def test_zone_below_the_limit():
    """By hand: what lies beyond slips, or sticks at the limit; what came last may do neither."""
    memory = LoadMemory.unloaded(0.5).advanced(1.0, 0.0).advanced(2.0, 0.1)
    assert memory.below_limit == memory.stick == 2.0
    slipping = memory.advanced(2.0, 0.4)  # the line of slope mu through (2, 0.4) meets Q = 0.1 (P - 1)
    assert slipping.below_limit == slipping.stick == pytest.approx(1.25, rel=1e-15)
    along = slipping.advanced(3.0, 0.9)
    assert along.below_limit == slipping.below_limit < along.stick == 3.0
    assert along.advanced(4.0, 0.9).below_limit == 4.0
