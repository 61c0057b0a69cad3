"""Surface displacements of the power-law half-plane under line forces, with their coupling: kernels (2) and [X6].

The derivation is in docs/coupling_kernel.md. A kernel is all that the contact solver knows of an elastic
body: anything with the methods ``values`` and ``antiderivatives`` below can take its place.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, gamma, pi
from typing import Protocol

import numpy as np

from ..material import GradedHalfPlane


class SurfaceKernel(Protocol):
    """Surface displacement at x from unit line forces at the origin: u_y = N P - D Q, u_x = T Q + D P.

    N and T are even in x and hold up to a constant, which only shifts the rigid body; D is odd.
    """

    @property
    def k(self) -> float:
        """Exponent of the modulus at the surface: tractions end like distance^((1+k)/2)."""

    def values(self, z) -> np.ndarray:
        """N, T and D at distance z > 0 [1/stress], shape (3, *z.shape)."""

    def antiderivatives(self, z) -> np.ndarray:
        """Their first to fourth antiderivatives, all zero at z = 0, for z >= 0, shape (4, 3, *z.shape).

        A kernel with a method ``smooth`` leaves out that part of its values, which is integrated by quadrature.
        """


@dataclass(frozen=True)
class PowerLawKernel:
    """Kernel of a GradedHalfPlane, regular through k = 0 and the Holl ratio.

    N = (bk) y0^k/E0 (|x|^-k - L^-k)/k, T the same with (gk), D = d y0^k/E0 sgn(x) |x|^-k, with the
    arbitrary length L = y0 that makes the even kernels exist for k <= 0 as well; k -> 0: -ln(|x|/y0).
    """

    solid: GradedHalfPlane

    @property
    def k(self):
        """Exponent of (1)."""
        return self.solid.k

    @cached_property
    def _factors(self):
        """y0^k/E0 times (bk), (gk) and d, for distances in units of y0: [1/stress]."""
        solid = self.solid
        return np.array([solid.bk, solid.gk, solid.d]) / solid.E0

    def values(self, z):
        """N, T and D at distance z > 0 [1/stress], shape (3, *z.shape); (2), [X6]."""
        k, log_z = self.solid.k, np.log(np.asarray(z, dtype=float) / self.solid.y0)
        regularised = np.expm1(-k * log_z) / k if k else -log_z
        return self._scaled(regularised, 1 + k * regularised, 1.0, np.empty((3, *log_z.shape)))

    def antiderivatives(self, z):
        """First to fourth antiderivatives of N, T and D for z >= 0, shape (4, 3, *z.shape)."""
        k = self.solid.k
        z = np.asarray(z, dtype=float)
        log_z = np.log(np.where(z > 0, z, 1.0) / self.solid.y0)
        regularised = np.expm1(-k * log_z) / k if k else -log_z
        power = 1 + k * regularised
        result = np.empty((4, 3, *z.shape))
        scale, constant = 1.0, 0.0  # z^n/((1-k)...(n-k)) and (1 - (1-k)(1-k/2)...(1-k/n))/k
        for n in range(1, 5):
            scale = scale * z / (n - k)
            constant += (1 - k * constant) / n
            self._scaled(regularised + constant, power, scale, result[n - 1])
        return result

    def _scaled(self, even, odd, scale, out):
        normal, tangential, coupling = self._factors
        even = even * scale
        np.multiply(even, normal, out=out[0, ...])
        np.multiply(even, tangential, out=out[1, ...])
        np.multiply(odd * scale, coupling, out=out[2, ...])
        return out

    def compliance(self, wavenumber):
        """2×2 surface compliance at the wavenumber ω > 0 [length/stress]; its entries xx, yy, xy, shape (3, ...).

        Tractions e^(iωx) (q, p) displace the surface by e^(iωx) (C_xx q + C_xy p, C_yy p - C_xy q), [X6].
        """
        k, solid = self.solid.k, self.solid
        omega = np.abs(np.asarray(wavenumber, dtype=float)) * solid.y0
        decay = solid.y0 * gamma(1 - k) * omega ** (k - 1) / solid.E0
        even = pi * np.sinc(k / 2)  # 2 sin(k pi/2)/k
        return np.stack([decay * even * solid.gk, decay * even * solid.bk, -2j * decay * cos(k * pi / 2) * solid.d])
