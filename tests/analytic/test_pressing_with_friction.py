"""Pressing with friction from first contact: boundary conditions by kernels [X6], energy balance, known limits."""

from functools import lru_cache

import numpy as np
import pytest
from scipy.special import ellipk

from analytic import (
    GradedHalfPlane,
    HalfPlaneContact,
    PowerLawKernel,
    PowerProfile,
    PressingWithFriction,
    ProfileContact,
)
from analytic.quadrature import plain_rule

A, P = 0.4, 1.3


@lru_cache
def pressing(k, nu, mu, m=2.0, **options):
    return PressingWithFriction(GradedHalfPlane(2.0, nu, k, 0.7), PowerProfile(A, m), mu, P, **options)


def displacement(contact, x):
    """u_y and u_x at x >= 0 by kernels (2), [X6], up to a constant in u_y."""
    a, c = contact.contact_half_width, contact.stick_half_width
    t, rest, weight = plain_rule(0.0, 0.0, 24)
    ends = np.unique([-a, -c, -1e-3 * a, 0.0, 1e-3 * a, c, a, x])
    low, width = ends[:-1, None], np.diff(ends)[:, None]
    place = np.where(t < 0.5, low + width * t, ends[1:, None] - width * rest)
    distance = np.where(low == x, width * t, np.where(ends[1:, None] == x, width * rest, np.abs(x - place)))
    normal, tangential, coupling = PowerLawKernel(contact.solid).values(distance) * (width * weight)
    coupling = np.where(low >= x, -coupling, coupling)
    p, q = contact.pressure(place), contact.traction(place)
    return np.array([np.sum(normal * p - coupling * q), np.sum(tangential * q + coupling * p)])


CASES = [(0.0, 0.2, 0.25, 2.0), (0.3, 0.3, 0.3, 2.0), (-0.3, 0.3, 0.3, 2.0)]
CASES += [(0.2, 0.49, 0.2, 3.0), (-0.5, 0.3, 0.3, 2.0)]  # drawn outwards; no stick
CASES += [(-0.7, -0.3, 3.0, 2.0)]  # mu |d k| > (bk): mu p - q is not singular at any c


@pytest.mark.parametrize("case", CASES)
def test_boundary_conditions(case):
    """u_y = const - A|x|^m in contact, u_x ~ x^m where it sticks; beyond, slip is what u_x has moved since x = a."""
    contact, m = pressing(*case), case[3]
    a, c = contact.contact_half_width, contact.stick_half_width
    (centre, _), (_, edge) = (displacement(contact, x) for x in (0.0, a))
    where = a * np.array([0.01, 0.25, 0.7, 0.97])
    values = np.array([displacement(contact, x) for x in where])
    np.testing.assert_allclose(values[:, 0], centre - A * where**m, atol=1e-7 * A * a**m)
    moved = (where / a) ** m * edge - values[:, 1]
    np.testing.assert_allclose(contact.slip(where), moved, atol=1e-7 * abs(edge))
    stick = where[where < c]
    if len(stick):
        expected = values[len(stick) - 1, 1] * (stick / stick[-1]) ** m
        np.testing.assert_allclose(values[: len(stick), 1], expected, atol=1e-7 * abs(edge))
        np.testing.assert_allclose(values[: len(stick), 1], contact.stick_displacement(stick), atol=1e-6 * abs(edge))
    assert np.all(np.isnan(contact.stick_displacement(where[where > c])))


@pytest.mark.parametrize("case", CASES)
def test_coulomb(case):
    """|q| < mu p where it sticks, = mu p where it slips, against the slip; p, q and slip are even, odd, odd."""
    contact, mu = pressing(*case), case[2]
    a, c = contact.contact_half_width, contact.stick_half_width
    x = np.concatenate([c * np.array([0.1, 0.5, 0.9, 0.999]), c + (a - c) * np.array([0.01, 0.3, 0.9])])[4 * (c == 0) :]
    p, q = contact.pressure(x), contact.traction(x)
    sign = -np.sign(contact.solid.d)
    assert np.all((sign * q >= 0) & (sign * q <= mu * p * (1 + 1e-6)))
    np.testing.assert_allclose(sign * q[x > c], mu * p[x > c], rtol=1e-12)
    assert np.all(sign * contact.slip(x) >= 0)
    for field, parity in ((contact.pressure, 1), (contact.traction, -1), (contact.slip, -1)):
        np.testing.assert_array_equal(field(-x), parity * field(x))
        assert field(1.01 * a) == 0 and np.ndim(field(0.5 * a)) == 0
    t, rest, weight = plain_rule(0.0, 0.0, 40)
    pieces = [(low + (high - low) * t, (high - low) * weight) for low, high in ((0, c), (c, a)) if high > low]
    assert sum(2 * w @ contact.pressure(y) for y, w in pieces) == pytest.approx(P, rel=1e-7)
    assert contact.load(a) == pytest.approx(P, rel=1e-13)


