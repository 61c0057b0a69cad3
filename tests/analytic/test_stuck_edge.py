"""The open surface ahead of a stuck edge, against integrals of the kernels."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

from analytic import GradedHalfPlane
from analytic.stuck_edge import StuckEdge


def half_plane(k, nu) -> GradedHalfPlane:
    return GradedHalfPlane(E0=1.0, nu=nu, k=k, y0=1.0)


@pytest.mark.parametrize("nu", [-0.4, 0.0, 0.3, 0.5])
def test_a_homogeneous_half_plane_has_the_known_oscillation(nu):
    assert StuckEdge(half_plane(0.0, nu)).oscillation == pytest.approx(np.log(3 - 4 * nu) / (2 * np.pi), abs=1e-15)


def test_nothing_oscillates_at_the_holl_ratio():
    edge = StuckEdge(half_plane(0.3, GradedHalfPlane.holl_ratio(0.3)))
    assert edge.oscillation == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("k, nu", [(0.534, -0.19), (-0.5, 0.0), (0.3, 0.3), (0.2, 0.49), (-0.8, 0.3)])
@mp.workdps(30)
def test_singular_tractions_move_nothing_in_contact(k, nu):
    """p, q = (A, B) t^-l on t > 0, l complex: u_x = u_y = 0 there; ahead, at t < 0, u_x = i sqrt(alpha) u_y."""
    solid = half_plane(k, nu)
    b, g, d = solid.b, solid.g, solid.d
    power = mp.mpc((1 - k) / 2, StuckEdge(solid).oscillation)
    inside = mp.beta(1 - power, 1 - k)  # integral of t^-l (1-t)^-k from 0 to 1
    beyond = mp.beta(power + k - 1, 1 - k)  # of t^-l (t-1)^-k from 1 on
    even, odd = inside + beyond, inside - beyond
    vanishing, part = b * g * even**2 + (d * odd) ** 2, (d * odd) ** 2
    assert abs(vanishing) < 1e-12 * abs(part)
    A, B = 1, b * even / (d * odd)
    u_y, u_x = b * A + d * B, g * B - d * A  # at t < 0, over one integral
    assert complex(u_x / u_y) == pytest.approx(1j * np.sqrt(solid.alpha), rel=1e-12)


@pytest.mark.parametrize("k, nu", [(0.534, -0.19), (-0.5, 0.0)])
def test_the_angle_is_that_of_the_integral_of_the_rates(k, nu):
    edge, advance, wide = StuckEdge(half_plane(k, nu)), 0.3, 1e9
    power = (1 - k) / 2 + 1j * edge.oscillation

    def moved(distance):
        end = min(distance, advance)
        parts = (quad(lambda t: part((distance - t) ** power), 0, end, epsabs=1e-12)[0] for part in (np.real, np.imag))
        return complex(*parts)

    for distance in (0.02, 0.2, 0.31, 0.5, 2.0):
        expected = np.angle(moved(distance) / moved(advance))
        assert edge.angle([distance], advance, wide) == pytest.approx(expected, abs=1e-6)
        expected -= edge.oscillation * np.log((distance + 2.0) / (advance + 2.0))  # to the other edge, 2 away
        assert edge.angle([distance], advance, 2.0) == pytest.approx(expected, abs=1e-6)


def test_where_a_contact_grows_from_a_point_all_points_touch_alike():
    edge = StuckEdge(half_plane(0.0, 0.0))
    assert edge.angle(np.array([0.01, 0.1, 0.3]), 0.3, 0.0) == pytest.approx(0.0, abs=1e-14)


def test_turned_and_back():
    edge = StuckEdge(half_plane(0.3, 0.0))
    assert edge.turned(edge.turned(-0.7, 0.2), -0.2) == pytest.approx(-0.7)
    assert edge.turned(0.0, 0.2) == pytest.approx(np.sqrt(1.3) * np.tan(0.2))  # alpha = 1 + k
    assert 5 < edge.turned(1.0, 1.0) < 10  # beyond a right angle it would change its sign


def test_points_that_touch_once_the_edge_has_come_to_them_differ_by_their_distances_from_the_other_edge():
    edge = StuckEdge(half_plane(-0.5, 0.0))
    near, far = edge.touching(np.array([0.1, 0.5]), 2.0)
    assert far - near == pytest.approx(edge.oscillation * np.log((2.1 / 0.1) / (2.5 / 0.5)))
