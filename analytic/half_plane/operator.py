"""Surface displacement of tractions given at nodes: the singular kernels integrated exactly over polynomials."""

from dataclasses import dataclass

import numpy as np

from .interpolation import POWERS
from .surface_kernel import SurfaceKernel

NEAR = 6.0  # element lengths within which the closed antiderivatives are used
NO_COUPLING = 1e-12  # of the largest displacement: what coupling at the Holl ratio is rounded to
GAUSS, GAUSS_WEIGHT = np.polynomial.legendre.leggauss(5)  # beyond: relative error of about (4 NEAR)^-10


def element_moments(kernel: SurfaceKernel, x, nodes):
    """∫ K(x_i - ξ) t^r dξ over each element for N, T, D and r = 0..3, shape (3, 4, len(x), elements).

    Near an element by parts from the antiderivatives. Far from it their difference would cancel, and Gauss
    quadrature is exact to rounding.
    """
    length = np.diff(nodes)
    offset = np.asarray(x)[:, None] - (nodes[1:] + nodes[:-1]) / 2
    near = np.abs(offset) <= NEAR * length
    moments = np.empty((3, POWERS, *offset.shape))
    for g, w in zip(GAUSS, GAUSS_WEIGHT, strict=True):
        z = offset - length / 2 * g
        value = kernel.values(np.where(near, 1.0, np.abs(z)))
        value[2] *= np.sign(z)
        value *= w / 2 * length
        for r in range(POWERS):
            if r:
                value *= (1 + g) / 2
            if g == GAUSS[0]:
                moments[:, r] = value
            else:
                moments[:, r] += value
    i, j = np.nonzero(near)
    moments[:, :, i, j] = _near(kernel, x[i] - nodes[j], x[i] - nodes[j + 1], length[j])
    if hasattr(kernel, "smooth"):
        for g, w in zip(GAUSS, GAUSS_WEIGHT, strict=True):
            z = offset[i, j] - length[j] / 2 * g
            value = kernel.smooth(np.abs(z)) * (w / 2 * length[j])
            value[2] *= np.sign(z)
            moments[:, :, i, j] += value[:, None] * ((1 + g) / 2) ** np.arange(POWERS)[:, None]
    return moments


def _near(kernel, z_left, z_right, length):
    left, right = _signed(kernel, z_left), _signed(kernel, z_right)
    moments = np.empty((3, POWERS, len(length)))
    # ∫ F_m t^r = -[F_(m+1) t^r] + (r/length) ∫ F_(m+1) t^(r-1), with F_m the m-th antiderivative of K
    for r in range(POWERS):
        integral = left[r] - right[r]
        for power in range(1, r + 1):
            integral = -right[r - power] + power / length * integral
        moments[:, r] = integral
    return moments


def _signed(kernel, z):
    """Antiderivatives at z of either sign: those of even functions are odd, even, ..., of odd ones the reverse."""
    F = kernel.antiderivatives(np.abs(z))
    F[0::2, :2] *= np.sign(z)
    F[1::2, 2] *= np.sign(z)
    return F


def nodal_moments(moments, interpolation):
    """Displacements (..., len(x), nodes) of unit values at the nodes, from moments (..., 4, len(x), elements)."""
    _, elements, nodes = interpolation.shape
    result = np.zeros((*moments.shape[:-3], moments.shape[-2], nodes))
    j = np.arange(elements)
    for shift in range(-1, 3):  # an element takes part in four nodes at most
        here = j[(j + shift >= 0) & (j + shift < nodes)]
        for r in range(POWERS):
            coefficient = interpolation[r, here, here + shift]
            if coefficient.any():
                start, stop = here[0], here[-1] + 1
                result[..., start + shift : stop + shift] += moments[..., r, :, start:stop] * coefficient
    return result


def displacement_of(moments, coefficients):
    """Displacement (len(x),) of tractions with these ``coefficients`` (4, elements), from moments of one kernel."""
    return np.einsum("rie,re->i", moments, coefficients, optimize=True)


def nodal_integrals(nodes, interpolation):
    """∫ of the interpolant of unit values at the nodes [length]: the quadrature weights."""
    return np.einsum("ren,r,e->n", interpolation, 1 / np.arange(1, POWERS + 1), np.diff(nodes))


@dataclass(frozen=True)
class SurfaceOperator:
    """Displacements at the ``nodes`` of pressure and traction, each with an interpolation of its own.

    normal, tangential: matrices N of the pressure and T of the traction; coupling, coupling_q: D of the
    pressure and of the traction [length/stress]; weight, weight_q: their quadrature weights [length].
    """

    nodes: np.ndarray
    of_pressure: np.ndarray
    of_traction: np.ndarray
    weight: np.ndarray
    weight_q: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    coupling: np.ndarray
    coupling_q: np.ndarray

    @classmethod
    def on(cls, kernel, nodes, of_pressure, of_traction, coupled=True):
        """Operator for interpolations (4, elements, nodes) of both; without ``coupled``, D is zero."""
        N, T, D = element_moments(kernel, nodes, nodes)
        coupling = coupling_q = np.zeros((len(nodes), len(nodes)))
        if coupled:
            coupling, coupling_q = (nodal_moments(D, i) for i in (of_pressure, of_traction))
        weight, weight_q = (nodal_integrals(nodes, i) for i in (of_pressure, of_traction))
        normal, tangential = nodal_moments(N, of_pressure), nodal_moments(T, of_traction)
        return cls(nodes, of_pressure, of_traction, weight, weight_q, normal, tangential, coupling, coupling_q)

    @property
    def is_coupled(self) -> bool:
        """Whether the traction moves the surface up and down: not at the Holl ratio."""
        return bool(np.abs(self.coupling_q).max() > NO_COUPLING * np.abs(self.normal).max())

    def displacement(self, pressure, traction):
        """u_x and u_y at the nodes [length], up to the rigid translation."""
        u_x = self.tangential @ traction + self.coupling @ pressure
        u_y = self.normal @ pressure - self.coupling_q @ traction
        return u_x, u_y
