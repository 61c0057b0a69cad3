"""The surface kernel with coupling [X6]: against the point-force field, its limits, and its exact integration."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

from analytic import GradedHalfPlane
from analytic.half_plane.interpolation import Edges, Interpolant, adapted, linear
from analytic.half_plane.operator import SurfaceOperator, element_moments, nodal_integrals
from analytic.half_plane.surface_kernel import PowerLawKernel
from analytic.point_force import point_force_displacement, point_force_stress

EXPONENTS = [-0.9, -0.5, -1e-8, 0.0, 1e-8, 0.3, 0.9]
RATIOS = [-0.4, 0.0, 0.3, 0.5]


def kernel_of(k, nu=0.3):
    return PowerLawKernel(GradedHalfPlane(2.0, nu, k, 0.7))


@pytest.mark.parametrize("k", EXPONENTS)
@pytest.mark.parametrize("nu", RATIOS)
def test_kernel_is_the_point_force_field_on_the_surface(k, nu):
    """Even parts up to a constant: as differences between two distances."""
    kernel = kernel_of(k, nu)
    x = np.array([0.3, 2.0])
    N, T, D = kernel.values(x)

    def field(sign, P, Q):
        return point_force_displacement(kernel.solid, sign * x, 0 * x, P, Q, fixed_depth=0.7)

    for sign in (1, -1):
        (normal_x, normal_y), (tangential_x, tangential_y) = field(sign, 1, 0), field(sign, 0, 1)
        assert np.diff(normal_y) == pytest.approx(np.diff(N), rel=1e-12)
        assert np.diff(tangential_x) == pytest.approx(np.diff(T), rel=1e-12)
        # at |x| far below and above y0 alike: u_x of P is odd, and reciprocity gives u_y of Q
        assert normal_x == pytest.approx(sign * D, rel=1e-12, abs=1e-15)
        assert tangential_y == pytest.approx(-sign * D, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.6])
@pytest.mark.parametrize("force", ["P", "Q"])
def test_point_force_stress_is_that_of_its_displacement(k, force):
    """Hooke's law in plane strain, with strains by central differences; the other force is 0 where it is not given."""
    solid, x, y, step = kernel_of(k).solid, np.array([-0.7, 0.2, 0.5]), np.array([0.3, 0.4, 0.1]), 1e-4

    def change(dx, dy):
        ends = ((x + sign * dx, y + sign * dy) for sign in (1, -1))
        ahead, behind = (point_force_displacement(solid, *end, **{force: 2.0}, fixed_depth=0.7) for end in ends)
        return (ahead - behind) / (2 * step)

    (xx, yx), (xy, yy) = change(step, 0.0), change(0.0, step)
    shear = solid.modulus(y) / (2 * (1 + solid.nu))
    pressed = 2 * shear * solid.nu / (1 - 2 * solid.nu) * (xx + yy)
    expected = [pressed + 2 * shear * xx, pressed + 2 * shear * yy, shear * (xy + yx)]
    stress = point_force_stress(solid, x, y, **{force: 2.0})
    np.testing.assert_allclose(stress, expected, atol=1e-5 * np.abs(stress).max())


@pytest.mark.parametrize("k", [-0.3, 0.0])
def test_no_displacement_vanishes_at_infinity_unless_k_is_positive(k):
    with pytest.raises(ValueError, match="give fixed_depth"):
        point_force_displacement(kernel_of(k).solid, 0.3, 0.2, 1.0)


@pytest.mark.parametrize("nu", RATIOS)
def test_coupling_parameter(nu):
    """d = sqrt(bg) cot(beta pi/2), its limit for k = 0, its zero and change of sign at the Holl ratio."""
    for k in (-0.9, -0.5, 0.3, 0.9):
        solid = GradedHalfPlane(1.0, nu, k, 1.0)
        expected = solid.b * np.sqrt(solid.g / solid.b) / np.tan(solid.beta * np.pi / 2)
        assert solid.d == pytest.approx(expected, rel=1e-12)
    limit = -(1 - 2 * nu) * (1 + nu) / 2
    for k in (-1e-9, 0.0, 1e-9):
        assert kernel_of(k, nu).solid.d == pytest.approx(limit, rel=1e-8, abs=1e-8)
    for k in (0.0, 0.3, 0.9):
        holl = GradedHalfPlane.holl_ratio(k)
        assert abs(kernel_of(k, holl).solid.d) < 1e-15
        assert kernel_of(k, holl - 0.1).solid.d < 0


def test_kernel_is_continuous_through_k_zero():
    x = np.array([1e-6, 0.1, 30.0])
    at_zero = kernel_of(0.0).values(x)
    for k in (-1e-7, 1e-7):
        assert kernel_of(k).values(x) == pytest.approx(at_zero, rel=1e-5)


