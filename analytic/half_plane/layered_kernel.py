"""Surface kernel of a half-plane with any modulus E(y): from its compliance per wavenumber, beyond the paper [X6].

A surface wave e^(iωx) of tractions meets the 2×2 compliance of the body below each depth, which grows from
the substrate upwards by a Riccati equation. The difference from the power law that the modulus follows at the
surface is a smooth kernel. It is added to PowerLawKernel as a sum of kernels ln(x² + h²) of sources at depths h.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.special import xlogy

from ..material import GradedHalfPlane
from ..quadrature import gauss_rule
from .surface_kernel import PowerLawKernel

DEPTH = 20.0  # over the wavenumber: what lies deeper is felt by e^-40
RTOL, ATOL = 1e-11, 1e-13
BESIDE_JUMP = 1e-13  # relative distance to a jump of E at which its side is certain
# over the wavenumber: depth at which the integration ends, in the regular depth variable, and in y: near |k| = 1 y is
# no number there
NEAREST, NEAREST_Y = 1e-12, 1e-250
LONGEST = 0.01  # least wavenumber of the sources, over that of the largest distance
PER_DECADE, SOURCES_PER_DECADE = 20, 10
LONG_WAVES = 12  # wavenumbers at which waves are looked at that are too long for the sources
CUTOFF = 1e-13  # of the singular values: smaller ones only make strong sources that cancel
# of the sources, times the largest wavenumber looked at: shallower ones are free to cancel there only, and for k < 0
# leave shorter waves a negative compliance
SHALLOWEST = 2.0
LARGEST_MISFIT, LARGEST_AT_SURFACE = 1e-5, 0.02
TABLE = 1600  # points of the tabulated smooth part
SHORT = 1e3 * 2.0 ** np.arange(4)  # wavenumbers, times the first layer, from which C is continued to infinity
LEAST_KINK = 1e-4  # change of C by the slope of E over the first layer, over C; rounding is below


def surface_compliance(modulus, nu, wavenumber, depth, surface_exponent=0.0):
    """Compliance C_xx, C_yy and Im C_xy at wavenumbers ω > 0 (n,) [length/stress], shape (3, n), as in PowerLawKernel.

    modulus: E(y) [stress] of arrays 0 < y <= depth [length], constant below; it may vanish or be infinite at
    y = 0 like y^surface_exponent.
    """
    omega, order = np.asarray(wavenumber, dtype=float), 1 / (1 - abs(surface_exponent))
    bottom = np.minimum(depth, DEPTH / omega)
    reference = modulus(bottom * (1 + BESIDE_JUMP))  # of the half-plane below
    n, plane = nu / (1 - nu), 1 / ((1 - nu) * (1 + nu))
    shear, axial = 2 * (1 + nu), (1 + nu) * (1 - 2 * nu) / (1 - nu)  # E/G and E/(lambda + 2G)

    def riccati(s, S):
        """dS/ds of ω E_ref times the compliance, y = s^order/ω: u_x = iX, q = i f, hence real and symmetric."""
        xx, yy, xy = S
        e = modulus(s**order / omega) / reference
        slope = np.array([
            -2 * xy - shear / e + e * plane * xx * xx,
            2 * n * xy - axial / e + e * plane * xy * xy,
            n * xx - yy + e * plane * xx * xy,
        ])
        return slope * order * s ** (order - 1)

    nearest = max(NEAREST, NEAREST_Y ** (1 / order))
    start = np.maximum((omega * bottom) ** (1 / order), nearest) * (1 - BESIDE_JUMP)
    way = nearest * (1 + BESIDE_JUMP) - start

    def together(t, S):
        """The same for all wavenumbers at once, s from the start (t = 0) to the surface (t = 1)."""
        return np.ravel(riccati(start + t * way, S.reshape(3, -1)) * way)

    homogeneous = PowerLawKernel(GradedHalfPlane(1.0, nu, 0.0, 1.0)).compliance(1.0)
    S = np.array([homogeneous[0].real, homogeneous[1].real, homogeneous[2].imag])
    with np.errstate(over="ignore", invalid="ignore"):  # in trial steps that are refused, near |k| = 1
        solved = solve_ivp(together, (0.0, 1.0), np.repeat(S, omega.size), "DOP853", rtol=RTOL, atol=ATOL)
    if not solved.success:
        raise RuntimeError(f"the Riccati equation does not integrate: {solved.message}")
    S = solved.y[:, -1].reshape(3, -1)
    S = S - nearest * riccati(nearest, S)  # the slope is constant up to the surface
    return S / (omega * reference)


def require_reach(kernel, width):
    """Raise ValueError for a contact of this width [length] beyond the ``largest`` distance of a LayeredKernel."""
    largest = getattr(kernel, "largest", np.inf)
    if width > largest:
        raise ValueError(f"the contact is {width:.3g} wide, its kernel is known up to distances of {largest:.3g} only")


@dataclass(frozen=True)
class LayeredKernel:
    """SurfaceKernel of E(y), which follows the power law of ``surface`` for y -> 0 and is constant below ``depth``.

    modulus: E(y) [stress] of arrays y; surface: GradedHalfPlane of its behaviour at the surface, with
    the Poisson's ratio of the whole; depth: [length]; smallest: distance [length] below which the power law is
    all that matters, a small part of the contact; largest: greatest distance that will be asked for [length]; nearest:
    least depth where E is not smooth [length], None for ``depth``.
    """

    modulus: Callable
    surface: GradedHalfPlane
    depth: float
    smallest: float
    largest: float
    nearest: float | None = None

    @property
    def first_layer(self):
        """Depth down to which E is smooth [length]."""
        return self.depth if self.nearest is None else self.nearest

    @property
    def k(self):
        """Exponent at the surface."""
        return self.surface.k

    @cached_property
    def power_law(self):
        """Kernel of the power law at the surface."""
        return PowerLawKernel(self.surface)

    def compliance(self, wavenumber):
        """C_xx, C_yy and Im C_xy for an array of wavenumbers [length/stress], shape (3, n)."""
        return surface_compliance(self.modulus, self.surface.nu, wavenumber, self.depth, self.k)

    def _decay(self, omega):
        """ω C of the power law at the surface and of the body, columns N, T, Im C_xy."""
        power = self.power_law.compliance(omega)
        both = np.stack([power[0].real, power[1].real, power[2].imag]), self.compliance(omega)
        return [(omega * C)[[1, 0, 2]].T for C in both]

    @cached_property
    def kinks(self):
        """Factors (3,) of |x| in N and T and of x ln|x| in D, not zero where k = 0 and E has a slope at the surface."""
        if self.k or np.isinf(self.first_layer):
            return np.zeros(3)
        omega = SHORT / self.first_layer
        power, whole = self._decay(omega)
        rest = np.linalg.solve(omega[:, None] ** -np.arange(len(omega)), omega[:, None] * (whole - power))[0]
        is_smooth = np.abs(rest).max() * self.first_layer < LEAST_KINK * power[0, 0]
        return np.zeros(3) if is_smooth else rest * [-1 / 2, -1 / 2, 1 / np.pi]

    def _of_kinks(self, omega):
        """ω ΔC of the ``kinks`` for waves shorter than the first layer, fading for longer ones: N, T, Im C_xy."""
        return self.kinks * [-2, -2, np.pi] * (-np.expm1(-omega * self.first_layer) / omega)[:, None]

    @cached_property
    def _sources(self):
        """Depths h and strengths a of ω ΔC = Σ a e^(-ωh) beside ``_of_kinks``, columns N, T, D; and the misfit."""
        low, high = LONGEST / self.largest, 3 / self.smallest
        decades = np.log10(high / low)
        omega = np.geomspace(low, high, int(PER_DECADE * decades))
        power, whole = self._decay(omega)
        target = whole - power - self._of_kinks(omega)
        left = np.abs(target[-1]).max() / np.abs(power[-1, 0])
        if left > LARGEST_AT_SURFACE:
            raise ValueError(
                f"E(y) leaves its law at the surface at too small a depth: the compliance of waves 2 pi/{high:.3g} "
                f"long differs by {left:.1%} from that of this law, and {LARGEST_AT_SURFACE:.0%} are allowed"
            )
        shallow, deep = SHALLOWEST / high, 10 / low
        h = np.geomspace(shallow, deep, int(SOURCES_PER_DECADE * np.log10(deep / shallow)))
        waves, target = np.exp(-omega[:, None] * h) / whole[:, :1], target / whole[:, :1]
        strength, *_ = np.linalg.lstsq(waves, target, rcond=CUTOFF)
        misfit = np.abs(waves @ strength - target).max(axis=0)
        if misfit.max() > LARGEST_MISFIT:
            raise RuntimeError(
                f"the kernel of the coated half-plane is met to {misfit.max():.1e} only, {LARGEST_MISFIT:.0e} is needed"
            )
        return h, strength, misfit

    @property
    def misfit(self):
        """Largest error of C that the sum of sources leaves, over C_yy of the body at the same wavenumber: N, T, D."""
        return self._sources[2]

    @cached_property
    def _long_waves(self):
        """First two moments of what the sources leave of ω ΔC below all fitted ω: columns N, T, D.

        For k < 0 it grows like ω^k. Waves so long are seen as the slope that they give D and the curvature of N, T.
        """
        h, strength, _ = self._sources
        t, weight = gauss_rule(LONG_WAVES)
        order = 1 / (1 + min(self.k, 0.0))
        omega = LONGEST / self.largest * t**order
        power, whole = self._decay(omega)
        left = whole - power - self._of_kinks(omega) - np.exp(-omega[:, None] * h) @ strength
        steps = weight * order * omega / t
        return steps @ left, steps * omega @ left

    @cached_property
    def _table(self):
        """Splines of the parts of N, T and D without kinks over arsinh(x/smallest)."""
        (h, strength, _), (slope, curvature) = self._sources, self._long_waves
        u = np.linspace(0, np.arcsinh(self.largest / self.smallest), TABLE)
        x = self.smallest * np.sinh(u)[:, None]
        even = -(np.log1p((x / h) ** 2) @ strength[:, :2] + x**2 * curvature[:2]) / (2 * np.pi)
        # C_xy is imaginary: the sine transform of D is -Im C_xy
        odd = -(np.arctan2(x, h) @ strength[:, 2] + x[:, 0] * slope[2]) / np.pi
        regular = np.column_stack([even, odd])
        if self.kinks.any():  # what ``_of_kinks`` has beside them
            x, h = x[:, 0], self.first_layer
            of_even = 2 / np.pi * (h / 2 * np.log1p((x / h) ** 2) - x * np.arctan(x / h))
            of_odd = -(x / 2 * np.log(x**2 + h**2) + h * np.arctan(x / h))
            regular += self.kinks * np.column_stack([of_even, of_even, of_odd])
        return CubicSpline(u, regular)

    def regular(self, z):
        """``smooth`` without the ``kinks``."""
        return np.moveaxis(self._table(np.arcsinh(z / self.smallest)), -1, 0)

    def smooth(self, z):
        """Difference of N, T and D from the power law at distance z >= 0, shape (3, *z.shape), for quadrature."""
        kinks = self.kinks.reshape(3, *[1] * np.ndim(z))
        return self.regular(z) + kinks * np.stack([z, z, xlogy(z, z)])

    def values(self, z):
        """N, T and D at distance z > 0 [1/stress], shape (3, *z.shape)."""
        return self.power_law.values(z) + self.smooth(np.asarray(z, dtype=float))

    def antiderivatives(self, z):
        """Those of the power law at the surface; the smooth part is left to quadrature."""
        return self.power_law.antiderivatives(z)
