"""Any convex profile: (5)-(8), (10), (11), (33)-(36), (40), (52) against integrals, kernel (2)."""

from functools import lru_cache

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import Medium, abel_derivative, relative_error

from analytic import CylinderContact, GradedHalfPlane, PowerProfile, Profile, ProfileContact, UndefinedDisplacementError
from analytic.special import punch_rigid_factor

E0, NU, Y0, MU = 2.0, 0.3, 0.2, 0.5
RTOL = 1e-12


def solid_of(k):
    return GradedHalfPlane(E0, NU, k, Y0)


def circle(radius):
    """Circular section, the shape of a true cylinder."""
    return Profile(
        lambda x: x**2 / (radius + np.sqrt((radius - x) * (radius + x))),
        lambda x: x / np.sqrt((radius - x) * (radius + x)),
        lambda x: radius**2 / ((radius - x) * (radius + x)) ** 1.5,
    )


def rounded_punch(flat, radius):
    """Flat punch with parabolically rounded edges."""
    return Profile(
        lambda u: u**2 / (2 * radius),
        lambda u: u / radius,
        lambda u: np.full_like(u, 1 / radius),
        flat=flat,
    )


MIXED = Profile(  # of powers that no series has
    lambda x: x**1.5 + x**2, lambda x: 1.5 * x**0.5 + 2 * x, lambda x: 0.75 * x**-0.5 + 2, order=1.5
)

BLUNT = Profile(  # beside whose tip a power is 0 to a float
    lambda x: x**120, lambda x: 120 * x**119, lambda x: 120 * 119 * x**118, order=120.0
)


@lru_cache
def power_reference(k, m):
    """Medium and the factor of n_y = factor s^(m-1), from (5) at s = 1."""
    medium = Medium(E0, NU, k, Y0)
    at_one = abel_derivative(lambda x: mp.mpf("0.3") * m * x ** (m - 1), medium.k, mp.mpf(1))
    return medium, medium.density(at_one, mp.mpf(1))


@pytest.mark.parametrize("k", [-0.9, 0.0, 0.5])
@pytest.mark.parametrize("m", [1.0, 1.5, 2.0, 4.0])
def test_power_profiles(k, m):
    """(5)-(8), (10), (11) of f = 0.3 |x|^m: wedge to blunt."""
    medium, factor = power_reference(k, m)
    contact = ProfileContact(solid_of(k), PowerProfile(0.3, m), 0.7)
    a = mp.mpf(0.7)

    def n(s):
        return factor * s ** (m - 1)

    assert relative_error(contact.density(1.0), factor) < 1e-14
    load = medium.load(lambda s: n(s), a) if m + k > 0.2 else factor * a ** (m + k) / (m + k)
    assert relative_error(contact.P, load) < 1e-14
    for x in (0.01, 0.4, 0.699):
        assert relative_error(contact.pressure(x), medium.pressure(n, mp.mpf(x), a)) < RTOL
        assert relative_error(contact.relative_displacement(x), mp.mpf("0.3") * mp.mpf(x) ** m) < RTOL
    if m + k > 0.2:
        for x in (0.701, 0.8, 30.0):
            exact = medium.relative_displacement(n, mp.mpf(x), a)
            assert relative_error(contact.relative_displacement(x), exact) < RTOL
            assert contact.relative_displacement(-x) == contact.relative_displacement(x)
    if k > 0:
        assert relative_error(contact.indentation, medium.displacement(n, mp.mpf(0), a)) < RTOL
        for x in (0.3, 0.71, 30.0):
            assert relative_error(contact.displacement(x), medium.displacement(n, mp.mpf(x), a)) < RTOL
    else:
        with pytest.raises(UndefinedDisplacementError):
            _ = contact.indentation


