"""Tangential loading without friction: (12)-(14), (18)-(24) against kernel (2), Abel integrals."""

import math

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import (
    Medium,
    abel_derivative,
    derivative,
    integrate,
    kernel_displacement,
    nonzero,
    relative_error,
)

from analytic import (
    CylinderContact,
    GradedHalfPlane,
    GradedPair,
    PowerProfile,
    PressingWithFriction,
    Profile,
    ProfileContact,
    UndefinedDisplacementError,
    UniformShift,
    from_displacement,
    from_traction,
    special,
)

RTOL = 1e-12
SOME = [-0.9, 0.0, 1e-8, 0.5]


def solid_of(k):
    return GradedHalfPlane(2.0, 0.3, k, 0.2)


@pytest.mark.parametrize("k", [*SOME, 0.99])
def test_uniform_shift(k):
    """(12)-(14): kernel (2) under (12) gives no relative displacement inside, (14) outside."""
    shift, K = UniformShift(solid_of(k), a=0.7, Q=3.0), nonzero(k)
    a, power = mp.mpf(0.7), (K - 1) / 2
    peak = mp.gamma((2 + K) / 2) * 3 / (mp.sqrt(mp.pi) * mp.gamma((1 + K) / 2) * a)
    compliance = mp.mpf(shift.solid.tangential_compliance)

    def q(u, d):
        return peak * (d * (a + u) / a**2) ** power

    for x in (0.0, 0.3, 0.7 * (1 - 1e-9)):
        assert relative_error(shift.traction(x), q(mp.mpf(x), a - mp.mpf(x))) < RTOL
    scale = abs(kernel_displacement(K, compliance, q, 2 * a, a, power))
    assert abs(kernel_displacement(K, compliance, q, mp.mpf("0.5"), a, power)) < 1e-14 * scale
    assert shift.relative_displacement(0.5) == 0
    for x in (0.71, 1.0, 50.0):
        h = kernel_displacement(K, compliance, q, mp.mpf(x), a, power)
        assert relative_error(shift.relative_displacement(-x), h) < RTOL
    # the load between -x and x
    for x in (1e-6, 0.3, 0.69):
        part = 2 * integrate(lambda u, d: q(u, a - u), mp.mpf(x))  # noqa: B023
        assert relative_error(shift.traction_within(x), part) < RTOL
    assert shift.traction_within(0.7) == 3.0 == -shift.traction_within(-9.0)
    np.testing.assert_array_equal(shift.traction([0.7, -0.7, 0.8]), [np.inf, np.inf, 0.0])
    if k > 0:
        # (13): u_x(0) by the kernel, u_x(x) = u_x(0) - h_x(x)
        rigid = compliance / K * 2 * integrate(lambda u, d: q(u, d) * u**-K, a, left=-K, right=power)
        assert relative_error(shift.displacement(0.2), rigid) < RTOL
        h = kernel_displacement(K, compliance, q, mp.mpf(5), a, power)
        assert relative_error(shift.displacement(5.0), rigid - h) < RTOL
    else:
        with pytest.raises(UndefinedDisplacementError, match="does not exist"):
            shift.displacement(0.0)


@pytest.mark.parametrize("k", SOME)
def test_prescribed_displacement(k):
    """(18), (20)-(23) for h_x = x²/2 + x⁴: n_x by the literal (23), then its literal integrals."""
    solid = solid_of(k)
    shape = Profile(lambda x: x**2 / 2 + x**4, lambda x: x + 4 * x**3, lambda x: 1 + 12 * x**2)
    fields, K, a = from_displacement(solid, shape, 0.7), nonzero(k), mp.mpf(0.7)
    medium = Medium(2.0, 0.3, k, 0.2)

    def n(s):
        slope = abel_derivative(lambda x: x + 4 * x**3, K, s)
        return medium.density(slope, s, parameter=medium.g)

    for s in (0.05, 0.5):
        assert relative_error(fields.density(np.array(s), None), n(mp.mpf(s))) < RTOL
    # for this polynomial n is n1 s + n3 s³
    n1, n3 = mp.lu_solve(mp.matrix([[1, 1], [2, 8]]), mp.matrix([n(mp.mpf(1)), n(mp.mpf(2))]))

    def density(s):
        return n1 * s + n3 * s**3

    assert relative_error(fields.load, medium.load(density, a)) < RTOL
    for x in (0.0, 0.02, 0.4, 0.69):
        assert relative_error(fields.traction(x), medium.pressure(density, mp.mpf(x), a)) < RTOL
    for x in (0.02, 0.4, 0.7):
        assert fields.relative_displacement(x) == pytest.approx(shape.height(x), rel=RTOL, abs=0)
        assert fields.relative_displacement_gradient(-x) == pytest.approx(-shape.slope(x), rel=1e-11)
    for x in (0.75, 20.0):
        exact = medium.relative_displacement(density, mp.mpf(x), a, parameter=medium.g)
        assert relative_error(fields.relative_displacement(x), exact) < RTOL
    if k > 0:
        for x in (0.0, 0.4, 0.75, 20.0):
            exact = medium.displacement(density, mp.mpf(x), a, parameter=medium.g)
            assert relative_error(fields.displacement(x), exact) < RTOL
        assert fields.rigid_displacement == pytest.approx(fields.displacement(0.0), rel=RTOL)
    else:
        with pytest.raises(UndefinedDisplacementError):
            fields.displacement(0.0)
        with pytest.raises(UndefinedDisplacementError):
            _ = fields.rigid_displacement


