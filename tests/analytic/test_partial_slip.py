"""Partial slip of the cylinder (25)-(36), (39), (40), (47)-(50), [X2], [X3]."""

from functools import lru_cache

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import (
    DIGITS,
    EPS,
    EXPONENTS,
    SELECTED,
    Cylinder,
    kernel_displacement,
    load_within,
    relative_error,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from analytic import CylinderContact, GradedHalfPlane, UndefinedDisplacementError

MU, P, R = 0.3, 1e-3, 3.0
RTOL = 1e-12
LOADS = [1e-9, 1e-5, 0.1, 0.6, 1 - 1e-4, 1 - 1e-9]  # Q/(mu P)


@lru_cache
def reference(k):
    return Cylinder(2.0, 0.3, k, 0.2, R, P)


def contact_of(k, nu=0.3, y0=0.2):
    return CylinderContact(GradedHalfPlane(2.0, nu, k, y0), R, P)


def states(k):
    """State and exact z for all loads."""
    contact = contact_of(k)
    for load in LOADS:
        Q = load * MU * P
        yield contact.partial_slip(MU, Q), 1 - mp.mpf(Q) / (mp.mpf(MU) * mp.mpf(P))
    yield contact.partial_slip(MU, z=1e-200), mp.mpf(1e-200)


@pytest.mark.parametrize("k", EXPONENTS)
def test_stick_half_width(k):
    """(34), (48) from Q or from z; Q comes back."""
    for state, z in states(k):
        c = mp.mpf(state.a) * z ** (1 / (2 + mp.mpf(k)))
        tolerance = 1e-13 if z < 1e-100 else 1e-14  # the logarithm of z has the size 460
        assert relative_error(state.c, c) < tolerance
        assert relative_error(state.z, z) < tolerance
        assert relative_error(state.Q, mp.mpf(MU) * mp.mpf(P) * (1 - z)) < 1e-15
    exact = reference(k)
    inner = exact.load(exact.n, exact.stick_half_width(0.3))
    assert relative_error(0.3, inner / mp.mpf(P)) < 1e-15


@pytest.mark.parametrize("k", SELECTED)
def test_traction(k):
    """(33), (47) with (7): for every load, stick zone, slip zone, and beside both edges."""
    exact = reference(k)
    power = (1 + mp.mpf(k)) / 2
    scale = mp.mpf(MU * P) / exact.load(exact.n, mp.mpf(contact_of(k).a))
    for state, z in states(k):
        a, c = mp.mpf(state.a), mp.mpf(state.a) * z ** (1 / (2 + mp.mpf(k)))
        width = a - c
        outside = [c + 0.3 * width]
        inside = [0.3 * c, c - 0.5 * width, c - 0.01 * width, c - 1e-4 * c]
        for x in [0.0, *(float(x) for x in inside + outside if x > 0)]:
            X = mp.mpf(x)
            outer = scale * exact.pressure(exact.n, X, a)
            inner = scale * exact.pressure(exact.n, X, c) if X < c else mp.mpf(0)
            q = outer - inner
            # binary64 holds c - x to EPS a only; the inner pressure is of the order (c - x)^power
            conditioning = 4 * EPS * a * power * inner / (q * abs(c - X))
            tolerance = RTOL + float(conditioning)
            assert relative_error(state.traction(x), q) < tolerance
            assert state.traction(-x) == state.traction(x)


@pytest.mark.parametrize("k", SELECTED)
def test_slip_against_integral(k):
    """(36), (50), [X2] against (35)."""
    exact = reference(k)
    contact = contact_of(k)
    for load in (1e-3, 0.9):
        state = contact.partial_slip(MU, load * MU * P)
        a = mp.mpf(state.a)
        c = a * (1 - mp.mpf(load * MU * P) / (MU * mp.mpf(P))) ** (1 / (2 + mp.mpf(k)))
        for fraction in (0.1, 1):
            x = mp.mpf(float(c + fraction * (a - c)))
            h = MU * exact.relative_displacement(exact.n, x, a, start=c, parameter=exact.g)
            conditioning = float(4 * EPS * 1.5 * a / (x - c))
            assert relative_error(state.slip(float(x)), h) < RTOL + conditioning


@pytest.mark.parametrize("k", EXPONENTS)
def test_slip_over_the_whole_range(k):
    """(50) as printed, with enough digits, for every load and just beside c."""
    exact = reference(k)
    K = exact.k
    for state, z in states(k):
        with mp.workdps(DIGITS + 60):
            a, c = mp.mpf(state.a), mp.mpf(state.a) * z ** (1 / (2 + mp.mpf(k)))
            term = mp.sqrt(mp.pi) / (K * mp.gamma((4 + K) / 2) * mp.gamma((1 - K) / 2))
            for fraction in (1e-9, 1e-6, 1e-3, 0.1, 0.9, 1):
                x = mp.mpf(float(c + fraction * (a - c)))
                if x <= c or float(x) <= state.c:
                    continue
                F = mp.hyp2f1(K / 2, (1 + K) / 2, (4 + K) / 2, (c / x) ** 2)
                bracket = x**2 - c**2 / K + c**2 * term * (c / x) ** K * F
                conditioning = float(4 * EPS * (3 - K) / 2 * a / (x - c))  # as for the traction
                h = mp.mpf(MU) * exact.alpha / (2 * R) * bracket
                assert relative_error(state.slip(float(x)), h) < RTOL + conditioning
                assert state.slip(-float(x)) == state.slip(float(x))


@pytest.mark.parametrize("k", [-0.9, 0.0, 0.5])
def test_slip_against_kernel(k):
    """(2) under the traction (47): no slip for |x| < c (25), (36) for c < x < a, (21) for x > a."""
    contact, K = contact_of(k), mp.mpf(k) if k else mp.mpf("1e-30")
    state = contact.partial_slip(MU, 0.6 * MU * P)
    a = mp.mpf(state.a)
    c = a * (1 - mp.mpf(0.6 * MU * P) / (MU * mp.mpf(P))) ** (1 / (2 + mp.mpf(k)))
    power, compliance = (1 + K) / 2, mp.mpf(contact.solid.tangential_compliance)
    peak = MU * mp.mpf(contact.peak_pressure)

    def relative(x):
        outer = kernel_displacement(K, compliance, lambda u, d: peak * (d * (a + u) / a**2) ** power, x, a, power)
        return outer - kernel_displacement(
            K, compliance, lambda u, d: peak * (d * (c + u) / a**2) ** power, x, c, power
        )

    scale = abs(relative(a))
    for x in (0.1 * c, 0.8 * c):
        assert abs(relative(x)) < 1e-14 * scale
        assert state.slip(float(x)) == 0
    for x in (c + 0.2 * (a - c), c + 0.8 * (a - c), 1.1 * a, 5 * a):
        assert relative_error(state.slip(float(x)), relative(mp.mpf(float(x)))) < RTOL


@pytest.mark.parametrize("k", SELECTED)
def test_slip_gradient(k):
    """[X3] against the derivative of (35), and its power law beside c."""
    contact = contact_of(k)
    state = contact.partial_slip(MU, 0.6 * MU * P)
    c, a = state.c, state.a
    exact, step = reference(k), mp.mpf(10) ** -12
    for fraction in (0.1, 0.7):
        x = mp.mpf(float(c + fraction * (a - c)))
        h = [
            MU * exact.relative_displacement(exact.n, x + s * step, mp.mpf(2 * a), start=mp.mpf(c), parameter=exact.g)
            for s in (-1, 1)
        ]
        assert relative_error(state.slip_gradient(float(x)), (h[1] - h[0]) / (2 * step)) < 1e-11  # step² and c to EPS
        assert state.slip_gradient(-float(x)) == -state.slip_gradient(float(x))
    near = state.slip_gradient(c + (a - c) * np.array([1e-5, 2e-5]))
    assert np.log2(near[1] / near[0]) == pytest.approx((1 - k) / 2, abs=1e-4)
    assert state.slip_gradient(0.5 * c) == 0


@pytest.mark.parametrize("k", SELECTED)
def test_traction_within(k):
    """∫q dx with q = mu [p(x,a) - p(x,c)] as printed in (47), every load, stick and slip zone."""
    power = (1 + mp.mpf(k)) / 2
    for state, z in states(k):
        a, c = mp.mpf(state.a), mp.mpf(state.a) * z ** (1 / (2 + mp.mpf(k)))
        width, whole = a - c, load_within(a, a, power)
        points = (0.6 * c, 0.72 * c, 0.95 * c, c - 0.1 * width, c, c + 0.4 * width)
        for x in {float(x) for x in points if x > 0}:
            part = load_within(mp.mpf(x), a, power) - load_within(mp.mpf(x), c, power)
            T = mp.mpf(MU) * mp.mpf(P) * part / whole
            assert relative_error(state.traction_within(x), T) < RTOL
            assert state.traction_within(-x) == -state.traction_within(x)
        assert state.traction_within(2 * state.a) == pytest.approx(state.Q, rel=1e-15, abs=0)


@pytest.mark.parametrize("k", [k for k in EXPONENTS if k > 0])
def test_rigid_shift(k):
    """(39), (40), (49) against (20)."""
    exact = reference(k)
    for state, z in states(k):
        a, c = mp.mpf(state.a), mp.mpf(state.a) * z ** (1 / (2 + mp.mpf(k)))
        shift = exact.constant() * (exact.slope * (a**2 - c**2) / 2) * exact.g * exact.y0**exact.k / exact.E0 * MU
        assert relative_error(state.rigid_shift, shift) < RTOL


def test_undefined_rigid_shift():
    """delta_x does not exist for k <= 0."""
    with pytest.raises(UndefinedDisplacementError, match="without bound"):
        _ = contact_of(-0.2).partial_slip(MU, 1e-5).rigid_shift


@pytest.mark.parametrize("y0", [1e-6, 1e6])
@pytest.mark.parametrize("k", [-0.99, -0.5, 0.5, 0.99])
def test_homogeneous_and_scaled_depths(k, y0):
    """(47), (50) depend on y0 through a alone."""
    state, other = contact_of(k, y0=y0).partial_slip(MU, 1e-4), contact_of(k).partial_slip(MU, 1e-4)
    x = np.linspace(0, 1, 11)
    np.testing.assert_allclose(state.traction(x * state.a) * state.a, other.traction(x * other.a) * other.a, rtol=1e-13)
    slip, expected = state.slip(x * state.a) / state.a**2, other.slip(x * other.a) / other.a**2
    np.testing.assert_allclose(slip, expected, rtol=1e-13, atol=1e-14 * expected.max())


def test_homogeneous_forms():
    """(53), (54), (58) at k = 0 and their approach for k -> 0."""
    nu, E0 = 0.3, 2.0
    for k in (0.0, 1e-12, -1e-12, 1e-8, -1e-8):
        state = contact_of(k, nu).partial_slip(MU, 0.3 * MU * P)
        a0, c = contact_of(0.0, nu).a0, contact_of(0.0, nu).a0 * np.sqrt(0.7)
        x = c + (a0 - c) * np.linspace(0.05, 0.95, 7)
        rtol = 1e-12 + 1000 * abs(k)
        assert state.c == pytest.approx(c, rel=rtol)
        q = MU * E0 / (2 * (1 - nu**2) * R) * np.sqrt((a0 - x) * (a0 + x))
        np.testing.assert_allclose(state.traction(x), q, rtol=rtol)
        h = MU / (2 * R) * (x * np.sqrt((x - c) * (x + c)) - c**2 * np.arccosh(x / c))
        np.testing.assert_allclose(state.slip(x), h, rtol=1e-10 + 1000 * abs(k))  # (54) itself cancels near c


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mu": 0.0, "Q": 0.0}, r"mu = 0.0 .* 0.0 < mu"),
        ({"mu": MU, "Q": MU * P}, r"Q = 0.0003 .* \|Q\| < mu P = 0.0003"),
        ({"mu": MU, "Q": -1.0}, r"Q = -1.0 .* \|Q\| < mu P"),
        ({"mu": MU, "Q": float("nan")}, r"Q = nan"),
        ({"mu": MU, "z": 0.0}, r"z = 0.0 .* 0 < z <= 1"),
        ({"mu": MU, "z": 1.5}, r"z = 1.5 .* 0 < z <= 1"),
        ({"mu": MU}, "exactly one"),
        ({"mu": MU, "Q": 0.0, "z": 1.0}, "exactly one"),
    ],
)
def test_inadmissible_load(arguments, message):
    """Every refusal names the value and the range."""
    with pytest.raises(ValueError, match=message):
        contact_of(0.2).partial_slip(**arguments)


