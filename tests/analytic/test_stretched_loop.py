"""Fretting with bulk strain, [X7], against the kernel (2), the friction law, and quadrature with mpmath."""

import mpmath as mp
import numpy as np
import pytest
from defining_integrals import integrate, kernel_displacement, nonzero, relative_error
from hypothesis import example, given, settings
from hypothesis import strategies as st

from analytic import CylinderContact, GradedHalfPlane, GradedPair, PowerProfile, ProfileContact, StretchedLoop

MU, P, R, NU = 0.3, 1e-3, 3.0, 0.3
RTOL = 1e-12


def loop_of(k, load=0.8, share=0.7, nu=NU):
    """Amplitude load mu P, strain a share of the largest."""
    loop = CylinderContact(GradedHalfPlane(2.0, nu, k, 0.2), R, P).fretting(MU, load * MU * P)
    return StretchedLoop(loop, share * StretchedLoop(loop, 0.0).largest_strain)


class Exact:
    """mu p(x, s) with the contact's own peak and width, and what it does to the surface by (2)."""

    def __init__(self, stretched):
        contact = stretched.loop.contact
        self.K, self.a = nonzero(contact.solid.k), mp.mpf(contact.a)
        self.power, self.peak = (1 + self.K) / 2, mp.mpf(MU) * mp.mpf(contact.peak_pressure)
        self.compliance = mp.mpf(contact.solid.tangential_compliance)
        self.alpha, self.strain = mp.mpf(contact.solid.alpha), mp.mpf(stretched.strain)

    def half_width(self, load_share):
        """(48)."""
        return self.a * (1 - load_share) ** (1 / (2 + self.K))

    def pressure(self, s, x):
        return self.peak * ((s - x) * (s + x) / self.a**2) ** self.power if abs(x) < s else mp.mpf(0)

    def falls(self, s, x):
        """u_x(0) - u_x(x) of mu p(x, s)."""
        edge = self.power
        if x == 0:
            return mp.mpf(0)
        return kernel_displacement(
            self.K, self.compliance, lambda u, d: self.peak * (d * (s + u) / self.a**2) ** edge, abs(x), s, edge
        )


@pytest.mark.parametrize("k", [-0.3, 0.6])
def test_strained_traction_and_slip_against_kernel(k):
    """What q does by (2), and the strain: nothing moves in the moved stick zone, slip h_x(x - e) beyond."""
    stretched = loop_of(k)
    exact, load = Exact(stretched), mp.mpf(0.8)
    c, e = exact.half_width(load), exact.strain * R / (mp.mpf(MU) * exact.alpha)
    assert relative_error(stretched.c, c) < RTOL and relative_error(stretched.shift, e) < RTOL
    a, Q_A = stretched.loop.a, stretched.loop.Q_A
    for x in (float(e - 0.6 * c), float(0.4 * (e + c) + 0.6 * a)):
        X = mp.mpf(x)
        q = exact.pressure(exact.a, X) - exact.pressure(c, X - e)
        assert relative_error(stretched.traction(x, Q_A, "initial"), q) < RTOL
        relative = [exact.falls(exact.a, y) - exact.falls(c, y - e) - exact.strain * y for y in (X, e)]
        moved = relative[0] - relative[1]
        assert abs(stretched.slip(x, Q_A, "initial") - moved) < RTOL * stretched.amplitude.slip(-a)
        if abs(X - e) < c:
            assert stretched.slip(x, Q_A, "initial") == 0


@pytest.mark.parametrize("k, share", [(-0.9, 0.6), (0.5, -0.3)])
def test_strained_unloading_against_kernel(k, share):
    """The zone of [X5] moves with half the strain taken back: frozen inside, q = -mu p beyond."""
    stretched = loop_of(k)
    exact, load, Q = Exact(stretched), mp.mpf(0.8), share * stretched.loop.Q_A
    c, e = exact.half_width(load), exact.strain * R / (mp.mpf(MU) * exact.alpha)
    d, e_d = exact.half_width(load * (1 - mp.mpf(share)) / 2), e * (1 - mp.mpf(share)) / 2
    centre, half_width = stretched.zone(Q, "unloading")
    assert relative_error(centre, e_d) < RTOL and relative_error(half_width, d) < RTOL

    def moved(x):
        """Relative displacement since the start, over that of the middle of the zone of stick."""
        h = [
            2 * exact.falls(d, y - e_d) - exact.falls(exact.a, y) - exact.falls(c, y - e)
            - share * exact.strain * y
            for y in (x, e)
        ]
        return h[0] - h[1]

    for x in (float(e + c + 0.3 * (e_d + d - e - c)), float((e_d + d + exact.a) / 2)):
        X = mp.mpf(x)
        q = 2 * exact.pressure(d, X - e_d) - exact.pressure(exact.a, X) - exact.pressure(c, X - e)
        assert abs(stretched.traction(x, Q, "unloading") - q) < RTOL * exact.peak
        largest = stretched.amplitude.slip(-stretched.loop.a)
        assert abs(stretched.slip(x, Q, "unloading") - moved(X)) < RTOL * largest
        if abs(X - e_d) >= d:
            assert relative_error(stretched.traction(x, Q, "unloading"), -exact.pressure(exact.a, X)) < RTOL


