"""Fretting of the cylinder: (51)-(59), [X4], [X5] against defining integrals and friction law."""

import math

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import DIGITS, EPS, EXPONENTS, SELECTED, integrate, kernel_displacement, nonzero, relative_error
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from analytic import CylinderContact, GradedHalfPlane, UndefinedDisplacementError

MU, P, R, NU = 0.3, 1e-3, 3.0, 0.3
RTOL = 1e-12


def contact_of(k, nu=NU):
    return CylinderContact(GradedHalfPlane(2.0, nu, k, 0.2), R, P)


def exact_z(Q):
    return 1 - mp.mpf(Q) / (mp.mpf(MU) * mp.mpf(P))


@pytest.mark.parametrize("k", SELECTED)
@pytest.mark.parametrize("load", [1e-3, 0.4, 0.97])
def test_dissipated_energy_against_integral(k, load):
    """(52) with q = mu p (44) and h_x as printed in (50)."""
    contact, K = contact_of(k), nonzero(k)
    loop = contact.fretting(MU, load * MU * P)
    a = mp.mpf(contact.a)
    c = a * exact_z(load * MU * P) ** (1 / (2 + mp.mpf(k)))
    peak = mp.gamma((4 + K) / 2) * mp.mpf(P) / (mp.sqrt(mp.pi) * mp.gamma((3 + K) / 2) * a)
    term = mp.sqrt(mp.pi) / (K * mp.gamma((4 + K) / 2) * mp.gamma((1 - K) / 2))
    power, alpha = (1 + K) / 2, mp.mpf(contact.solid.alpha)

    def density(u, d):
        x = c + u
        with mp.workdps(DIGITS + 40):
            F = mp.hyp2f1(K / 2, (1 + K) / 2, (4 + K) / 2, (c / x) ** 2)
            h = MU * alpha / (2 * R) * (x**2 - c**2 / K + c**2 * term * (c / x) ** K * F)
        return MU * peak * (d * (a + x) / a**2) ** power * h

    assert relative_error(loop.dissipated_energy, 8 * integrate(density, a - c, right=power)) < RTOL
    x = float(c + (a - c) * mp.mpf("0.6"))
    w = 4 * density(mp.mpf(x) - c, a - mp.mpf(x))
    assert relative_error(loop.energy_density(x), w) < RTOL


@pytest.mark.parametrize("k", EXPONENTS)
@pytest.mark.parametrize("z", [1e-200, 1e-9, 0.01, 0.3, 0.8, 0.99, 1 - 1e-3, 1 - 1e-6, 1 - 1e-9])
def test_dissipated_energy_over_the_whole_range(k, z):
    """[X4] as printed, with enough digits."""
    contact, K = contact_of(k), mp.mpf(k)
    scale = 2 * mp.mpf(MU) ** 2 * mp.mpf(contact.solid.alpha) * mp.mpf(P) * mp.mpf(contact.a) ** 2 / R

    def energy(z):
        gamma = z ** (1 / (2 + K))
        return scale * ((1 - gamma ** (4 + K)) / (4 + K) - gamma**2 * ((1 - gamma**K) / K if k else -mp.log(gamma)))

    assert relative_error(contact.fretting(MU, z=z).dissipated_energy, energy(mp.mpf(z))) < 1e-13
    Q_A = float(mp.mpf(MU) * mp.mpf(P) * (1 - mp.mpf(z)))
    if Q_A < MU * P:
        assert relative_error(contact.fretting(MU, Q_A).dissipated_energy, energy(exact_z(Q_A))) < 1e-13


@pytest.mark.parametrize("k", EXPONENTS)
def test_limits_of_the_dissipated_energy(k):
    """[X4] for Q -> 0 and Q -> mu P."""
    contact = contact_of(k)
    scale = 2 * MU**2 * contact.solid.alpha * P * contact.a**2 / R
    small = contact.fretting(MU, 1e-9 * MU * P).dissipated_energy
    assert small == pytest.approx(scale * 1e-27 / (3 * (2 + k) ** 2), rel=1e-8, abs=0)
    assert contact.fretting(MU, z=1e-300).dissipated_energy == pytest.approx(scale / (4 + k), rel=1e-14, abs=0)
    assert contact.fretting(MU, 0.0).dissipated_energy == 0


