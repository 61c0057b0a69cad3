"""Scaled inside, SI outside: the one place where units enter and leave.

Lengths are divided by the contact half-width ``a``, stresses by ``P/a`` and displacements by ``P/E(a)``, where
``E(a)`` is the modulus at depth ``a``: inside, a = 1, P = 1 and E(1) = 1.
"""

from dataclasses import dataclass
from functools import cached_property

from analytic import CylinderContact, GradedHalfPlane, LayeredKernel, ProfileContact, normal_contact
from forms.modulus import Modulus

from .indenter import Shape
from .scene import Scene
from .solid import layered_kernel, modulus, modulus_at


@dataclass(frozen=True)
class Scales:
    """SI value of each dimensionless unit."""

    length: float  # m
    displacement: float  # m
    stress: float  # Pa

    @classmethod
    def of(cls, scene: Scene) -> "Scales":
        """The scales of a scene."""
        a = scene.half_width
        return cls(length=a, displacement=scene.P / modulus_at(scene.material, a), stress=scene.P / a)

    @property
    def modulus(self) -> float:
        """Young's modulus, Pa."""
        return self.stress * self.length / self.displacement

    @property
    def line_load(self) -> float:
        """Line load, N/m."""
        return self.stress * self.length

    @property
    def energy(self) -> float:
        """Energy per unit thickness, J/m."""
        return self.line_load * self.displacement


@dataclass(frozen=True)
class Scaled:
    """What a scene is in scaled units.

    solid: the half-plane of (1), for a coating the one that it is near the surface; contact: the closed form
    of the frictionless contact, None for a coating.
    """

    scales: Scales
    modulus: Modulus
    solid: GradedHalfPlane
    indenter: Shape
    contact: CylinderContact | ProfileContact | None

    @classmethod
    def of(cls, scene: Scene) -> "Scaled":
        """The scaled scene."""
        scales = Scales.of(scene)
        law = modulus(scene.material, scales.length, scales.modulus)
        solid = GradedHalfPlane(E0=law.E0, nu=scene.solid.nu, k=scene.k, y0=1.0)
        indenter = scene.shape.scaled(scales.length, scales.displacement)
        contact = normal_contact(solid, indenter.analytic(), 1.0) if scene.is_power_law else None
        return cls(scales, law, solid, indenter, contact)

    def elastic_compliance(self, scene: Scene) -> float:
        """Compliance of elastic slip: ``effects.elastic_slip`` over the friction mu P/(2a) of the mean pressure; 0
        without it.
        """
        if not scene.friction:
            return 0.0
        return 2.0 * (scene.effects.elastic_slip or 0.0) / self.scales.displacement / scene.mu

    @cached_property
    def kernel(self) -> GradedHalfPlane | LayeredKernel:
        """What the half-plane solver takes for the solid; a layered one is costly, and made once."""
        return self.solid if self.contact is not None else layered_kernel(self.modulus, self.solid)