@pytest.mark.parametrize("k", [-0.9, 0.0, 0.5])
@pytest.mark.parametrize("load, share", [(0.3, 1.0), (0.9, 0.5), (0.99, -0.9)])
def test_strained_energy_against_integral(k, load, share):
    """4 ∫ mu p h_x(x - e) dx over both zones of slip, with h_x as it is printed in (50)."""
    stretched = loop_of(k, load, share)
    K, exact = nonzero(k), Exact(stretched)
    c, e = exact.half_width(mp.mpf(load)), exact.strain * R / (mp.mpf(MU) * exact.alpha)
    term = mp.sqrt(mp.pi) / (K * mp.gamma((4 + K) / 2) * mp.gamma((1 - K) / 2))

    def over(side):
        width = max(exact.a - side * e - c, mp.mpf(0))

        def density(u, d):
            x = c + u
            with mp.workdps(85):
                F = mp.hyp2f1(K / 2, (1 + K) / 2, (4 + K) / 2, (c / x) ** 2)
                h = MU * exact.alpha / (2 * R) * (x**2 - c**2 / K + c**2 * term * (c / x) ** K * F)
            return exact.peak * (d * (2 * exact.a - d) / exact.a**2) ** exact.power * h

        return integrate(density, width, right=exact.power) if width else 0

    assert relative_error(stretched.dissipated_energy, 4 * (over(1) + over(-1))) < RTOL


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.4])
def test_without_strain_it_is_the_loop(k):
    """Fields to the last digits, energy and half-widths exactly."""
    stretched = loop_of(k, share=0.0)
    loop, x = stretched.loop, stretched.loop.a * np.linspace(-1.2, 1.2, 41)
    for Q, branch in ((0.5, "initial"), (0.2, "unloading"), (-0.7, "unloading"), (0.4, "reloading")):
        Q *= loop.Q_A
        q, h = loop.traction(x, Q, branch), loop.slip(x, Q, branch)
        np.testing.assert_allclose(stretched.traction(x, Q, branch), q, rtol=1e-12, atol=1e-15 * MU * P / loop.a)
        np.testing.assert_allclose(stretched.slip(x, Q, branch), h, rtol=1e-12, atol=1e-14 * abs(h).max())
        assert stretched.zone(Q, branch) == (0.0, loop.active_half_width(Q, branch))
    assert stretched.dissipated_energy == loop.dissipated_energy
    assert 4 * stretched.amplitude.work == pytest.approx(loop.dissipated_energy, rel=RTOL, abs=0)
    assert loop_of(k, load=0.0, share=0.0).dissipated(0.0, "initial") == 0.0


@settings(max_examples=30)
@given(st.floats(-0.95, 0.95), st.floats(1e-6, 1 - 1e-6), st.floats(-1, 1), st.floats(-1, 1))
@example(5e-324, 0.75, 0.0, 0.0)
def test_strained_properties(k, load, share, Q):
    """Stick within the contact, friction law, slip against q, equilibrium, and a loop that closes."""
    stretched = loop_of(k, load, share)
    loop, a = stretched.loop, stretched.loop.a
    assert abs(stretched.shift) + stretched.c <= a * (1 + 1e-14)
    Q, (v, weight) = Q * loop.Q_A, np.polynomial.legendre.leggauss(60)
    (centre, d), ends = stretched.zone(Q, "unloading"), np.array([-1.0, 1.0])
    ends = np.sort([-a, a, *(centre + d * ends), *(stretched.shift + stretched.c * ends)])
    half = np.diff(ends)[:, None] / 2  # powers at the ends of each piece are smooth in the angle
    x = (ends[:-1, None] + half * (1 + np.sin(np.pi / 2 * v))).ravel()
    weight = (half * np.pi / 2 * np.cos(np.pi / 2 * v) * weight).ravel()
    limit = MU * loop.contact.pressure(x)
    q, full = stretched.traction(x, Q, "unloading"), stretched.traction(x, loop.Q_A, "initial")
    assert np.all(np.abs(q) <= limit * (1 + 1e-12))
    assert np.all(full >= 0) and np.all(stretched.energy_density(x) >= 0)
    assert weight @ q == pytest.approx(Q, abs=1e-6 * MU * P)
    np.testing.assert_array_equal(stretched.traction(x, -Q, "reloading"), -q)
    np.testing.assert_array_equal(stretched.slip(x, -Q, "reloading"), -stretched.slip(x, Q, "unloading"))
    np.testing.assert_allclose(stretched.traction(x, -loop.Q_A, "unloading"), -full, atol=1e-10 * limit.max())
    half, quarter = stretched.dissipated(-loop.Q_A, "unloading"), stretched.dissipated(loop.Q_A, "initial")
    assert [2 * half, 4 * quarter] == pytest.approx([stretched.dissipated_energy] * 2, rel=1e-9, abs=0)
    assert stretched.dissipated_energy >= loop.dissipated_energy * (1 - 1e-12)