@pytest.mark.parametrize("load", [1e-6, 0.01, 0.5, 0.99])
def test_homogeneous_energy(load):
    """(55), (56), (59) for k = 0, and their approach for k -> 0."""
    contact = contact_of(0.0)
    z, a0 = exact_z(load * MU * P), mp.mpf(contact.a0)
    m = z
    scale = 2 * mp.mpf(MU) ** 2 * 2 * a0**4 / ((1 - mp.mpf(NU) ** 2) * R**2)
    bracket = mp.pi / 16 * (1 - m) ** 2 + mp.pi / 8 * m * mp.log(m) + mp.pi / 8 * m * (1 - m)
    root = mp.sqrt(m)

    def integrand(u, d):
        s = root + u
        return mp.sqrt(d * (1 + s)) * (s * mp.sqrt(u * (s + root)) - m * mp.acosh(s / root))

    with mp.workdps(60):
        by_integral = scale * integrate(integrand, 1 - root, digits=60)
    for energy in (
        scale * bracket,
        by_integral,
        MU**2 * P * a0**2 / (2 * R) * (1 - z**2 + 2 * z * mp.log(z)),
    ):
        assert relative_error(contact.fretting(MU, load * MU * P).dissipated_energy, energy) < RTOL
        for k in (1e-12, -1e-12, 1e-8, -1e-8):
            assert relative_error(
                contact_of(k).fretting(MU, load * MU * P).dissipated_energy, energy
            ) < RTOL + 10 * abs(k)


@pytest.mark.parametrize("k", EXPONENTS)
def test_energy_is_the_integral_of_its_density(k):
    """(52): ΔW = 2 ∫_c^a w dx."""
    loop = contact_of(k).fretting(MU, 0.7 * MU * P)
    v, weight = np.polynomial.legendre.leggauss(400)
    v = (1 + v) / 2
    x = loop.c + (loop.a - loop.c) * (1 - v**2)  # w falls like (a-x)^((1+k)/2)
    total = 2 * np.sum(weight / 2 * 2 * v * (loop.a - loop.c) * loop.energy_density(x))
    assert total == pytest.approx(loop.dissipated_energy, rel=1e-6, abs=0)
    np.testing.assert_array_equal(loop.energy_density([-2 * loop.a, 0.0, 0.99 * loop.c, loop.a, 2 * loop.a]), 0)
    np.testing.assert_array_equal(loop.energy_density(-x), loop.energy_density(x))


@pytest.mark.parametrize("k", [-0.9, -0.3, 0.0, 0.5, 0.9])
def test_maximum_of_the_energy_density(k):
    """Its place tends to a √(2/(3+k)) for c -> 0 and to c + (a-c)(3-k)/4 for c -> a."""

    def place(loop):
        width = loop.a - loop.c
        best = minimize_scalar(
            lambda t: -loop.energy_density(loop.c + t * width),
            bounds=(0, 1),
            method="bounded",
            options={"xatol": 1e-9},
        )
        return loop.c + best.x * width

    sliding = contact_of(k).fretting(MU, z=1e-12)
    assert place(sliding) / sliding.a == pytest.approx(math.sqrt(2 / (3 + k)), abs=1e-5)
    sticking = contact_of(k).fretting(MU, 1e-5 * MU * P)
    assert (place(sticking) - sticking.c) / (sticking.a - sticking.c) == pytest.approx((3 - k) / 4, abs=1e-4)


