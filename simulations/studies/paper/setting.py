"""The paper's contact and its normalisations. The homogeneous half-width a0 is the unit of length."""

from dataclasses import dataclass
from math import pi

from analytic import CylinderContact, GradedHalfPlane

NU = 0.3  # of Figures 4-9: the paper gives none
MU = 0.3  # given nowhere; it drops out of the normalised curves, not of simulations with coupling
EXPONENTS = {"a": -0.5, "b": 0.5}  # of Figures 4-8 by panel
SHARES = (0.2, 0.4, 0.6, 0.8)  # Q/(mu P) of Figures 4-7: four loads, which the paper does not name
DEPTHS = (0.01, 0.1, 1.0, 10.0)  # y0/a0 of Figure 8, likewise
GRADINGS = (-0.5, -0.25, 0.0, 0.25, 0.5)  # k of Figure 9, likewise
AMPLITUDE = 0.9  # Q_A/(mu P) of Figures 10 and 11
STATES = {"A": (1.0, "unloading"), "B": (0.5, "unloading"), "C": (0.0, "unloading")}  # Q/Q_A and branch
STATES |= {"D": (-0.5, "unloading"), "E": (-1.0, "unloading")}


@dataclass(frozen=True)
class Units:
    """What lengths, tractions, slips, energy densities and energies are divided by."""

    length: float
    traction: float
    slip: float
    density: float
    energy: float


def load(nu: float) -> float:
    """P for which the parabola f = x²/2 on a homogeneous half-plane with E0 = 1 has a0 = 1, (57)."""
    return pi / (4 * (1 - nu**2))


def contact(k: float, y0_over_a0: float, nu: float = NU) -> CylinderContact:
    """The cylinder on a half-plane in units in which a0 = R = E0 = 1."""
    solid = GradedHalfPlane(E0=1.0, nu=nu, k=k, y0=y0_over_a0)
    return CylinderContact(solid, R=1.0, P=load(nu))


def homogeneous_units(normal: CylinderContact) -> Units:
    """The figures' units: a0, mu p0 with p0 = 2P/(pi a0), mu a0²/(2R), mu² P a0/R, mu² P a0²/(2R).

    The paper says "normalized"; with these the homogeneous curve of (59) is 1 - z² + 2 z ln z and ends at 1.
    """
    a0, P, R = normal.a0, normal.P, normal.R
    traction, slip = MU * 2 * P / (pi * a0), MU * a0**2 / (2 * R)
    return Units(a0, traction, slip, MU**2 * P * a0 / R, MU**2 * P * a0**2 / (2 * R))


def own_units(normal: CylinderContact) -> Units:
    """Units of the graded contact itself, in which y0 does not matter: a power law has no length of its own.

    a, mu p(0), mu alpha a²/(2R) and the products of these.
    """
    traction = MU * normal.peak_pressure
    slip = MU * normal.solid.alpha * normal.a**2 / (2 * normal.R)
    return Units(normal.a, traction, slip, traction * slip, traction * slip * normal.a)
