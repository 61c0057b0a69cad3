"""The pressed cylinder (41)-(46), (57), [X1], [X2] against (5)-(8), (10), (11), kernel (2)."""

import math
from functools import lru_cache

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import EPS, EXPONENTS, SELECTED, Cylinder, kernel_displacement, load_within, relative_error
from hypothesis import given, settings
from hypothesis import strategies as st

from analytic import CylinderContact, GradedHalfPlane, GradedPair, UndefinedDisplacementError

RTOL = 1e-12


@lru_cache
def case(k, nu=0.3, y0=0.2):
    """Contact and its reference; fields are compared at exactly the same x and a."""
    E0, R, P = 2.0, 3.0, 1e-3
    reference = Cylinder(E0, nu, k, y0, R, P)
    return CylinderContact(GradedHalfPlane(E0, nu, k, y0), R, P), reference


def test_the_smallest_k_is_none():
    """Products with it would lose their digits."""
    tiny, none = (case(k)[0] for k in (5e-324, 0.0))
    assert tiny.relative_displacement(2 * none.a) == none.relative_displacement(2 * none.a)


@pytest.mark.parametrize("k", EXPONENTS)
@pytest.mark.parametrize(("nu", "y0"), [(-0.9, 1e-6), (0.0, 1.0), (0.3, 0.2), (0.5, 1e6)])
def test_half_width(k, nu, y0):
    """(43), [X1] against (5), (6)."""
    contact, reference = case(k, nu, y0)
    assert relative_error(contact.a, reference.a) < 1e-14
    assert relative_error(contact.density(0.7), reference.n(mp.mpf(0.7))) < 1e-14
    # [X1], which takes a from a0
    K, a0 = mp.mpf(k), mp.sqrt(4 * (1 - mp.mpf(nu) ** 2) * mp.mpf(1e-3) * 3 / (mp.pi * 2))
    assert relative_error(contact.a0, a0) < 1e-14
    bk = reference.b * reference.k
    x1 = mp.sqrt(mp.pi) / 2 * bk / (1 - mp.mpf(nu) ** 2) * mp.gamma((4 + K) / 2) * mp.gamma((1 - K) / 2)
    assert relative_error(contact.a, a0 * (x1 * (y0 / a0) ** K) ** (1 / (2 + K))) < 1e-14


def test_homogeneous_half_width():
    """(57): k = 0 is Hertz, whatever y0."""
    for y0 in (1e-6, 1e6):
        contact = CylinderContact(GradedHalfPlane(2.0, 0.3, 0.0, y0), 3.0, 1e-3)
        assert contact.a == pytest.approx(contact.a0, rel=1e-15)
        assert math.pi * 2.0 * contact.a0**2 / (4 * (1 - 0.3**2) * 3.0) == pytest.approx(1e-3, rel=1e-15, abs=0)


@pytest.mark.parametrize("k", SELECTED)
def test_pressure(k):
    """(44) against (7), and its integral against (7) once more, up to the edge."""
    contact, reference = case(k)
    a = mp.mpf(contact.a)
    load = reference.load(reference.n, a)  # differs from P by the rounding of a
    for x in [0.0, 1e-12, 0.3, 0.9, 0.999, 1 - 1e-9, 1 - 1e-15]:
        x = x * contact.a
        exact = reference.pressure(reference.n, mp.mpf(x), a) / load * mp.mpf(1e-3)
        assert relative_error(contact.pressure(x), exact) < RTOL
        assert contact.pressure(-x) == contact.pressure(x)
    np.testing.assert_array_equal(contact.pressure(contact.a * np.array([-1, 1, 1 + EPS, 2, 1e9])), 0)
    power = (1 + mp.mpf(k)) / 2
    for x in [1e-200, 1e-12, 0.3, 0.7, 0.9, 1 - 1e-9]:
        x = x * contact.a
        exact = mp.mpf(1e-3) * load_within(mp.mpf(x), a, power) / load_within(a, a, power)
        assert relative_error(contact.pressure_within(x), exact) < RTOL
        assert contact.pressure_within(-x) == -contact.pressure_within(x)
    assert contact.pressure_within(contact.a) == contact.P == -contact.pressure_within(-3 * contact.a)
    assert contact.pressure_within(0) == 0


