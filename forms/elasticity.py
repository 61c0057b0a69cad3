"""Plane-strain linear elasticity of the graded half-plane.

Two forms: in displacements alone, and for nearly or fully incompressible solids in displacements ``u`` and the mean
stress ``pi = lambda div u`` as a field of its own. ``pi`` is None in the first.
"""

import ufl

from .depth_map import DepthMap


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


def virtual_work(u, v, modulus, nu, depth: DepthMap, s, correction=1.0, pi=None):
    """Integrand of  ∫ sigma(u) : eps(v) dx dy  on the ``(x, s)`` mesh.

    correction: factor on E, cell by cell, that makes the quadrature of a singular E exact in the mean.
    """
    young = correction * modulus.young(depth.y(s))
    return ufl.inner(stress(young * depth.gradient(u, s), nu, pi), ufl.sym(depth.gradient(v, s))) * depth.stretch(s)


def dilatation(u, pi, r, modulus, nu, depth: DepthMap, s, correction=1.0):
    """Integrand of  ∫ (div u - pi/lambda) r dx dy:  what makes ``pi`` the mean stress; div u = 0 at nu = 1/2."""
    young = correction * modulus.young(depth.y(s))
    flexibility = (1.0 + nu) * (1.0 - 2.0 * nu) / nu / young
    return (ufl.tr(depth.gradient(u, s)) - flexibility * pi) * r * depth.stretch(s)


def surface_traction(u, modulus, nu, depth: DepthMap, h, pi=None):
    """Traction ``t = sigma n`` (2,) that the field ``u`` exerts on the surface cells of height ``h``.

    The body lies below ``y = 0`` and the outward normal is ``(0, -1)``: ``t[0]`` is the tangential
    traction along +x, ``t[1]`` the pressure into the body.
    """
    along, into = modulus.surface_moduli(h, depth)
    weights = ufl.as_matrix([[along, 0.0], [0.0, into]])
    sigma = stress(ufl.dot(ufl.grad(u), weights), nu, pi)
    return ufl.as_vector([-sigma[0, 1], -sigma[1, 1]])
