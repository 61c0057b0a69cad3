"""Kernels of any depth profile: the power law recovered, a coating per wavenumber and in contact."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from analytic import CylinderContact, GradedHalfPlane, PowerProfile
from analytic.half_plane.interpolation import Edges, adapted
from analytic.half_plane.layered_kernel import LayeredKernel, surface_compliance
from analytic.half_plane.operator import SurfaceOperator
from analytic.half_plane.solver import HalfPlaneContact
from analytic.half_plane.surface_kernel import PowerLawKernel

PROFILE, MU = PowerProfile(0.5, 2.0), 0.3


@pytest.mark.parametrize("k", [-0.97, -0.5, -0.1, 0.0, 0.3, 0.8, 0.97, 0.99])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_power_law_is_recovered(k, nu):
    """The depth equations give [X6] at every wavenumber; nothing in them knows of it."""
    solid = GradedHalfPlane(2.0, nu, k, 0.7)
    omega = np.array([1e-2, 1.0, 1e3])
    C = PowerLawKernel(solid).compliance(omega)
    expected = np.array([C[0].real, C[1].real, C[2].imag])
    computed = surface_compliance(solid.modulus, nu, omega, np.inf, k)
    assert np.all(np.abs(computed - expected) < 1e-10 * expected[0])


def coating(E, k=0.0, thickness=1.0):
    """E(y) within the thickness on a substrate of modulus 1."""
    def modulus(y):
        return np.where(y <= thickness, E(y), 1.0)

    surface = GradedHalfPlane(E(1e-9) * (1e9**k if k else 1.0), 0.3, k, 1.0)
    return LayeredKernel(modulus, surface, thickness, min(1e-3, thickness / 10), 30.0)


COATINGS = {
    "homogeneous": coating(lambda y: 3.0),
    "exponential": coating(lambda y: 3.0 * np.exp(-y * np.log(3.0))),
    "linear": coating(lambda y: 1 + 2 * (1 - y)),
    "tabulated": coating(lambda y: np.interp(y, [0, 0.3, 1], [2.0, 3.0, 1.0])),
    "power law": coating(lambda y: y**0.3, 0.3),
}


@pytest.mark.parametrize("name", COATINGS)
def test_surface_displacement_of_a_smooth_traction(name):
    """Sources against the inverse Fourier transform of the compliance."""
    kernel = COATINGS[name]
    nodes = np.linspace(-6, 6, 301)
    half, shift, width = 150, 40, 0.5
    bell = np.exp(-((nodes / width) ** 2) / 2)
    smooth = adapted(nodes, Edges.of_zones([[-99, 99]]), Edges.of_zones([]), 0.5, 1.0)
    u_x, u_y = SurfaceOperator.on(kernel, nodes, smooth, smooth).displacement(0 * bell, bell)[::-1]
    x = nodes[half + shift]

    def integrand(t):
        omega = np.exp(t)
        C = surface_compliance(kernel.modulus, 0.3, omega, kernel.depth, kernel.k)
        envelope = width * np.exp(-((omega * width) ** 2) / 2) * omega * np.sqrt(2 / np.pi)
        return envelope * np.array([C[0] * (np.cos(omega * x) - 1), C[2] * np.sin(omega * x)])

    t = np.linspace(np.log(1e-5), np.log(12 / width), 501)
    C_xx, C_xy = np.trapezoid(integrand(t), t)
    # u of a tangential traction: u_x even, u_y = -D * q odd, and D is minus the sine transform of Im C_xy
    assert u_y[half + shift] - u_y[half] == pytest.approx(C_xx, rel=2e-5)
    assert u_x[half + shift] == pytest.approx(C_xy, rel=2e-5, abs=2e-5 * abs(C_xx))


@pytest.mark.parametrize(
    "modulus, k, nu, thickness",
    [
        (lambda y: np.where(y <= 0.3, 1.0, 0.2), 0.0, 0.45, 0.3),
        (lambda y: np.where(y <= 0.3, 1.0, 5.0), 0.0, 0.45, 0.3),
        (lambda y: np.minimum(y, 2.0) ** -0.8, -0.8, 0.3, 2.0),  # of the power law alone, D is 7 times as large
    ],
)
def test_coupling_as_far_as_is_asked(modulus, k, nu, thickness):
    """D at ``largest`` against its sine transform: waves far longer than ``largest`` take part in it."""
    largest = 8.0
    kernel = LayeredKernel(modulus, GradedHalfPlane(1.0, nu, k, 1.0), thickness, 1e-3, largest)
    omega = np.geomspace(1e-7, 40 / thickness, 400)
    whole, power = omega * kernel.compliance(omega)[2], omega * kernel.power_law.compliance(omega)[2].imag
    far = CubicSpline(np.log(omega), whole - power)
    t = np.linspace(np.log(omega[0]), np.log(omega[-1]), 100001)
    expected = -(t[1] - t[0]) * np.sum(far(t) * np.sin(np.exp(t) * largest)) / np.pi
    expected -= omega[0] * largest * (whole[0] - power[0] / (1 + k)) / np.pi  # longer waves: a constant, and ω^k
    assert kernel.smooth(np.array([largest]))[2, 0] == pytest.approx(expected, abs=1e-3 * abs(kernel.surface.d))


def test_far_from_a_force_a_thin_coating_leaves_the_kernels_of_its_substrate():
    """-2 (1 - nu²)/(pi E) ln|x|, though its own law grows for long waves: what is left of them are 2 % of this."""
    thickness = 0.005
    kernel = LayeredKernel(
        lambda y: np.minimum(y / thickness, 1.0) ** -0.8,
        GradedHalfPlane(1.0, 0.3, -0.8, thickness), thickness, 1e-4 * thickness, 8.0,
    )
    near, far = kernel.values(np.array([4.0, 8.0]))[:2].T
    assert far - near == pytest.approx(-2 * 0.91 / np.pi * np.log(2), rel=2e-4)


@pytest.mark.parametrize("k, thickness", [(-0.8, 2.0), (-0.8, 0.3), (-0.8, 0.02), (-0.5, 2.0), (0.0, 0.3)])
def test_short_waves_see_the_power_law_alone(k, thickness):
    """Shorter than any that were fitted too: with a negative compliance nodes at the edges have no contact problem."""
    ratio = 0.01  # of a soft substrate under k = 0
    kernel = LayeredKernel(
        lambda y: np.minimum(y, thickness) ** k if k else 1 + (ratio - 1) * np.minimum(y, thickness) / thickness,
        GradedHalfPlane(1.0, 0.3, k, 1.0), thickness, 1e-4 * min(1.0, thickness), 8.0,
    )
    h, strength, _ = kernel._sources
    omega = np.geomspace(0.3 / kernel.smallest, 1e4 / kernel.smallest, 200)
    power = omega * kernel.power_law.compliance(omega)[:2].real
    left = np.exp(-omega[:, None] * h) @ strength[:, [1, 0]]
    assert np.all(np.abs(left.T) < 0.01 * power)


def test_contact_on_the_power_law_as_any_other_profile():
    solid = GradedHalfPlane(1.0, 0.3, 0.3, 1.0)
    kernel = LayeredKernel(solid.modulus, solid, np.inf, 1e-3, 30.0)
    loads = [(1.0, 0.0), (1.0, 0.27)]
    states, expected = (HalfPlaneContact(body, PROFILE, MU, nodes=150).run(loads) for body in (kernel, solid))
    assert states[-1].contact == pytest.approx(expected[-1].contact, rel=1e-8)
    assert states[-1].stick == pytest.approx(expected[-1].stick, rel=1e-7)


def test_coating_between_its_limits():
    """Thick: the coating alone; thin: the substrate alone; in between the contact widens."""
    widths = []
    for thickness in (300.0, 3.0, 1.0, 0.3, 0.001):
        kernel = coating(lambda y: 3.0, thickness=thickness)
        state = HalfPlaneContact(kernel, PROFILE, MU, coupling=False, nodes=100).run([(1.0, 0.0)])[0]
        widths.append(state.contact[1])
    thick, thin = (CylinderContact(GradedHalfPlane(E, 0.3, 0.0, 1.0), 1.0, 1.0).a for E in (3.0, 1.0))
    assert widths[0] == pytest.approx(thick, rel=1e-3)
    assert widths[-1] == pytest.approx(thin, rel=3e-3)
    assert np.all(np.diff(widths) > 0)


def test_wrong_behaviour_at_the_surface_is_found():
    kernel = LayeredKernel(lambda y: np.where(y < 1, 3.0, 1.0), GradedHalfPlane(2.0, 0.3, 0.0, 1.0), 1.0, 1e-3, 30.0)
    with pytest.raises(ValueError, match="at the surface at too small a depth"):
        kernel.values(np.array([1.0]))


def airy_compliance(E, E_substrate, nu, omega, thickness):
    """C_xx, C_yy, Im C_xy of a homogeneous coating from Airy's stress function f(y) e^(iωx), without any ODE."""
    polynomial = [(s, n) for s in (-1, 1) for n in (0, 1)]  # (ω y)^n e^(s ω y); only s = -1 decays in the substrate

    def fields(s, n, y, modulus, origin):
        """σ_yy, σ_xy, u_x, u_y for unit coefficient; derivatives of f by Leibniz."""
        t = omega * (y - origin)
        f = [omega**m * np.exp(s * t) * (s**m * t**n + (m * s ** (m - 1) if n and m else 0)) for m in range(4)]
        compliance = (1 + nu) / modulus
        shear = -1j * omega * f[1]
        u_x = compliance * ((1 - nu) * f[2] + nu * omega**2 * f[0]) / (1j * omega)
        slope = compliance * ((1 - nu) * f[3] + nu * omega**2 * f[1]) / (1j * omega)
        return np.array([-(omega**2) * f[0], shear, u_x, (2 * compliance * shear - slope) / (1j * omega)])

    A = np.zeros((6, 6), dtype=complex)
    for column, (s, n) in enumerate(polynomial):
        origin = 0.0 if s < 0 else thickness  # no large exponentials
        A[:2, column] = fields(s, n, 0.0, E, origin)[:2]
        A[2:, column] = fields(s, n, thickness, E, origin)
    for column, (s, n) in enumerate(polynomial[:2], start=4):
        A[2:, column] = -fields(s, n, thickness, E_substrate, thickness)
    load = np.zeros((6, 2))
    load[1, 0] = load[0, 1] = -1  # q and p on the body
    coefficients = np.linalg.solve(A, load)
    surface = np.array([fields(s, n, 0.0, E, 0.0 if s < 0 else thickness)[2:] for s, n in polynomial]).T
    (C_xx, C_xy), (_, C_yy) = surface @ coefficients[:4]
    return np.array([C_xx.real, C_yy.real, C_xy.imag])


