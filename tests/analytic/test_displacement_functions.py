"""Displacement functions of flat and parabolic punches over the whole range of k and distance."""

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import EXPONENTS, integrate, nonzero, relative_error

from analytic import special

RATIOS = [
    1e-9,
    1e-5,
    1e-3,
    0.1,
    0.5,
    0.7,
    0.7071,
    0.7072,
    0.9,
    0.999,
    1 - 1e-6,
    1 - 1e-9,
    1 - 1e-13,
]  # s/x
MORE_EXPONENTS = [*EXPONENTS, -0.26, -0.25, 0.25, 0.26]


def printed(k, s):
    """1/k times the two terms of the bracket of (8)."""
    constant = mp.gamma((2 + k) / 2) * mp.gamma((1 - k) / 2) / mp.sqrt(mp.pi)
    return constant / k, s**k * mp.hyp2f1(k / 2, (1 + k) / 2, (2 + k) / 2, s**2) / k


@pytest.mark.parametrize("k", MORE_EXPONENTS)
@pytest.mark.parametrize("s", RATIOS)
def test_flat_punch(k, s):
    """Brackets of (8), (10), (13), (14) over k."""
    rigid, decaying = printed(nonzero(k), mp.mpf(s))
    assert relative_error(special.punch_relative_displacement(1.0, s, k), rigid - decaying) < 1e-13
    if k > 0:
        assert relative_error(special.punch_displacement(1.0, s, k), decaying) < 1e-13
        assert relative_error(special.punch_rigid_displacement(k), rigid) < 1e-14


@pytest.mark.parametrize("distance_from_1", [2.0**-12, 2.0**-40])
@pytest.mark.parametrize("s", [0.7, 0.9, 1 - 1e-9, 1 - 1e-13])
def test_flat_punch_towards_k_1(distance_from_1, s):
    """There the rigid displacement grows without bound, and that of the surface beside the punch does not."""
    _, decaying = printed(1 - mp.mpf(distance_from_1), mp.mpf(s))
    assert relative_error(special.punch_displacement(1.0, s, 1 - distance_from_1), decaying) < 1e-13


@pytest.mark.parametrize("k", MORE_EXPONENTS)
@pytest.mark.parametrize("s", RATIOS)
def test_parabolic_contact(k, s):
    """[X2] against the printed (45): h_y = x²/(2R) (1 - Phi)."""
    K, S = nonzero(k), mp.mpf(s)
    term = mp.sqrt(mp.pi) / (mp.gamma((4 + K) / 2) * mp.gamma((1 - K) / 2))
    decaying = S ** (2 + K) * term / K * mp.hyp2f1(K / 2, (1 + K) / 2, (4 + K) / 2, S**2)
    relative = S**2 / K - decaying
    assert relative_error(special.parabolic_relative_displacement(1.0, s, k), relative) < 1e-13
    assert relative_error(special.parabolic_gap(1.0, s, k), 1 - relative) < 1e-13
    if k > 0:
        assert relative_error(special.parabolic_displacement(1.0, s, k), decaying) < 1e-13


@pytest.mark.parametrize("k", EXPONENTS)
@pytest.mark.parametrize("s", [1e-9, 0.01, 0.6, 0.999])
def test_printed_forms_of_the_parabolic_gap(k, s):
    """[X2], [X3]: hypergeometric form, and Phi from its slope, d(x² Phi)/dx = 2 x I_y."""
    K, S = nonzero(k), mp.mpf(s)
    y = 1 - S**2
    scale = mp.sqrt(mp.pi) / (2 * mp.gamma((5 - K) / 2) * mp.gamma(1 + K / 2))
    phi = scale * y ** ((3 - K) / 2) * mp.hyp2f1((1 - K) / 2, (2 - K) / 2, (5 - K) / 2, y)
    assert relative_error(special.parabolic_gap(1.0, s, k), phi) < 1e-13
    p, q = (1 - K) / 2, 1 + K / 2
    slope = integrate(lambda u, d: u ** (p - 1) * (1 - u) ** (q - 1), y, left=p - 1) / mp.beta(p, q)
    assert relative_error(special.parabolic_gap_slope(1.0, s, k), slope) < 1e-13

    def gap(x):
        y = 1 - S**2 / x**2
        return x**2 * scale * y ** ((3 - K) / 2) * mp.hyp2f1((1 - K) / 2, (2 - K) / 2, (5 - K) / 2, y)

    with mp.workdps(60):
        assert relative_error(special.parabolic_gap_slope(1.0, s, k), mp.diff(gap, 1, h=mp.mpf(10) ** -25) / 2) < 1e-13


@pytest.mark.parametrize("k", EXPONENTS)
def test_ends_of_the_range(k):
    """Under the punch, at its edge and infinitely far away; scalars and arrays of any shape."""
    x = np.array([[0.0, 0.5], [1.0, 2.0]])
    assert special.punch_relative_displacement(x, 1.0, k).shape == (2, 2)
    np.testing.assert_array_equal(special.punch_relative_displacement(x, 1.0, k) > 0, x > 1)
    np.testing.assert_array_equal(special.parabolic_gap(x, 1.0, k) > 0, x > 1)
    np.testing.assert_array_equal(special.parabolic_relative_displacement(x, 1.0, k) < 1, x > 1)
    assert special.parabolic_gap(1.0, 0.0, k) == 1 and special.parabolic_gap(0.0, 0.0, k) == 0
    assert special.parabolic_relative_displacement(1.0, 0.0, k) == 0
    assert np.isinf(special.punch_relative_displacement(1.0, 0.0, k)) == (k <= 0)
    assert np.ndim(special.parabolic_gap(2.0, 1.0, k)) == 0


@pytest.mark.parametrize("k", EXPONENTS)
def test_known_distance_is_used(k):
    """x - s smaller than the rounding error of x: the leading power of y survives."""
    near, nearer = (special.parabolic_gap(1.0, 1.0, k, d) for d in (1e-20, 1e-22))
    assert np.log(near / nearer) / np.log(100) == pytest.approx((3 - k) / 2, rel=1e-13)