@pytest.mark.parametrize("k", [-0.99, -0.5, 0.0, 1e-8, 0.5, 0.99])
def test_parabola_is_the_cylinder(k):
    """The general contact, given the parabola by callables, against all closed forms."""
    cylinder = CylinderContact(solid_of(k), 3.0, 1e-3)
    parabola = Profile(lambda x: x**2 / 6, lambda x: x / 3, lambda x: np.full_like(x, 1 / 3))
    contact = ProfileContact(solid_of(k), parabola, cylinder.a)
    assert ProfileContact.from_load(solid_of(k), parabola, 1e-3, 10.0).a == pytest.approx(cylinder.a, rel=1e-13, abs=0)
    x = cylinder.a * np.array([0.0, 1e-9, 0.1, 0.5, 0.9, 0.999, 1.0, 1.5, 1e3])
    same = {"rtol": RTOL, "atol": 0}
    for name in ("pressure", "pressure_within", "relative_displacement"):
        np.testing.assert_allclose(getattr(contact, name)(x), getattr(cylinder, name)(x), **same)
    if k > 0:
        np.testing.assert_allclose(contact.displacement(x), cylinder.displacement(x), **same)
    for load in (1e-9, 1e-4, 0.5, 0.99):
        # the loop is given by z, as P of the two contacts differs by rounding
        loops = [c.fretting(MU, z=1 - load) for c in (contact, cylinder)]
        general, closed = (loop.amplitude for loop in loops)
        c, a = closed.c, closed.a
        points = np.concatenate([[-0.5 * c, 0.3 * c, 0.9 * c], c + (a - c) * np.array([0.3, 0.8, 1.0])])
        assert general.c == pytest.approx(c, rel=RTOL)
        for name in ("traction", "traction_within", "slip", "slip_gradient"):
            np.testing.assert_allclose(getattr(general, name)(points), getattr(closed, name)(points), **same)
        assert loops[0].dissipated_energy == pytest.approx(loops[1].dissipated_energy, rel=RTOL, abs=0)
        Q = 0.3 * loops[1].Q_A
        turned = [loop.slip(points, Q, "unloading") for loop in loops]
        np.testing.assert_allclose(*turned, rtol=RTOL, atol=1e-13 * closed.slip(a))
        if k > 0:
            assert general.rigid_shift == pytest.approx(closed.rigid_shift, rel=RTOL, abs=0)


@pytest.mark.parametrize("k", [-0.6, 0.0, 0.7])
@pytest.mark.parametrize("profile", [circle(1.0), rounded_punch(0.3, 2.0)], ids=["circle", "rounded punch"])
def test_profile_against_kernel(k, profile):
    """(5) by differences of its integral; (8): kernel (2) under the pressure is the profile."""
    contact, medium = ProfileContact(solid_of(k), profile, 0.6), Medium(E0, NU, k, Y0)

    def slope(x):
        return (x - mp.mpf(0.3)) / 2 if profile.flat else x / mp.sqrt(1 - x**2)

    for s in (mp.mpf(0.35), mp.mpf(0.6)):
        exact = medium.density(abel_derivative(slope, medium.k, s, mp.mpf(profile.flat)), s)
        assert relative_error(contact.density(float(s)), exact) < RTOL
    # equilibrium and profile
    assert contact.pressure_within(0.7) == pytest.approx(contact.P, rel=RTOL)
    power, compliance = (1 + k) / 2, contact.solid.normal_compliance
    for x in (0.2, 0.45, 0.59):
        breaks = sorted({0.0, x, 0.6, *([0.3] if profile.flat else [])})
        h = kernel_quadrature(contact.pressure, k, x, breaks, power)
        assert compliance * h == pytest.approx(profile.height(np.float64(x)), rel=1e-8, abs=1e-8 * profile.height(0.59))


def test_a_flat_that_ends_sharper_than_a_parabola():
    """f'' is infinite at the end of the flat, and (5) has all its digits."""
    flat, k, s = 0.3, 0.2, 0.6
    profile = Profile(lambda u: u**1.1, lambda u: 1.1 * u**0.1, lambda u: 0.11 * u**-0.9, flat=flat, order=1.1)
    exact = abel_derivative(lambda x: 1.1 * (x - mp.mpf(flat)) ** 0.1, mp.mpf(k), mp.mpf(s), mp.mpf(flat))
    assert relative_error(profile.abel_density(s, k) * s**k, exact) < RTOL