@pytest.mark.parametrize("k", EXPONENTS)
def test_antiderivatives(k):
    """Each is the integral of the one before; at the singular start against mpmath."""
    kernel = kernel_of(k)
    z = np.array([0.4, 1.3])
    F = kernel.antiderivatives(z)
    assert np.all(kernel.antiderivatives(np.zeros(1)) == 0)
    for component in range(3):
        for order in range(4):
            def f(t, order=order, component=component):
                t = np.array([t])
                return (kernel.values(t) if order == 0 else kernel.antiderivatives(t)[order - 1])[component, 0]

            difference = F[order, component, 1] - F[order, component, 0]
            assert quad(f, *z, epsabs=0, epsrel=1e-12)[0] == pytest.approx(difference, rel=1e-11)
    with mp.workdps(40):
        K, y0 = mp.mpf(k) if k else mp.mpf("1e-25"), mp.mpf(0.7)
        exact = mp.quad(lambda u: (u / y0) ** -K * 1, [0, mp.mpf(0.4)]) if k < 0.5 else 0.4 * (0.4 / y0) ** -K / (1 - K)
    assert F[0, 2, 0] == pytest.approx(float(exact) * kernel.solid.d / 2.0, rel=1e-10)


@pytest.mark.parametrize("k", [-0.4, 0.0, 0.5])
def test_kernel_at_one_distance(k):
    kernel = PowerLawKernel(GradedHalfPlane(2.0, 0.2, k, 0.5))
    assert np.all(kernel.values(0.3) == kernel.values(np.array([0.3]))[:, 0])
    assert np.all(kernel.antiderivatives(0.3) == kernel.antiderivatives(np.array([0.3]))[..., 0])


@pytest.mark.parametrize("k", [-0.9, 0.0, 0.9])
def test_element_moments_near_and_far(k):
    """Elements from 1e-7 to 1 long against adaptive quadrature, from beside and far away."""
    kernel = kernel_of(k)
    nodes = np.array([0.0, 1e-7, 3e-7, 1e-4, 1e-3, 0.1, 0.3, 1.0])
    x = np.array([0.0, 1e-7, 2e-4, 0.2, 1.5])
    moments = element_moments(kernel, x, nodes)
    for i, xi in enumerate(x):
        for j in range(len(nodes) - 1):
            left, length = nodes[j], nodes[j + 1] - nodes[j]
            if not left < xi < nodes[j + 1] and min(abs(xi - nodes[j : j + 2])) > 0:
                for r in (0, 3):
                    f = [
                        quad(lambda t, c=c: np.sign(xi - left) ** (c == 2) * kernel.values(np.array(
                            [abs(xi - left - t * length)]))[c, 0] * t**r, 0, 1, epsabs=0, epsrel=1e-11, limit=200)[0]
                        for c in range(3)
                    ]
                    assert moments[:, r, i, j] == pytest.approx(np.array(f) * length, rel=1e-9, abs=0)


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.3, 0.9])
@pytest.mark.parametrize("nu", [0.0, 0.45])
def test_compliance_per_wavenumber(k, nu):
    """The Fourier form of [X6] gives the displacement of a smooth traction that the kernel gives on the surface."""
    kernel = kernel_of(k, nu)
    nodes = np.linspace(-9, 9, 601)
    bell, half = np.exp(-(nodes**2) / 2), 300
    smooth = adapted(nodes, Edges.of_zones([[-99, 99]]), Edges.of_zones([]), 0.5, 1.0)
    u_x, u_y = SurfaceOperator.on(kernel, nodes, smooth, smooth).displacement(bell, bell)
    x = nodes[half + 45]

    def inverse(component):
        """∫ C bell^ (e^(i w x) - 1) dw / (2 pi), the displacement at x relative to that at 0."""
        def even(w):
            return kernel.compliance(w)[component].real * np.exp(-(w**2) / 2) * (np.cos(w * x) - 1)

        def odd(w):
            return -kernel.compliance(w)[2].imag * np.exp(-(w**2) / 2) * np.sin(w * x)

        integrand = odd if component == 2 else even
        return np.sqrt(2 * np.pi) / np.pi * quad(integrand, 0, 12, epsabs=1e-13, epsrel=1e-11)[0]

    C_xx, C_yy, C_xy = (inverse(component) for component in range(3))
    assert u_x[half + 45] - u_x[half] == pytest.approx(C_xx + C_xy, rel=1e-6)
    assert u_y[half + 45] - u_y[half] == pytest.approx(C_yy - C_xy, rel=1e-6)


def test_interpolation_reproduces_roots_and_cubics():
    nodes = np.linspace(0, 1, 60) ** 3
    edges = Edges.of_zones([[0.0, 2.0]])
    root = adapted(nodes, edges, Edges.of_zones([]), 0.25, 1.0)
    x = np.linspace(1e-4, 0.04, 500)
    assert Interpolant.of(nodes, root, nodes**0.25)(x) == pytest.approx(x**0.25, rel=2e-3)
    far = x > 4e-3  # elements shorter than a third of the distance from the edge
    assert Interpolant.of(nodes, root, nodes**0.25)(x)[far] == pytest.approx(x[far] ** 0.25, rel=1e-5)
    x = np.linspace(0.06, 0.9, 500)
    assert Interpolant.of(nodes, root, nodes**3 - nodes)(x) == pytest.approx(x**3 - x, rel=1e-12)
    assert nodal_integrals(nodes, root) @ nodes**0.25 == pytest.approx(0.8, rel=1e-4)
    straight = Interpolant.of(nodes, linear(nodes), nodes)
    assert straight.integral(nodes**2) == pytest.approx(0.25, rel=1e-12)