@pytest.mark.parametrize("ratio", [0.1, 10.0])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_compliance_of_a_coating_by_stress_functions(ratio, nu):
    omega = np.array([0.01, 0.3, 1.0, 3.0, 30.0])
    computed = surface_compliance(lambda y: np.where(y <= 1, ratio, 1.0), nu, omega, 1.0)
    for one, found in zip(omega, computed.T, strict=True):
        expected = airy_compliance(ratio, 1.0, nu, one, 1.0)
        assert found == pytest.approx(expected, abs=1e-9 * expected[0])


@pytest.mark.parametrize("thickness", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("ratio", [0.1, 10.0])
@pytest.mark.parametrize("kind", ["uniform", "exponential", "linear", "power law"])
def test_coatings_up_to_a_factor_of_ten(kind, ratio, thickness):
    """Harder or softer by ten, a tenth or ten contacts thick: the sum of sources meets the compliance to 5e-6."""
    k = {0.1: 0.3, 10.0: -0.3}[ratio]
    modulus, exponent = {
        "uniform": (lambda y: ratio, 0.0),
        "exponential": (lambda y: ratio ** (1 - y / thickness), 0.0),
        "linear": (lambda y: ratio + (1 - ratio) * y / thickness, 0.0),
        "power law": (lambda y: (y / thickness) ** k, k),
    }[kind]
    surface = GradedHalfPlane(1.0 if exponent else ratio, 0.3, exponent, thickness)
    kernel = LayeredKernel(
        lambda y: np.where(y <= thickness, modulus(y), 1.0), surface, thickness, min(1e-3, thickness / 300), 30.0
    )
    assert kernel.misfit.max() < 5e-6


@pytest.mark.parametrize("slope", [-0.7, 2.0])
def test_kinks_are_all_that_a_slope_adds_close_to_a_force(slope):
    kernel = LayeredKernel(
        lambda y: 1 + slope * np.minimum(y, 1.0), GradedHalfPlane(1.0, 0.3, 0.0, 1.0), 1.0, 1e-4, 30.0
    )
    z = np.array([1e-3, 4e-3])
    regular = kernel.regular(z) / kernel.kinks[:, None]
    assert np.abs(np.diff(regular[:2]) / np.diff(z)).max() < 0.05 * abs(slope)  # of |z|: 1
    assert abs(np.diff(regular[2] / z)) < 0.05 * abs(slope)  # of z ln|z|: ln 4
    assert np.all(kernel.kinks[:2] * slope > 0) and kernel.kinks[2] * slope < 0


def test_kinks_are_those_of_the_layer_at_the_surface():
    """However thin: the first slope of the table goes on in the other."""
    surface = GradedHalfPlane(1.0, 0.3, 0.0, 1.0)
    table = LayeredKernel(lambda y: np.interp(y, [0, 1e-3, 1], [1, 1.002, 3.5]), surface, 1.0, 1e-4, 30.0, 1e-3)
    line = LayeredKernel(lambda y: 1 + 2 * np.minimum(y, 1), surface, 1.0, 1e-4, 30.0)
    assert table.kinks == pytest.approx(line.kinks, rel=1e-4)


def test_a_modulus_without_slope_has_no_kinks():
    film = LayeredKernel(lambda y: np.where(y < 1, 2.0, 1.0), GradedHalfPlane(2.0, 0.3, 0.0, 1.0), 1.0, 1e-3, 30.0)
    assert not film.kinks.any()


def test_misfit_counts_over_the_compliance_of_the_body():
    """A coating stiff at the surface, k < 0: long waves feel nothing of its power law, which is far softer."""
    k, thickness = -0.6, 0.05
    kernel = LayeredKernel(
        lambda y: np.where(y <= thickness, (y / thickness) ** k, 1.0),
        GradedHalfPlane(1.0, 0.3, k, thickness), thickness, thickness / 300, 30.0,
    )
    h, strength, _ = kernel._sources
    omega = np.geomspace(1e-3, 1e4, 50)
    power, whole = kernel.power_law.compliance(omega), kernel.compliance(omega)
    difference = whole - np.stack([power[0].real, power[1].real, power[2].imag])
    error = np.abs(np.exp(-omega[:, None] * h) @ strength - (omega * difference)[[1, 0, 2]].T).max(axis=0)
    assert np.all(error < 10 * kernel.misfit * np.abs(omega * whole[1]).max())