@pytest.mark.parametrize("k", [-0.9, 0.0, 0.5])
@pytest.mark.parametrize("share", [0.6, 0.0, -0.95])
def test_unloading_against_kernel(k, share):
    """[X5]: kernel (2) under the traction gives the slip; frozen inside d, q = -mu p outside."""
    contact, K = contact_of(k), nonzero(k)
    Q_A = 0.8 * MU * P
    loop = contact.fretting(MU, Q_A)
    Q = share * Q_A
    a = mp.mpf(contact.a)
    c = a * exact_z(Q_A) ** (1 / (2 + mp.mpf(k)))
    d = a * (1 - (mp.mpf(Q_A) - mp.mpf(Q)) / (2 * mp.mpf(MU) * mp.mpf(P))) ** (1 / (2 + mp.mpf(k)))
    assert relative_error(loop.active_half_width(Q, "unloading"), d) < RTOL
    assert relative_error(loop.c, c) < RTOL
    power, peak = (1 + K) / 2, mp.mpf(MU) * mp.mpf(contact.peak_pressure)
    compliance = mp.mpf(contact.solid.tangential_compliance)

    def pressure(s, x):
        return peak * ((s - x) * (s + x) / a**2) ** power if x < s else mp.mpf(0)

    def shift(s, x):
        return kernel_displacement(K, compliance, lambda u, e: peak * (e * (s + u) / a**2) ** power, x, s, power)

    for x in (float(0.5 * c), float((c + d) / 2), float((a + d) / 2)):
        X = mp.mpf(x)
        q = 2 * pressure(d, X) - pressure(a, X) - pressure(c, X)
        assert relative_error(loop.traction(x, Q, "unloading"), q) < RTOL
        h = 2 * shift(d, X) - shift(a, X) - shift(c, X)
        assert abs(loop.slip(x, Q, "unloading") - h) < 1e-13 * loop.amplitude.slip(contact.a)
        if X < d:
            assert loop.slip(x, Q, "unloading") == loop.amplitude.slip(x)
        else:
            assert loop.traction(x, Q, "unloading") == -MU * contact.pressure(x)


@pytest.mark.parametrize("k", SELECTED)
def test_nearly_sliding_loop(k):
    """[X5] where c and d are tiny: Q_A from z, Q just above -Q_A."""
    contact = contact_of(k)
    loop = contact.fretting(MU, z=1e-9)
    Q = -loop.Q_A * (1 - 1e-9)
    remaining = (mp.mpf(loop.Q_A) + mp.mpf(Q)) / (2 * mp.mpf(MU) * mp.mpf(P))
    d = mp.mpf(contact.a) * (mp.mpf(1e-9) + remaining) ** (1 / (2 + mp.mpf(k)))
    assert relative_error(loop.active_half_width(Q, "unloading"), d) < RTOL


@settings(max_examples=100)
@given(
    st.one_of(st.floats(-0.99, 0.99), st.sampled_from(EXPONENTS)),
    st.floats(-0.9, 0.5),
    st.floats(1e-9, 1 - 1e-9),
    st.floats(-1, 1),
    st.lists(st.floats(0, 1), min_size=4, max_size=4),
)
def test_properties(k, nu, load, share, ratios):
    """[X5]: closed loop, friction law, equilibrium and symmetry of random cycles."""
    contact = contact_of(k, nu)
    Q_A = load * MU * P
    loop, Q = contact.fretting(MU, Q_A), share * Q_A
    x = contact.a * np.array(ratios).reshape(2, 2)
    limit, full = MU * contact.pressure(x), loop.amplitude
    q, h = loop.traction(x, Q, "unloading"), loop.slip(x, Q, "unloading")
    assert q.shape == h.shape == (2, 2)
    assert np.all(np.abs(q) <= limit * (1 + 1e-14))
    assert loop.c * (1 - EPS) <= loop.active_half_width(Q, "unloading") <= loop.a
    assert loop.traction_within(2 * loop.a, Q, "unloading") == pytest.approx(Q, abs=1e-14 * Q_A)
    np.testing.assert_array_equal(loop.traction(x, -Q, "reloading"), -q)
    np.testing.assert_array_equal(loop.slip(x, -Q, "reloading"), -h)
    np.testing.assert_array_equal(loop.traction_within(x, -Q, "reloading"), -loop.traction_within(x, Q, "unloading"))
    # ends of the branches
    scale_q, scale_h = 1e-14 * full.traction(loop.c), 1e-13 * full.slip(loop.a)
    for branch, end in (("initial", 1), ("reloading", 1), ("unloading", -1)):
        np.testing.assert_allclose(
            loop.traction(x, end * Q_A, branch), end * full.traction(x), rtol=1e-12, atol=scale_q
        )
        np.testing.assert_allclose(loop.slip(x, end * Q_A, branch), end * full.slip(x), rtol=1e-12, atol=scale_h)
    np.testing.assert_array_equal(loop.traction(x, Q_A, "unloading"), full.traction(x))
    np.testing.assert_array_equal(loop.traction(x, 0, "initial"), 0)
    # slip moves against the traction: back during unloading
    assert np.all(h <= full.slip(x) + scale_h)


