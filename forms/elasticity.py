"""Plane-strain linear elasticity of the graded half-plane.

Two forms: in displacements alone, and for nearly or fully incompressible solids in displacements ``u`` and the mean
stress ``pi = lambda div u`` as a field of its own. ``pi`` is None in the first.
"""

from dataclasses import dataclass
from typing import Any

import ufl

from .depth_map import DepthMap
from .modulus import Modulus


@dataclass(frozen=True)
class Solid:
    """The elastic solid in the forms: E(y) and nu with constants as parameters, mesh depth s, height h of the cells.

    correction: factor on E, cell by cell, that makes the quadrature of a singular E exact in the mean.
    """

    modulus: Modulus
    nu: Any
    depth: DepthMap
    s: Any
    h: Any
    correction: Any = 1.0

    @property
    def young(self):
        """E as it is integrated over the cells."""
        return self.correction * self.modulus.young(self.depth.y(self.s))

    def stress(self, u, pi):
        """Stress (2, 2) of the field ``u`` in the cells."""
        return stress(self.young * self.depth.gradient(u, self.s), self.nu, pi)

    @property
    def surface_modulus(self):
        """Plane-strain modulus E/(1 - nu²) of the surface cells, per mesh depth."""
        return self.modulus.surface_moduli(self.h, self.depth)[1] / (1.0 - self.nu**2)


def stress(modulus_times_gradient, nu, pi=None):
    """Plane-strain stress (2, 2) from ``E grad(u)``:  sigma = lambda tr(eps) I + 2 G eps,  or  pi I + 2 G eps.

    Taking the product rather than the gradient lets the surface, where ``E`` alone has no finite
    value, use the same law. Dimensionless; ``-1 < nu < 1/2``, with ``pi`` also 1/2.
    """
    strain = ufl.sym(modulus_times_gradient)
    shear = 1.0 / (2.0 * (1.0 + nu))
    if pi is None:
        pi = nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) * ufl.tr(strain)
    return pi * ufl.Identity(2) + 2.0 * shear * strain


def stretching_stress(young, nu, strain):
    """Stress (2, 2) of a uniform strain along x under a free surface:  sigma_xx = E eps/(1 - nu²) alone, [X7]."""
    return ufl.as_matrix([[young * strain / (1.0 - nu**2), 0.0], [0.0, 0.0]])


def virtual_work(solid: Solid, u, v, pi):
    """Integrand of  ∫ sigma(u) : eps(v) dx dy  on the ``(x, s)`` mesh."""
    depth, s = solid.depth, solid.s
    return ufl.inner(solid.stress(u, pi), ufl.sym(depth.gradient(v, s))) * depth.stretch(s)


def dilatation(solid: Solid, u, pi, r):
    """Integrand of  ∫ (div u - pi/lambda) r dx dy:  what makes ``pi`` the mean stress; div u = 0 at nu = 1/2."""
    nu, depth, s = solid.nu, solid.depth, solid.s
    flexibility = (1.0 + nu) * (1.0 - 2.0 * nu) / nu / solid.young
    return (ufl.tr(depth.gradient(u, s)) - flexibility * pi) * r * depth.stretch(s)


def surface_traction(solid: Solid, u, pi):
    """Traction ``t = sigma n`` (2,) that the field ``u`` exerts on the surface cells.

    The body lies below ``y = 0`` and the outward normal is ``(0, -1)``: ``t[0]`` is the tangential
    traction along +x, ``t[1]`` the pressure into the body.
    """
    along, into = solid.modulus.surface_moduli(solid.h, solid.depth)
    weights = ufl.as_matrix([[along, 0.0], [0.0, into]])
    sigma = stress(ufl.dot(ufl.grad(u), weights), solid.nu, pi)
    return ufl.as_vector([-sigma[0, 1], -sigma[1, 1]])