@pytest.mark.parametrize(
    ("k", "nu", "mu", "ratio"), [(0.0, 0.2, 0.25, 0.2925), (0.0, 0.35, 0.12, 0.1754), (0.3, 0.3, 0.3, 0.9806)]
)
def test_stick_ratio(k, nu, mu, ratio):
    """c/a of an independent computation, ± 3e-4."""
    assert pressing(k, nu, mu).stick_ratio == pytest.approx(ratio, abs=3e-4)


def change(one, other):
    """Largest change with the resolution: of c/a, a and energy by their size, of p, q, h_x by their maxima."""
    x = np.linspace(0.02, 0.98, 25)
    changes = [abs(one.stick_ratio - other.stick_ratio)]
    for name in ("contact_half_width", "dissipated_energy"):
        mine, theirs = getattr(one, name), getattr(other, name)
        changes.append(abs(mine - theirs) / mine if mine else 0.0)
    for name in ("pressure", "traction", "slip"):
        mine, theirs = (getattr(c, name)(x * c.contact_half_width) for c in (one, other))
        changes.append(np.max(np.abs(mine - theirs)) / (np.max(np.abs(mine)) or 1.0))
    return max(changes)


def test_finer_panels_change_little():
    """The less the finer they are; c/a by 1e-8."""
    six, eight, ten, twelve = (pressing(0.3, 0.3, 0.3, terms=terms) for terms in (6, 8, 10, 12))
    assert ten.stick_ratio == pytest.approx(twelve.stick_ratio, abs=1e-8)
    assert change(eight, twelve) < change(eight, six) < 3e-4
    assert change(ten, eight) < change(eight, six) / 5


def test_weak_coupling():
    """Spence's K(sqrt(1-c²))/K(c) = gamma/mu for k = 0, gamma = (1-2 nu)/(2(1-nu)) -> 0."""
    nu, mu = 0.499, 1e-3
    c = pressing(0.0, nu, mu).stick_ratio
    assert ellipk(1 - c**2) / ellipk(c**2) == pytest.approx((1 - 2 * nu) / (2 * (1 - nu)) / mu, rel=1e-5)


def test_energy_balance():
    """∫ P d(delta_y) = elastic energy + friction work; P ~ a^(m+k), delta_y ~ a^m."""
    k, m = 0.2, 3.0
    contact = pressing(k, 0.0, 0.1, m)
    a, c, solid = contact.contact_half_width, contact.stick_half_width, contact.solid
    infinity = P * solid.bk / (k * solid.E0)  # the constant that `values` leaves out
    depth = displacement(contact, 0.0)[0] + infinity
    t, weight = np.polynomial.legendre.leggauss(14)
    t = (1 + t) / 2
    blend, slope = t**4 * (35 - 84 * t + 70 * t**2 - 20 * t**3), 140 * (t * (1 - t)) ** 3  # flat at both ends
    stored = 0.0
    for low, high in ((0, c), (c, a)):
        x, w = low + (high - low) * blend, (high - low) * slope * weight / 2
        u_x = np.array([displacement(contact, place)[1] for place in x])
        stored += w @ (contact.pressure(x) * (depth - A * x**m) + contact.traction(x) * u_x)
    assert contact.dissipated_energy == pytest.approx(P * depth * m / (2 * m + k) - stored, rel=2e-5)