def kernel_quadrature(pressure, k, x, breaks, power):
    """1/k ∫ p(t) (|t|^-k - |x-t|^-k) dt in binary64, with nodes crowded at every break."""
    v, weight = np.polynomial.legendre.leggauss(120)
    v, weight = (1 + v) / 2, weight / 2

    def kernel(distance):
        return -np.expm1(-k * np.log(distance)) / k if k else np.log(distance)

    total = 0.0
    for low, high in zip(breaks, breaks[1:], strict=False):
        half = (high - low) / 2
        for end, sign in ((low, 1), (high, -1)):
            u = half * v**8
            t = end + sign * u
            du = weight * half * 8 * v**7
            to_x = u if end == x else np.abs(t - x)
            to_zero = u if end == 0 else t
            mirrored = kernel(x + t)
            # both signs of t; the constants of |t|^-k and |x-t|^-k cancel
            total += np.sum(du * pressure(t) * (kernel(to_x) + mirrored - 2 * kernel(to_zero)))
    return total


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize(
    "profile",
    [PowerProfile(0.3, 1.0), PowerProfile(0.3, 3.0), circle(1.0), rounded_punch(0.3, 2.0)],
    ids=["wedge", "cubic", "circle", "rounded punch"],
)
def test_partial_slip_of_any_profile(k, profile):
    """(25), (26), (33)-(36), (40), (51), (52) for shapes without closed forms."""
    contact = ProfileContact(solid_of(k), profile, 0.6)
    loop = contact.fretting(MU, 0.55 * MU * contact.P)
    state = loop.amplitude
    c, a = state.c, state.a
    assert profile.flat < c < a
    inner = ProfileContact(solid_of(k), profile, c)
    assert inner.P == pytest.approx(0.45 * contact.P, rel=RTOL)
    resting = contact.partial_slip(MU, 0.0)
    assert resting.c == a and resting.traction(0.9 * a) == resting.slip(0.9 * a) == 0
    x = np.concatenate([c * np.array([0.2, 0.7, 0.99]), c + (a - c) * np.array([0.01, 0.5, 0.99])])
    np.testing.assert_allclose(state.traction(x), MU * (contact.pressure(x) - inner.pressure(x)), rtol=1e-10)
    expected = MU * (contact.pressure_within(x) - inner.pressure_within(x))
    np.testing.assert_allclose(state.traction_within(x), expected, rtol=RTOL)
    assert state.traction_within(1.0) == pytest.approx(state.Q, rel=RTOL)
    outside = x[x > c]
    gap = profile.height(outside) - inner.relative_displacement(outside)
    alpha = contact.solid.alpha
    np.testing.assert_allclose(state.slip(outside), MU * alpha * gap, rtol=1e-8, atol=1e-12 * profile.height(a))
    assert np.all(state.slip(x[x < c]) == 0)
    step = 1e-5 * (a - c)
    difference = (state.slip(outside[1] + step) - state.slip(outside[1] - step)) / (2 * step)
    assert state.slip_gradient(outside[1]) == pytest.approx(difference, rel=1e-8)
    # 2 ∫ w dx, with nodes crowded at c and a, where w ~ (x-c)^((3-k)/2) and (a-x)^((1+k)/2)
    v, weight = np.polynomial.legendre.leggauss(40)
    t, dt = ((1 + v) / 2) ** 4 / 2, weight * ((1 + v) / 2) ** 3
    w = loop.energy_density(c + (a - c) * t) + loop.energy_density(a - (a - c) * t)
    total = 2 * (a - c) * np.sum(dt * w)
    assert loop.dissipated_energy == pytest.approx(total, rel=1e-9, abs=0)
    if k > 0:
        assert state.rigid_shift == pytest.approx(MU * alpha * (contact.indentation - inner.indentation), rel=RTOL)
    q = loop.traction(x, -0.2 * loop.Q_A, "unloading")
    assert np.all(np.abs(q) <= MU * contact.pressure(x) * (1 + 1e-13))
    assert loop.traction_within(1.0, -0.2 * loop.Q_A, "unloading") == pytest.approx(-0.2 * loop.Q_A, rel=1e-11, abs=0)


@pytest.mark.parametrize(("k", "z"), [(-0.9, 0.01), (-0.99, 0.5), (0.5, 1e-8)])
def test_wedge_with_a_narrow_stick_zone(k, z):
    """P ~ a^(1+k), so that c is far below a: (52) by powers of s, and the slip beside the contact."""
    contact = ProfileContact(solid_of(k), PowerProfile(0.3, 1.0), 0.6)
    state = contact.partial_slip(MU, z=z)
    K, a = mp.mpf(k), mp.mpf(0.6)
    c = a * mp.exp(mp.mpf(state.log_ratio) / (1 + K))

    def power(n):
        return (a**n - c**n) / n

    # P(s) = P (s/a)^(1+k) in the integral of ``slip_work``
    A, C = a ** (1 + K), c ** (1 + K)
    share = (power(1) * (A + C) - power(2 + K) - A * C * power(-K)) / A**2
    scale = 4 * contact.P**2 * contact.solid.normal_compliance * punch_rigid_factor(k)
    assert relative_error(contact.slip_work(state.log_ratio), scale * share) < RTOL
    assert state.traction_within(0.599) == pytest.approx(
        MU * (contact.pressure_within(0.599) - z * contact.P), rel=RTOL
    )
    inner = ProfileContact(solid_of(k), contact.profile, float(c))
    for x in (0.6001, 0.9, 20.0):
        h = contact.relative_displacement(x) - inner.relative_displacement(x)
        assert state.slip(x) == pytest.approx(MU * contact.solid.alpha * h, rel=1e-11, abs=0)