@pytest.mark.parametrize("k", [-0.7, 0.0, 0.5])
def test_slip_back_to_traction(k):
    """(23), (29), (31): the slip (50), prescribed, returns n_x = mu n_y outside c, none inside."""
    contact = CylinderContact(solid_of(k), 3.0, 1e-3)
    state = contact.partial_slip(0.5, 3e-4)
    c, scale = state.c, 0.5 * contact.solid.alpha / 3.0
    p, q = (1 - k) / 2, 1 + k / 2
    beta = math.gamma(p) * math.gamma(q) / math.gamma(p + q)

    def curvature(u):
        """Derivative of [X3] at x = c + u."""
        x = c + u
        y = u * (x + c) / x**2
        steep = 2 * c**2 / x**2 * y ** (p - 1) * (1 - y) ** (q - 1) / beta
        return scale * (special.parabolic_gap_slope(x, c, k, u) + steep)

    slip = Profile(
        lambda u: scale / 2 * (c + u) ** 2 * special.parabolic_gap(c + u, c, k, u),
        lambda u: scale * (c + u) * special.parabolic_gap_slope(c + u, c, k, u),
        curvature,
        flat=c,
        order=(3 - k) / 2,
    )
    fields = from_displacement(contact.solid, slip, contact.a)
    s = np.linspace(1.05 * c, contact.a, 5)
    np.testing.assert_allclose(fields.density(s, None), 0.5 * contact.density(s), rtol=RTOL)
    x = contact.a * np.array([0.0, 0.3, 0.95])
    np.testing.assert_allclose(fields.traction(x), state.traction(x), rtol=RTOL)
    assert fields.load == pytest.approx(3e-4, rel=RTOL, abs=0)


@pytest.mark.parametrize("k", SOME)
def test_uniform_traction(k):
    """(24), (20)-(22) for constant q: kernel (2) is elementary."""
    solid, q, a = solid_of(k), 0.8, 0.7
    fields = from_traction(solid, lambda x: np.full_like(x, q), np.zeros_like, a)
    assert fields.load == pytest.approx(2 * q * a, rel=RTOL)
    x = np.array([0.01, 0.3, 0.69, 0.72, 5.0])
    np.testing.assert_allclose(fields.traction(x), np.where(x < a, q, 0), rtol=1e-11)
    np.testing.assert_allclose(fields.traction_within(x), 2 * q * np.minimum(x, a), rtol=1e-11)
    K = nonzero(k)

    def h(x):
        A = mp.mpf(a)
        powers = 2 * A ** (1 - K) - (A + x) ** (1 - K) - mp.sign(A - x) * abs(A - x) ** (1 - K)
        return mp.mpf(solid.tangential_compliance) / K * mp.mpf(q) * powers / (1 - K)

    for xi in x:
        # n_x is singular at a, beside which the rule converges slowly
        tolerance = 1e-11 if abs(xi - a) > 0.05 else 1e-8
        assert relative_error(fields.relative_displacement(xi), h(mp.mpf(xi))) < tolerance
    if k > 0:
        rigid = mp.mpf(solid.tangential_compliance) / K * mp.mpf(q) * 2 * mp.mpf(a) ** (1 - K) / (1 - K)
        assert relative_error(fields.rigid_displacement, rigid) < RTOL
        assert relative_error(fields.displacement(5.0), rigid - h(mp.mpf(5))) < 1e-11