def test_similarity():
    """Lengths grow like P^(1/(m+k)), the energy like P a^m."""
    small = pressing(-0.3, 0.3, 0.3)
    large = PressingWithFriction(small.solid, small.profile, small.mu, 8 * P)
    growth = 8 ** (1 / 1.7)
    assert large.contact_half_width == pytest.approx(growth * small.contact_half_width, rel=1e-13)
    assert large.dissipated_energy == pytest.approx(8 * growth**2 * small.dissipated_energy, rel=1e-13)
    x = np.array([0.01, 0.5, 0.9]) * small.contact_half_width
    np.testing.assert_allclose(large.pressure(growth * x), 8 / growth * small.pressure(x), rtol=1e-12)
    np.testing.assert_allclose(large.slip(growth * x), growth**2 * small.slip(x), rtol=1e-12)


@pytest.mark.parametrize(("k", "nu"), [(0.3, 1 / 2.3), (0.0, 0.5)])
def test_holl_ratio(k, nu):
    """No coupling: the pressure of the closed forms, no traction, stick everywhere."""
    contact = pressing(k, nu, 0.3)
    closed = ProfileContact.from_load(contact.solid, contact.profile, P, 10.0)
    x = np.linspace(0.05, 0.95, 7) * closed.a
    np.testing.assert_allclose(contact.pressure(x), closed.pressure(x), rtol=1e-7)
    assert contact.contact_half_width == pytest.approx(closed.a, rel=1e-8)
    assert contact.stick_ratio == 1
    assert np.max(np.abs(contact.traction(x))) <= 1e-6 * P
    assert contact.dissipated_energy <= 1e-12


def test_weak_friction_holds_no_point():
    """k < 0, little friction: every point slips, and p grows like a small power towards the tip."""
    contact = pressing(-0.5, 0.3, 0.3)
    assert contact.stick_ratio == 0
    x = contact.contact_half_width * 10.0 ** -np.arange(2, 14, 2)
    slope = np.diff(np.log(contact.pressure(x))) / np.diff(np.log(x))
    np.testing.assert_allclose(slope, slope[-1], rtol=1e-3)
    assert -0.1 < slope[-1] < 0
    assert contact.pressure(0.0) == np.inf and contact.traction(0.0) == 0
    np.testing.assert_allclose(contact.traction(x), 0.3 * contact.pressure(x), rtol=1e-12)


@pytest.mark.parametrize(("k", "nu", "mu"), [(0.9, 0.5, 0.3), (0.9, 0.2, 2.0), (0.99, 0.5, 0.1)])
def test_strong_friction_near_k_one(k, nu, mu):
    """mu |d k| > (bk): stick up to less than 1e-5 from the edge, as with less friction; no energy is gained."""
    contact = pressing(k, nu, mu)
    assert contact.stick_ratio == pytest.approx(1, abs=1e-5)
    assert 0 <= contact.dissipated_energy < 1e-9
    assert change(contact, pressing(k, nu, mu, terms=8)) < 0.01
    t, rest, weight = plain_rule(0.0, (1 + k) / 2, 40)
    a = contact.contact_half_width
    assert 2 * a * weight @ contact.pressure(a * t) == pytest.approx(P, rel=1e-5)


def test_incremental_solver_approaches_it():
    """The half-plane solver with friction from first contact: its steps add an error of first order in c."""
    contact = pressing(0.0, 0.2, 0.25)
    loads = [(P * 0.81 ** (16 - i), 0.0) for i in range(17)]
    solver = HalfPlaneContact(contact.solid, contact.profile, 0.25, friction_in_normal_stage=True, nodes=120)
    state = solver.run(loads)[-1]
    inside = np.abs(state.x) < 0.99 * contact.contact_half_width
    for name, limit in (("pressure", 2e-3), ("traction", 8e-3)):
        mine, exact = getattr(state, name)[inside], getattr(contact, name)(state.x[inside])
        assert np.linalg.norm(mine - exact) < limit * np.linalg.norm(exact)
    assert state.contact[1] == pytest.approx(contact.contact_half_width, rel=1e-3)
    assert state.stick[1] / state.contact[1] == pytest.approx(contact.stick_ratio, abs=0.02)


def test_refusals():
    solid = GradedHalfPlane(2.0, 0.3, 0.3, 0.7)
    for mu, load, name in ((0.0, P, "mu"), (0.3, 0.0, "P"), (np.nan, P, "mu")):
        with pytest.raises(ValueError, match=name):
            PressingWithFriction(solid, PowerProfile(A, 2.0), mu, load)
