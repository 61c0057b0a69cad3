"""The solid of a scene: its closed-form contact, its modulus in the forms, and its kernel for the half-plane solver."""

from __future__ import annotations

from math import exp, inf, log
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from analytic import CylinderContact, GradedHalfPlane, LayeredKernel, ProfileContact
from forms.modulus import Coating, Modulus, PowerLaw

from .indenter import Indenter

if TYPE_CHECKING:
    from .scene import Scene

SMALLEST, LARGEST = 1e-4, 8.0  # distances, over the half-width, between which a kernel is wanted


def normal_contact(solid: GradedHalfPlane, indenter: Indenter, P: float) -> CylinderContact | ProfileContact:
    """Closed form of the frictionless contact under the line load ``P``, in consistent units."""
    profile = indenter.analytic()
    if getattr(profile, "m", None) == 2:
        return CylinderContact(solid, R=0.5 / profile.A, P=P)
    return ProfileContact.from_load(solid, profile, P, _wide_enough(solid, profile, P))


def _wide_enough(solid, profile, P):
    """A half-width that carries at least ``P``; ValueError where the profile ends before."""
    width, growth, before = 1e-9 * (profile.flat or 1.0), 4.0, 0.0
    while growth > 1 + 1e-6:
        with np.errstate(all="ignore"):
            load = ProfileContact(solid, profile, profile.flat + growth * width).P
        if load >= P:
            return profile.flat + growth * width
        if load < before:
            raise ValueError(f"the indenter's profile is not convex up to x = {profile.flat + growth * width:.3g}")
        if load < P:
            width, before = width * growth, load
        else:  # not a number: beyond the end of the profile
            growth **= 0.5
    raise ValueError(f"the indenter's profile ends at x = {profile.flat + width:.3g}, before it carries P")


def modulus_at(scene: Scene, y: float) -> float:
    """E at depth y > 0, Pa."""
    return float(modulus(scene, 1.0, 1.0).young(y))


def equivalent_half_width(scene: Scene) -> float:
    """Half-width a of the contact on a homogeneous half-plane whose modulus is E(a), m."""

    def homogeneous(E):
        return normal_contact(GradedHalfPlane(E, scene["solid.nu"], 0.0, 1.0), scene.indenter, scene.P).a

    flat = scene.indenter.flat
    guess = homogeneous(scene["solid.E0"])
    ends = [homogeneous(modulus_at(scene, y)) for y in (1e-6 * guess, 1e6 * guess)]
    low, high = min(ends) * (1 - 1e-9), max(ends) * (1 + 1e-9)
    if high - flat < 1e-6 * high:
        return high

    def excess(t):
        return exp(t) - homogeneous(modulus_at(scene, exp(t)))

    return exp(brentq(excess, log(low), log(high), xtol=1e-6))


def modulus(scene: Scene, length: float, stress: float) -> Modulus:
    """E(y) of the forms with depth in units of ``length`` and E in units of ``stress``."""
    E0, kind = scene["solid.E0"] / stress, scene["solid.modulus"]
    thickness = scene.values.get("solid.thickness", inf) / length
    if scene.k == 0 and scene.is_power_law:
        return PowerLaw.of(0.0, E0)
    if kind in ("power law", "power-law coating"):
        return PowerLaw.of(scene.k, E0 * (length / scene["solid.y0"]) ** scene.k, thickness)
    substrate = scene["solid.E_substrate"] / stress
    return Coating(E0, substrate, thickness, kind == "exponential")


def layered_kernel(law: Modulus, solid: GradedHalfPlane) -> LayeredKernel:
    """What the half-plane solver takes for a coated solid, in scaled units; ``solid`` is that of the surface."""
    return LayeredKernel(law.young, solid, law.thickness, SMALLEST * min(1.0, law.thickness), LARGEST)
