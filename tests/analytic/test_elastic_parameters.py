"""Elastic parameters (1), (3), (4), (37) against the exact radial stress field; sums in (2)."""

import math

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import EXPONENTS, integrate, nonzero, relative_error

from analytic import GradedHalfPlane, GradedPair

POISSON = [-0.9, -0.3, 0.0, 0.3, 0.5]


def radial_field(k, nu):
    """(bk, gk, beta) from the field u_r = r^-k U(theta) of a line force, theta from the depth axis.

    The strains of u_r, u_theta = r^-k U'/(1+k) give a radial stress -k E(y) U r^(-1-k)/(1-nu²) if
    U'' = -beta² U. A normal force has U = cos(beta theta), a tangential one U = sin(beta theta);
    their resultants fix the scale.
    """
    k, nu = nonzero(k), mp.mpf(nu)
    beta = mp.sqrt((1 + k) * (1 - k * nu / (1 - nu)))

    def half_plane(f, power):
        """2 ∫_0^{pi/2} f(theta) cos(theta)^power dtheta."""
        return 2 * integrate(lambda u, d: f(u) * mp.sin(d) ** power, mp.pi / 2, right=power)

    normal = half_plane(lambda t: mp.cos(beta * t), 1 + k)
    tangential = half_plane(lambda t: mp.sin(beta * t) * mp.sin(t), k)
    sine = mp.sin(beta * mp.pi / 2)
    return (
        (1 - nu**2) * beta * sine / (1 + k) / normal,
        (1 - nu**2) * sine / tangential,
        beta,
        1 / normal,
    )


@pytest.mark.parametrize("k", EXPONENTS)
@pytest.mark.parametrize("nu", POISSON)
def test_parameters_against_force_balance(k, nu):
    """(3), (4), (37)."""
    bk, gk, beta, C = radial_field(k, nu)
    solid = GradedHalfPlane(E0=2.0, nu=nu, k=k, y0=3.0)
    assert relative_error(solid.beta, beta) < 1e-14
    assert relative_error(solid.C, C) < 1e-14
    assert relative_error(solid.bk, bk) < 1e-14
    assert relative_error(solid.gk, gk) < 1e-14
    assert relative_error(solid.alpha, gk / bk) < 1e-14
    assert relative_error(solid.normal_compliance, bk * mp.mpf(3) ** mp.mpf(k) / 2) < 1e-14
    assert relative_error(solid.tangential_compliance, gk * mp.mpf(3) ** mp.mpf(k) / 2) < 1e-14
    if k:
        assert solid.b * k == pytest.approx(solid.bk, rel=1e-15)
        assert solid.g * k == pytest.approx(solid.gk, rel=1e-15)


@pytest.mark.parametrize("nu", POISSON)
def test_homogeneous_parameters(nu):
    """(3), (37) for k = 0, where b and g alone do not exist."""
    solid = GradedHalfPlane(1.0, nu, 0.0, 1.0)
    assert solid.bk == pytest.approx(2 * (1 - nu**2) / math.pi, rel=1e-15)
    assert solid.gk == pytest.approx(solid.bk, rel=1e-15)
    assert solid.alpha == 1
    for name in ("b", "g"):
        with pytest.raises(ValueError, match="k = 0"):
            getattr(solid, name)


@pytest.mark.parametrize("k", [k for k in EXPONENTS if k >= 0])
def test_holl_ratio(k):
    """(4), (37) at nu = 1/(2+k)."""
    solid = GradedHalfPlane(1.0, GradedHalfPlane.holl_ratio(k), k, 1.0)
    assert solid.beta == pytest.approx(1, rel=1e-15)
    assert solid.alpha == pytest.approx((1 + k) ** 2, rel=1e-14)


def test_modulus():
    """(1)."""
    solid = GradedHalfPlane(E0=5.0, nu=0.2, k=-0.5, y0=4.0)
    np.testing.assert_allclose(solid.modulus([[1.0, 4.0], [16.0, 64.0]]), [[10, 5], [2.5, 1.25]], rtol=1e-15)
    assert solid.modulus(0) == math.inf
    assert GradedHalfPlane(5.0, 0.2, 0.5, 4.0).modulus(0) == 0
    with pytest.raises(ValueError, match="outside the body"):
        solid.modulus([1, -1])


@pytest.mark.parametrize("k", [-0.7, 0.0, 0.4])
def test_two_bodies(k):
    """(2), (37): the compliances of two bodies add."""
    soft, stiff = GradedHalfPlane(1.0, 0.5, k, 0.3), GradedHalfPlane(7.0, 0.1, k, 2.0)
    pair = GradedPair(soft, stiff)
    (b1, g1), (b2, g2) = (radial_field(k, s.nu)[:2] for s in (soft, stiff))
    y1, y2 = mp.mpf(0.3) ** mp.mpf(k), mp.mpf(2) ** mp.mpf(k) / 7
    assert relative_error(pair.normal_compliance, b1 * y1 + b2 * y2) < 1e-14
    assert relative_error(pair.tangential_compliance, g1 * y1 + g2 * y2) < 1e-14
    assert relative_error(pair.alpha, (g1 * y1 + g2 * y2) / (b1 * y1 + b2 * y2)) < 1e-14
    assert GradedPair(soft, soft).alpha == pytest.approx(soft.alpha, rel=1e-15)
    assert pair.homogeneous_compliance == pytest.approx(0.75 + 0.99 / 7, rel=1e-15)
    with pytest.raises(ValueError, match="same exponent"):
        GradedPair(soft, GradedHalfPlane(7.0, 0.1, k + 1e-9, 2.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"k": 1.0}, r"k = 1.0 .* -1 < k < 1"),
        ({"k": -1.0}, r"k = -1.0 .* -1 < k < 1"),
        ({"k": math.nan}, r"k = nan .* -1 < k < 1"),
        ({"nu": -1.0}, r"nu = -1.0 .* -1 < nu <= 0.5"),
        ({"nu": 0.51}, r"nu = 0.51 .* -1 < nu <= 0.5"),
        ({"E0": 0.0}, r"E0 = 0.0 .* 0.0 < E0"),
        ({"E0": math.inf}, r"E0 = inf"),
        ({"y0": -1.0}, r"y0 = -1.0 .* 0.0 < y0"),
    ],
)
def test_inadmissible_medium(change, message):
    """Every refusal names the value and the range."""
    with pytest.raises(ValueError, match=message):
        GradedHalfPlane(**({"E0": 1.0, "nu": 0.3, "k": 0.2, "y0": 1.0} | change))
    if "k" in change:
        with pytest.raises(ValueError, match=message):
            GradedHalfPlane.holl_ratio(change["k"])