def test_half_widths_of_blunt_profiles():
    """P ~ a^(m+k) of large m; beside a flat, where doubles leave few digits of c - flat."""
    blunt = ProfileContact(solid_of(0.3), PowerProfile(1.0, 500.0), 1.0)
    assert blunt.half_width(np.log(0.97)) == pytest.approx(0.97 ** (1 / 500.3), rel=1e-14)
    flat = ProfileContact(GradedHalfPlane(2.0, 0.3, -0.9, 1.0), rounded_punch(0.3, 1.0), 1.0)
    c = flat.half_width(np.log(1e-4))
    assert ProfileContact(flat.solid, flat.profile, c).P == pytest.approx(1e-4 * flat.P, rel=1e-9)


def test_sharp_and_blunt_tips():
    """A wedge has infinite pressure at its tip for k <= 0 and a finite one for k > 0."""
    assert ProfileContact(solid_of(-0.1), PowerProfile(0.3, 1.0), 0.6).pressure(0.0) == np.inf
    on_the_border = ProfileContact(solid_of(-0.3), PowerProfile(0.3, 1.3), 0.6)  # 0.3 = 1.3 - 1 to round-off alone
    assert on_the_border.pressure(0.0) == np.inf
    pressure = ProfileContact(solid_of(0.6), PowerProfile(0.3, 1.0), 0.6).pressure
    assert pressure(0.0) == pytest.approx(pressure(1e-14), rel=1e-7)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (lambda: PowerProfile(0.0, 2.0), r"A = 0.0 .* 0.0 < A"),
        (lambda: PowerProfile(1.0, 0.9), r"m = 0.9 .* 1 <= m"),
        (lambda: Profile(abs, abs, abs, flat=-1.0), r"flat = -1.0 .* 0.0 <= flat"),
        (lambda: Profile(abs, abs, abs, flat=1.0, order=1.0), r"order = 1.0 .* 1 < order"),
        (
            lambda: ProfileContact(solid_of(0.1), rounded_punch(0.3, 1.0), 0.3),
            r"a = 0.3 .* 0.3 < a",
        ),
        (
            lambda: ProfileContact.from_load(solid_of(0.1), circle(1.0), -1.0, 0.5),
            r"P = -1.0 .* 0.0 < P",
        ),
        (
            lambda: ProfileContact.from_load(solid_of(0.1), circle(1.0), 99.0, 0.5),
            r"P = 99.0 .* P <= 0\.\d+",
        ),
    ],
)
def test_inadmissible_profiles(arguments, message):
    """Every refusal names the value and the range."""
    with pytest.raises(ValueError, match=message):
        arguments()


@pytest.mark.parametrize("k", [-0.9, 0.3])
@pytest.mark.parametrize(
    "smooth, profile, a",
    [
        (True, circle(1.0), 0.3),
        (True, rounded_punch(0.2, 1.0), 0.35),
        (False, rounded_punch(1e-3, 1.0), 0.35),
        (False, MIXED, 0.3),
        (False, BLUNT, 0.3),
    ],
)
def test_the_density_is_a_series_where_that_has_all_digits(k, smooth, profile, a):
    """At once beside the flat too; where it is none the quadrature itself is taken, equal to the last bit."""
    s = profile.flat + (a - profile.flat) * np.append(np.geomspace(1e-9, 0.1, 50), np.linspace(0.1, 1.0, 50))
    quick, exact = profile.density_within(k, a)(s), profile.abel_density(s, k)
    np.testing.assert_allclose(quick, exact, rtol=1e-14)
    assert np.array_equal(quick, exact) is not smooth
