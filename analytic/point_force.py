"""Displacement field of a line force on the power-law graded half-plane, beyond the paper [X6].

The stress is radial, sigma_rr = F(theta)/r. With the polar angle theta from the depth axis towards +x,

    u_r = r^(-k) g(theta),   u_theta = r^(-k) g'(theta)/(1+k),   g'' = -beta^2 g,

where g is a multiple of cos(beta theta) for a normal and of sin(beta theta) for a tangential force. On the
surface this is kernel (2) with the coupling [X6]; far from any contact it is the field of the loads.
"""

import numpy as np

from .material import GradedHalfPlane


def point_force_displacement(solid: GradedHalfPlane, x, y, P=0.0, Q=0.0, fixed_depth=None):
    """Displacement ``(2, ...)`` at ``(x, y)``, y >= 0, of the line forces P along +y and Q along +x at the origin.

    For k <= 0 displacements do not decay and hold only up to a rigid translation: with the one taken the
    field vanishes on the axis at ``y = fixed_depth``. Without ``fixed_depth`` it vanishes at infinity;
    ValueError for k <= 0, where no such field exists.
    """
    k, nu, beta = solid.k, solid.nu, solid.beta
    if fixed_depth is None and k <= 0:
        raise ValueError(f"k = {k!r}: displacements vanish at infinity only for 0 < k < 1; give fixed_depth")
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    r, theta = np.hypot(x, y), np.arctan2(x, y)
    sin, cos, decay = np.sin(theta), np.cos(theta), r ** -k

    # Everything is divided by k; each difference below is written so that k = 0 is an ordinary point.
    slope = (1 - (2 + k) * nu) / ((1 - nu) * (1 + beta))  # (beta - 1)/k
    bend = slope * theta * np.sinc(k * slope * theta / (2 * np.pi))
    cos_difference = -bend * np.sin((1 + beta) * theta / 2)  # (cos(beta theta) - cos(theta))/k
    sin_difference = bend * np.cos((1 + beta) * theta / 2)
    if fixed_depth is None:
        radial = decay / k
    else:  # (r^-k - D^-k)/k
        t = np.log(r / fixed_depth)
        radial = fixed_depth ** -k * np.expm1(-k * t) / k if k else -t

    even = decay * cos_difference + radial * cos
    odd_normal = decay * (beta * sin_difference + (slope - 1) * sin) / (1 + k) + radial * sin
    odd_tangential = decay * ((1 + k) * sin_difference + (1 - slope) * sin) / beta + radial * sin
    u_r, u_theta = P * even + Q * odd_tangential, -P * odd_normal + Q * even
    scale = (1 - nu) * (1 + nu) * solid.C * solid.y0**k / solid.E0
    return scale * np.stack([u_r * sin + u_theta * cos, u_r * cos - u_theta * sin])


def point_force_stress(solid: GradedHalfPlane, x, y, P=0.0, Q=0.0):
    """Stress xx, yy, xy ``(3, ...)`` at ``(x, y)``, y > 0, of the line forces P along +y and Q along +x at the origin.

    sigma_rr = -(C/r) cos^k(theta) [P cos(beta theta) + Q (1+k)/beta sin(beta theta)], which balances P and Q on
    every half-circle; C and beta of (4).
    """
    k, beta = solid.k, solid.beta
    r, theta = np.hypot(x, y), np.arctan2(x, y)
    sin, cos = np.sin(theta), np.cos(theta)
    load = P * np.cos(beta * theta) + Q * ((1 + k) / beta) * np.sin(beta * theta)
    radial = -solid.C / r * cos**k * load
    return radial * np.stack([sin**2, cos**2, sin * cos])