@settings(max_examples=100)
@given(
    st.one_of(st.floats(-0.99, 0.99), st.sampled_from(EXPONENTS)),
    st.floats(-0.9, 0.5),
    st.floats(1e-9, 1 - 1e-9),
    st.floats(1e-9, 1 - 1e-9),
    st.lists(st.floats(0, 1), min_size=6, max_size=6),
)
def test_properties(k, nu, load, other_load, ratios):
    """(25), (26), (34): friction law, monotone c, symmetry under Q -> -Q, array shapes."""
    contact = contact_of(k, nu)
    Q = load * MU * P
    state, mirrored = contact.partial_slip(MU, Q), contact.partial_slip(MU, -Q)
    x = contact.a * np.array(ratios).reshape(2, 3)
    q, p, h = state.traction(x), contact.pressure(x), state.slip(x)
    assert q.shape == h.shape == (2, 3)
    assert np.all((q >= 0) & (q <= MU * p)) and np.all(h >= 0)
    slips = x > state.c * (1 + 4 * EPS)
    np.testing.assert_allclose(q[slips], MU * p[slips], rtol=1e-15)
    assert np.all(h[x < state.c * (1 - 4 * EPS)] == 0)
    np.testing.assert_array_equal(mirrored.traction(x), -q)
    np.testing.assert_array_equal(mirrored.slip(x), -h)
    np.testing.assert_array_equal(mirrored.traction_within(x), -state.traction_within(x))
    assert mirrored.Q == -state.Q == pytest.approx(-Q, rel=1e-15)
    assert 0 < state.c < contact.a
    larger = contact.partial_slip(MU, other_load * MU * P)
    assert (larger.c <= state.c) == (other_load >= load) or larger.c == pytest.approx(state.c, rel=4 * EPS)
    # facet by facet, the integral of q is between the extremes of q
    inner = np.sort(x.ravel())
    parts = np.diff(state.traction_within(inner)) / 2
    assert np.all(parts >= -4 * EPS * Q)
    assert parts.sum() * 2 <= Q * (1 + 1e-14)


def test_limits_of_the_stick_zone():
    """c -> a for Q -> 0; c -> 0 for Q -> mu P, where slip becomes mu alpha f and traction mu p."""
    for k in (-0.9, 0.0, 0.9):
        contact = contact_of(k)
        x = contact.a * np.linspace(0.1, 0.9, 5)
        resting = contact.partial_slip(MU, 0.0)
        assert resting.c == contact.a
        np.testing.assert_array_equal(resting.traction(x), 0)
        np.testing.assert_array_equal(resting.slip(x), 0)
        sliding = contact.partial_slip(MU, z=1e-300)
        assert sliding.c < 1e-99 * contact.a
        np.testing.assert_allclose(sliding.traction(x), MU * contact.pressure(x), rtol=1e-15)
        np.testing.assert_allclose(sliding.slip(x), MU * contact.solid.alpha * contact.profile.height(x), rtol=1e-12)
