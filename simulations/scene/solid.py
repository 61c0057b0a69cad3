"""The solid of a scene: its closed-form contact, its modulus in the forms, and its kernel for the half-plane solver."""

from functools import partial
from math import exp, inf, log

from scipy.optimize import brentq

from analytic import GradedHalfPlane, LayeredKernel, normal_contact
from forms import modulus as forms

from .indenter import Shape
from .tables import AnySolid, ExponentialCoating, Homogeneous, PowerLaw, PowerLawCoating, Tabulated

KERNEL_FROM, KERNEL_TO = 1e-4, 8.0  # distances, over the half-width, between which a kernel is wanted


def material(solid: AnySolid, grading: bool) -> AnySolid:
    """The solid, homogeneous where grading is switched off."""
    return solid if grading else Homogeneous(E0=solid.E0, nu=solid.nu)


def is_power_law(solid: AnySolid) -> bool:
    """True where (1) holds at every depth, with k = 0 too."""
    return isinstance(solid, (PowerLaw, Homogeneous))


def is_decoupled(solid: AnySolid) -> bool:
    """True for a power law at the Holl ratio, where normal and tangential problem do not see each other."""
    return is_power_law(solid) and abs(solid.nu * (2.0 + getattr(solid, "k", 0.0)) - 1.0) < 1e-9


def is_constant(solid: AnySolid) -> bool:
    """True where E is the same at every depth."""
    moduli = _tabulated(solid) or [getattr(solid, "E_substrate", solid.E0)]
    return getattr(solid, "k", 0.0) == 0 and all(E == solid.E0 for E in moduli)


def _tabulated(solid):
    return [E for _, E in solid.points] if isinstance(solid, Tabulated) else []


def half_plane(solid: AnySolid) -> GradedHalfPlane:
    """The half-plane of (1); for a coating, the one that it is near the surface."""
    y0 = getattr(solid, "y0", None) or 1.0
    return GradedHalfPlane(E0=solid.E0, nu=solid.nu, k=getattr(solid, "k", 0.0), y0=y0)


def modulus_at(solid: AnySolid, y: float) -> float:
    """E at depth y > 0, Pa."""
    return float(modulus(solid, 1.0, 1.0).young(y))


def homogeneous_half_width(E: float, nu: float, shape: Shape, P: float) -> float:
    """The contact half-width on a homogeneous half-plane of modulus E (57), m."""
    return normal_contact(GradedHalfPlane(E, nu, 0.0, 1.0), shape.analytic(), P).a


def equivalent_half_width(solid: AnySolid, shape: Shape, P: float) -> float:
    """Half-width a of the contact on a homogeneous half-plane whose modulus is E(a), m."""
    homogeneous = partial(homogeneous_half_width, nu=solid.nu, shape=shape, P=P)
    guess = homogeneous(solid.E0)
    ends = [homogeneous(E) for E in _tabulated(solid) or [modulus_at(solid, y) for y in (1e-6 * guess, 1e6 * guess)]]
    low, high = min(ends) * (1 - 1e-9), max(ends) * (1 + 1e-9)
    if high - shape.flat < 1e-6 * high:
        return high

    def excess(t):
        return exp(t) - homogeneous(modulus_at(solid, exp(t)))

    return exp(brentq(excess, log(low), log(high), xtol=1e-6))


def modulus(solid: AnySolid, length: float, stress: float) -> forms.Modulus:
    """E(y) of the forms with depth in units of ``length`` and E in units of ``stress``."""
    E0 = solid.E0 / stress
    if isinstance(solid, Homogeneous):
        return forms.PowerLaw.of(0.0, E0)
    if isinstance(solid, Tabulated):
        return forms.Tabulated(*zip(*((y / length, E / stress) for y, E in solid.points), strict=True))
    thickness = inf if isinstance(solid, PowerLaw) else _resolved(solid.thickness) / length
    if isinstance(solid, (PowerLaw, PowerLawCoating)):
        return forms.PowerLaw.of(solid.k, E0 * (length / _resolved(solid.y0)) ** solid.k, thickness)
    exponential = isinstance(solid, ExponentialCoating)
    return forms.Coating(E0, solid.E_substrate / stress, thickness, exponential)


def _resolved(length: float | None) -> float:
    """A length that every solid of a Scene has in m."""
    if length is None:
        raise ValueError("the solid's lengths are multiples of a0: only a Scene has them in m")
    return length


def layered_kernel(law: forms.Modulus, solid: GradedHalfPlane) -> LayeredKernel:
    """What the half-plane solver takes for a coated solid, in scaled units; ``solid`` is that of the surface."""
    nearest = law.kink_depths[0]
    return LayeredKernel(law.young, solid, law.thickness, KERNEL_FROM * min(1.0, nearest), KERNEL_TO, nearest)
