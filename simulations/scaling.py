"""Scaled inside, SI outside: the one place where units enter and leave.

Lengths are divided by the contact half-width ``a``, displacements by ``a^2/R`` and stresses by ``E(a) a/R``, where
``E(a)`` is the modulus at depth ``a``. What is left of a scene is k, nu, mu and Q_A/(mu P).
"""

from dataclasses import dataclass

from analytic import GradedHalfPlane

from .scene import Scene


@dataclass(frozen=True)
class Scales:
    """SI value of each dimensionless unit."""

    length: float  # m
    displacement: float  # m
    stress: float  # Pa

    @classmethod
    def of(cls, scene: Scene) -> "Scales":
        """The scales of a scene."""
        a, R = scene.contact.a, scene["indenter.R"]
        modulus = scene["solid.E0"] * (a / scene["solid.y0"]) ** scene["solid.k"]
        return cls(length=a, displacement=a * a / R, stress=modulus * a / R)

    @property
    def line_load(self) -> float:
        """Line load, N/m."""
        return self.stress * self.length

    @property
    def energy(self) -> float:
        """Energy per unit thickness, J/m."""
        return self.line_load * self.displacement


def scaled_solid(scene: Scene) -> GradedHalfPlane:
    """The half-plane in these units: E = y^k."""
    return GradedHalfPlane(E0=1.0, nu=scene["solid.nu"], k=scene["solid.k"], y0=1.0)