@pytest.mark.parametrize("k", SOME)
@pytest.mark.parametrize("edge", ["contact", 1.0, 0.7])
def test_prescribed_traction(k, edge):
    """(24) for q = (1 - x²/a²)^edge (1 + 2 x²): n_x by the literal (24), and (18) returns q."""
    edge = (1 + k) / 2 if edge == "contact" else edge
    a, K, E = mp.mpf(0.7), nonzero(k), mp.mpf(edge)
    fields = from_traction(solid_of(k), lambda x: 1 + 2 * x**2, lambda x: 4 * x, 0.7, edge=edge)

    def inner(s):
        def f(u, d):
            x = s + u
            return x * (d * (a + x) / a**2) ** E * (1 + 2 * x**2) * (u * (s + x)) ** (-(1 + K) / 2)

        return integrate(f, a - s, left=-(1 + K) / 2, right=E)

    constant = 2 * mp.sqrt(mp.pi) / (mp.gamma((2 + K) / 2) * mp.gamma((1 - K) / 2))
    for s in (0.1, 0.5):
        exact = -constant * derivative(inner, mp.mpf(s), min(1, (0.7 - s) / s))
        assert relative_error(fields.density(np.array(s), np.array(0.7 - s)), exact) < RTOL
    x = np.array([0.0, 1e-3, 0.3, 0.69])
    q = ((0.7 - x) * (0.7 + x) / 0.49) ** edge * (1 + 2 * x**2)
    np.testing.assert_allclose(fields.traction(x), q, rtol=1e-10)
    Q = 2 * integrate(lambda u, d: (d * (a + u) / a**2) ** E * (1 + 2 * u**2), a, right=E)
    assert relative_error(fields.load, Q) < RTOL
    compliance = mp.mpf(solid_of(k).tangential_compliance)
    for x in (0.3, 2.0):
        exact = kernel_displacement(
            K, compliance, lambda u, d: (d * (a + u) / a**2) ** E * (1 + 2 * u**2), mp.mpf(x), a, E
        )
        assert relative_error(fields.relative_displacement(x), exact) < 1e-10


def test_two_bodies_in_tangential_contact():
    """(2): the sum of the tangential compliances enters (14)."""
    first, second = solid_of(0.3), GradedHalfPlane(5.0, 0.1, 0.3, 1.0)
    pair = UniformShift(GradedPair(first, second), 0.7, 3.0).relative_displacement(1.0)
    parts = [UniformShift(solid, 0.7, 3.0).relative_displacement(1.0) for solid in (first, second)]
    assert pair == pytest.approx(sum(parts), rel=1e-14)


def test_fields_where_x_is_not_a_number():
    """nan, which is not taken for a point beyond the contact or in stick; nor is an edge under no load singular."""
    solid = solid_of(0.3)
    cylinder = CylinderContact(solid, 3.0, 1e-3)
    profile = ProfileContact(solid, PowerProfile(0.3, 3.0), 0.7)
    states = [contact.partial_slip(0.5, 0.2 * contact.P) for contact in (cylinder, profile)]
    normal = ["pressure", "pressure_within", "relative_displacement", "displacement"]
    tangential = ["traction", "traction_within", "slip", "slip_gradient"]
    shifted = ["traction", "traction_within", "relative_displacement", "displacement"]
    pressed = PressingWithFriction(solid, profile.profile, 0.5, 1.0, terms=8)
    cases = [(cylinder, [*normal, "gap"]), (profile, normal), *((state, tangential) for state in states)]
    cases += [(UniformShift(solid, 0.7, 3.0), shifted), (pressed, ["pressure", "traction", "slip"])]
    for owner, names in cases:
        for name in names:
            first, second = getattr(owner, name)(np.array([np.nan, 0.1]))
            assert np.isnan(first) and np.isfinite(second), (owner, name)
    np.testing.assert_array_equal(UniformShift(solid, 0.7, 0.0).traction([0.1, 0.7, 0.8, np.inf]), 0)


def test_inadmissible_regions():
    """Every refusal names the value and the range."""
    constant = (np.ones_like, np.zeros_like)
    with pytest.raises(ValueError, match=r"a = 0.0 .* 0.0 < a"):
        UniformShift(solid_of(0.1), 0.0, 1.0)
    with pytest.raises(ValueError, match=r"edge = -0.2 .* 0.0 <= edge"):
        from_traction(solid_of(0.1), *constant, 1.0, edge=-0.2)
    with pytest.raises(ValueError, match=r"a = -1.0 .* 0.0 < a"):
        from_traction(solid_of(0.1), *constant, -1.0)
    with pytest.raises(ValueError, match=r"a = 0.5 .* 0.5 < a"):
        from_displacement(solid_of(0.1), Profile(np.abs, np.abs, np.abs, flat=0.5), 0.5)