def test_two_alike_bodies():
    """Hills and Nowell: e = sigma a/(4 mu p0) for a stress in one of two alike bodies, and the Ghent rig's numbers."""
    body, sigma, mu, thickness = GradedHalfPlane(72.1e9, 0.33, 0.0, 1.0), 100e6, 0.3, 4e-3
    contact = CylinderContact(GradedPair(body, body), 10e-3, 543 / thickness)
    loop = StretchedLoop(contact.fretting(mu, 155 / thickness), sigma * (1 - 0.33**2) / 72.1e9)
    assert loop.shift == pytest.approx(sigma * contact.a / (4 * mu * contact.peak_pressure), rel=1e-14)
    found = [contact.a, contact.peak_pressure, loop.c / contact.a, loop.shift / contact.a]
    assert found == pytest.approx([0.2067e-3, 418.1e6, 0.2202, 0.1993], abs=0, rel=3e-4)


def test_stress_on_a_homogeneous_half_plane():
    """Muskhelishvili's potentials of the elliptic p and q in the body; at the trailing edge what they leave there."""
    stretched = loop_of(0.0, load=0.9)
    state, contact = stretched.amplitude, stretched.loop.contact
    a, c, e, peak = contact.a, stretched.c, stretched.shift, contact.peak_pressure
    bulk = contact.solid.E0 * stretched.strain / (1 - NU**2)
    x, y = np.meshgrid(a * np.linspace(-2.0, 2.1, 42), a * np.array([0.01, 0.1, 1.0]))
    z = x + 1j * y

    def potential(z, s):
        """∫ p(t, s)/(z - t) dt for the half-width s."""
        return np.pi * peak / a * (z - np.sqrt(z - s) * np.sqrt(z + s))

    def slope(z, s):
        return np.pi * peak / a * (1 - z / (np.sqrt(z - s) * np.sqrt(z + s)))

    p, dp = potential(z, a), slope(z, a)
    q, dq = MU * (p - potential(z - e, c)), MU * (dp - slope(z - e, c))
    expected = bulk - 2 / np.pi * (q.real - y / 2 * dq.imag - (p.imag + y * dp.real) / 2)
    assert np.abs(state.stress_xx(x, y) - expected).max() < 1e-5 * np.abs(expected).max()
    edge = 2 * MU * peak * np.sqrt((a + e) ** 2 - c**2) / a  # the strain itself has cancelled
    q = potential(complex(-a), a) - potential(complex(-a - e), c)
    assert bulk - 2 / np.pi * MU * q.real == pytest.approx(edge, rel=1e-12)
    assert contact.solid.E0 / (1 - NU**2) * state.surface_strain(-a) == pytest.approx(edge, rel=1e-12)


def test_stress_at_the_trailing_edge_comes_from_the_strain_of_the_surface():
    """At the Holl ratio, where p does not strain it: E/(1 - nu²) du_x/dx, up to terms like the root of p beside it."""
    k = 0.3
    stretched = loop_of(k, load=0.9, nu=1 / (2 + k))
    state, a, solid = stretched.amplitude, stretched.loop.a, stretched.loop.contact.solid
    y = a * 4e-4 * 0.25 ** np.arange(3)
    strain = state.stress_xx(-a, y, nodes=20000) * (1 - solid.nu**2) / solid.modulus(y)
    ratio = 0.25 ** ((1 - k) / 2)  # by which these fall
    limit = (strain[1:] - ratio * strain[:-1]) / (1 - ratio)
    assert limit[-1] == pytest.approx(state.surface_strain(-a), rel=3e-4)


def test_refusals():
    """Every refusal says what is allowed."""
    loop = loop_of(0.3).loop
    largest = StretchedLoop(loop, 0.0).largest_strain
    for strain in (1.001 * largest, -1.001 * largest):
        with pytest.raises(ValueError, match="one edge of the stick zone does not recede"):
            StretchedLoop(loop, strain)
    assert StretchedLoop(loop, largest * (1 + 4e-16)).strain > largest  # its last digits are not refused
    with pytest.raises(ValueError, match="strain = nan is outside the admissible range"):
        StretchedLoop(loop, float("nan"))
    solid = loop.contact.solid
    other = ProfileContact(solid, PowerProfile(1.0, 4.0), P)
    with pytest.raises(ValueError, match="is for the parabola"):
        StretchedLoop(other.fretting(MU, z=0.5), 0.0)
    with pytest.raises(ValueError, match="is outside the unloading branch"):
        loop_of(0.3).slip(0.0, 2 * loop.Q_A, "unloading")