@pytest.mark.parametrize("k", SELECTED)
def test_relative_displacement(k):
    """(45), [X2] against (8) and against kernel (2) under the pressure; inside it is (41)."""
    contact, reference = case(k)
    a = mp.mpf(contact.a)
    for x in [0.2, 1 + 1e-9, 1.5, 1e6]:
        x = x * contact.a
        exact = reference.relative_displacement(reference.n, mp.mpf(x), a)
        assert relative_error(contact.relative_displacement(x), exact) < RTOL
        assert contact.relative_displacement(-x) == contact.relative_displacement(x)
        if x > contact.a:
            # the part of (8) that is missing between a and x
            gap = reference.relative_displacement(reference.n, mp.mpf(x), mp.mpf(x), start=a)
            assert relative_error(contact.gap(x), gap) < RTOL
    assert contact.gap(contact.a) == 0
    for x in [0.4, 2.5]:
        x = mp.mpf(x * contact.a)
        power = (1 + reference.k) / 2
        peak = contact.peak_pressure
        exact = kernel_displacement(
            reference.k,
            mp.mpf(contact.solid.normal_compliance),
            lambda u, d: peak * (d * (a + u) / a**2) ** power,  # noqa: B023
            x,
            a,
            power,
        )
        assert relative_error(contact.relative_displacement(float(x)), exact) < RTOL


@pytest.mark.parametrize("k", [k for k in EXPONENTS if k > 0])
def test_displacement(k):
    """(46) against (11), and u_y against (10)."""
    contact, reference = case(k)
    a = mp.mpf(contact.a)
    assert relative_error(contact.indentation, reference.displacement(reference.n, mp.mpf(0), a)) < RTOL
    for x in [0.5, 1.0, 1.0001, 2.0, 1e3, 1e9]:
        x = x * contact.a
        assert relative_error(contact.displacement(x), reference.displacement(reference.n, mp.mpf(x), a)) < RTOL


@pytest.mark.parametrize("k", [k for k in EXPONENTS if k <= 0])
def test_undefined_displacement(k):
    """delta_y and u_y do not exist for k <= 0."""
    contact, _ = case(k)
    with pytest.raises(UndefinedDisplacementError, match=r"indentation delta_y does not exist .* without bound"):
        _ = contact.indentation
    with pytest.raises(UndefinedDisplacementError, match="does not exist"):
        contact.displacement(0.0)


def test_pair_of_equal_bodies():
    """(2): two equal bodies are one of twice the compliance."""
    solid = GradedHalfPlane(2.0, 0.3, -0.4, 0.2)
    pair = CylinderContact(GradedPair(solid, solid), 3.0, 1e-3)
    single = CylinderContact(GradedHalfPlane(1.0, 0.3, -0.4, 0.2), 3.0, 1e-3)
    assert pair.a == pytest.approx(single.a, rel=1e-15)
    assert pair.a0 == pytest.approx(single.a0, rel=1e-15)
    assert pair.partial_slip(0.5, 1e-4).slip(pair.a) == pytest.approx(
        single.partial_slip(0.5, 1e-4).slip(pair.a), rel=1e-14
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [({"P": 0.0}, "P = 0.0"), ({"P": -1.0}, "P = -1.0"), ({"R": 0.0}, "R = 0.0")],
)
def test_inadmissible_contact(change, message):
    """Every refusal names the value and the range."""
    with pytest.raises(ValueError, match=message + r" .*outside the admissible range 0.0 <"):
        CylinderContact(GradedHalfPlane(1.0, 0.3, 0.2, 1.0), **({"R": 1.0, "P": 1.0} | change))


media = st.builds(
    GradedHalfPlane,
    E0=st.floats(1e-3, 1e12),
    nu=st.floats(-0.9, 0.5),
    k=st.one_of(st.floats(-0.99, 0.99), st.sampled_from(EXPONENTS)),
    y0=st.floats(1e-6, 1e6),
)


@settings(max_examples=60)
@given(
    media,
    st.floats(1e-3, 1e3),
    st.floats(1e-6, 1e3),
    st.lists(st.floats(0, 1.5), min_size=4, max_size=4),
)
def test_properties(solid, R, P, ratios):
    """Equilibrium, bounds and symmetry of random contacts, without a warning."""
    contact = CylinderContact(solid, R, P)
    x = contact.a * np.array(ratios).reshape(2, 2)
    p = contact.pressure(x)
    assert p.shape == (2, 2)
    np.testing.assert_array_equal(contact.pressure(-x), p)
    assert np.all((p >= 0) & (p <= contact.peak_pressure))
    # equilibrium: mean pressures of facets, Gauss-Jacobi in x/a
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # x = a sin(theta) leaves cos^(2+k), of which 200 nodes give 6 digits at k = -0.99
    theta = (nodes + 1) * math.pi / 4
    total = 2 * contact.a * math.pi / 4 * weights @ (contact.pressure(contact.a * np.sin(theta)) * np.cos(theta))
    assert total == pytest.approx(P, rel=1e-5)
    assert contact.pressure_within(2 * contact.a) == P
    # the deformed surface does not pass through the cylinder
    assert np.all(contact.gap(x) >= 0)
    np.testing.assert_allclose(contact.gap(x) + contact.relative_displacement(x), contact.profile.height(x), rtol=1e-14)
    # scaling of (43)
    heavier = CylinderContact(solid, R, 2 * P)
    assert (heavier.a / contact.a) ** (2 + solid.k) == pytest.approx(2, rel=1e-12)
