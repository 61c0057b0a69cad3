"""Points of the maps: one fretting loop each, with what the depth of the grading changes known in advance.

A power law and a power profile f ~ |x|^m have no length of their own. y0 only sets the half-width, a ~ y0^(k/(m+k)),
and all lengths go with it, slips and energies with a^m: with or without coupling one loop serves every y0.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import minimize_scalar

from analytic import GradedHalfPlane, PowerProfile, ProfileContact, normal_contact

from ..paper.setting import load
from .loops import simulate


@dataclass(frozen=True)
class Point:
    """Parameters of a loop. amplitude: Q_A/(mu P); m: exponent of the profile; y0 = a0."""

    k: float
    amplitude: float
    m: float
    nu: float
    mu: float


@dataclass(frozen=True)
class Energies:
    """Of one loop at y0 = a0: energy over mu² P a0²/(2R), peak density over mu² P a0/R, a0²/R = 4(1-nu²)P/(pi E0).

    These units are the same for every profile: they hold the load and E0 alone.
    """

    energy: float
    density: float


def depth_factors(k: float, m: float, y0_over_a0) -> tuple[np.ndarray, np.ndarray]:
    """By what (energy, peak density) at y0 = a0 are to be multiplied at another depth, any shape."""
    widening = np.asarray(y0_over_a0, dtype=float) ** (k / (m + k))
    return widening**m, widening ** (m - 1)


@cache
def profile(m: float, nu: float) -> PowerProfile:
    """The profile A |x|^m whose homogeneous half-width under the same load is a0 = 1 too; A = 1/2 for m = 2."""
    homogeneous = GradedHalfPlane(E0=1.0, nu=nu, k=0.0, y0=1.0)
    return PowerProfile(load(nu) / ProfileContact(homogeneous, PowerProfile(1.0, m), 1.0).P, m)


def by_theory(point: Point) -> Energies:
    """From the closed forms (51), (52), which neglect coupling."""
    solid = GradedHalfPlane(E0=1.0, nu=point.nu, k=point.k, y0=1.0)
    contact = normal_contact(solid, profile(point.m, point.nu), load(point.nu))
    loop = contact.fretting(point.mu, z=1 - point.amplitude)
    # the slip zone may be thin: its share of the half-width is what is sought
    c, width = loop.c, loop.a - loop.c

    def negative_density(t):
        return -float(loop.energy_density(c + t * width))

    peak = minimize_scalar(negative_density, (0.0, 1.0), (0.0, 1.0), method="bounded", options={"xatol": 1e-4})
    return _normalised(point, loop.dissipated_energy, -peak.fun)


def by_simulation(point: Point) -> Energies:
    """From the second cycle of a mesh-free loop with coupling; ContactNotConverged where that fails."""
    solid = GradedHalfPlane(E0=1.0, nu=point.nu, k=point.k, y0=1.0)
    loop = simulate(solid, profile(point.m, point.nu), load(point.nu), point.mu, point.amplitude)
    return _normalised(point, loop.dissipated_energy, loop.peak_density())


def _normalised(point: Point, energy, density) -> Energies:
    unit = point.mu**2 * load(point.nu)
    return Energies(float(energy / (unit / 2)), float(density / unit))