def test_memory():
    """[X5]: at Q = 0 a self-equilibrated traction remains."""
    loop = contact_of(-0.3).fretting(MU, 0.9 * MU * P)
    x = np.linspace(0, loop.a, 50)
    q = loop.traction(x, 0.0, "unloading")
    assert q.min() < -0.1 * q.max() < 0
    assert loop.traction_within(loop.a, 0.0, "unloading") == pytest.approx(0, abs=1e-15 * loop.Q_A)


@pytest.mark.parametrize("k", [1e-3, 0.3, 0.5, 0.9, 0.99])  # delta_x is of size 1/k, ΔW is not
@pytest.mark.parametrize("load", [0.1, 0.6, 0.95])
def test_loop_area(k, load):
    """∮ Q d delta_x = ΔW for k > 0, with (40), (49) on the branches of [X5]."""
    loop = contact_of(k).fretting(MU, load * MU * P)
    node, weight = np.polynomial.legendre.leggauss(80)
    Q = loop.Q_A * node
    width = loop.rigid_shift(Q, "unloading") - loop.rigid_shift(Q, "reloading")
    area = loop.Q_A * weight @ width
    assert area == pytest.approx(loop.dissipated_energy, rel=1e-12 + 4 * EPS / (k * load**2), abs=0)
    assert loop.rigid_shift(loop.Q_A, "initial") == pytest.approx(loop.amplitude.rigid_shift, rel=1e-14)
    assert loop.rigid_shift(-loop.Q_A, "unloading") == pytest.approx(-loop.amplitude.rigid_shift, rel=1e-12)


def test_loads_and_points_broadcast():
    """Arrays of Q and x in, arrays out."""
    loop = contact_of(-0.4).fretting(MU, 0.6 * MU * P)
    x, Q = np.linspace(-1, 1, 5) * loop.a, loop.Q_A * np.array([[1.0], [0.2], [-1.0]])
    for field in (loop.traction, loop.traction_within, loop.slip):
        table = field(x, Q, "unloading")
        assert table.shape == (3, 5)
        for i in range(3):
            np.testing.assert_allclose(table[i], field(x, float(Q[i, 0]), "unloading"), rtol=1e-14)
    assert np.ndim(loop.traction(0.0, 0.0, "initial")) == 0
    assert loop.active_half_width(Q, "reloading").shape == (3, 1)


def test_inadmissible_cycles():
    """Every refusal names the value and the range."""
    loop = contact_of(-0.4).fretting(MU, 1e-4)
    with pytest.raises(ValueError, match=r"branch = 'down' is not one of \('initial', 'unloading', 'reloading'\)"):
        loop.traction(0.0, 0.0, "down")
    with pytest.raises(ValueError, match=r"Q = .*0.0002.* is outside the unloading branch, -0.0001 <= Q <= 0.0001"):
        loop.slip(0.0, 2e-4, "unloading")
    with pytest.raises(ValueError, match=r"is outside the initial branch, 0.0 <= Q <= 0.0001"):
        loop.slip(0.0, [0.0, -1e-4], "initial")
    with pytest.raises(ValueError, match=r"Q_A = -0.0001 .* 0 <= Q_A < mu P"):
        contact_of(0.1).fretting(MU, -1e-4)
    with pytest.raises(ValueError, match=r"Q = 0.001 .* < mu P"):
        contact_of(0.1).fretting(MU, 1e-3)
    with pytest.raises(UndefinedDisplacementError, match="without bound"):
        loop.rigid_shift(0.0, "unloading")
    assert loop.traction(0.0, 1e-4 * (1 + 1e-15), "unloading") == loop.amplitude.traction(0.0)
