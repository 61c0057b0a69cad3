"""Young's modulus over depth, and what is left of it on the surface.

All moduli are dimensionless: depth is measured in contact half-widths ``a`` and the modulus in ``E(a)``, so that the
power law (1) is ``E = y^k`` and carries no other constant. A modulus works on numbers, numpy arrays and UFL expressions
alike; ``with_parameters`` puts UFL constants in place of its numbers, so that one compiled form serves them all.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any, ClassVar, Protocol

import numpy as np
import ufl
from ufl.core.expr import Expr

from .depth_map import DepthMap


class Modulus(Protocol):
    """What the forms and the mesh ask of E(y), a frozen dataclass. ``thickness``: depth below which E is constant.

    parameters: names of the fields that are numbers or tuples of them, or UFL constants in their place.
    """

    parameters: ClassVar[tuple[str, ...]]

    @property
    def thickness(self) -> Any:
        """Depth."""

    @property
    def kink_depths(self) -> tuple:
        """Depths at which E has another slope above than below."""

    @property
    def k(self) -> Any:
        """Exponent of the power law E0 y^k that E follows on the surface."""

    @property
    def E0(self) -> Any:
        """E0 of the same."""

    @property
    def is_singular(self) -> bool:
        """True where E is infinite on the surface; it then has ``layer_mean(top, bottom)`` as the power law does."""

    def young(self, y):
        """Young's modulus at depth ``y``."""

    def depth_map(self) -> DepthMap:
        """The depth coordinate in which the displacement is smooth."""

    def surface_moduli(self, h, depth: DepthMap):
        """Finite surface values ``(along, into)`` of the modulus for a first cell of height ``h``.

        On the surface the traction takes ``E du/dx = along * du/dx`` and ``E du/dy = into * du/ds``.
        """


def with_parameters(modulus, make: Callable[[float], Expr]):
    """The same modulus with ``make(value)`` in place of every finite one of its ``parameters``."""

    def made(value):
        if isinstance(value, tuple):
            return tuple(map(made, value))
        return make(value) if isfinite(value) else value

    return replace(modulus, **{name: made(getattr(modulus, name)) for name in modulus.parameters})


@dataclass(frozen=True)
class PowerLaw:
    """``E = E0 y^k`` down to ``thickness`` and constant below, -1 < k < 1; equation (1) where that is infinite.

    sign: of k. It decides which terms there are; the value of k is a number in them.
    """

    k: Any
    sign: int
    E0: Any = 1.0
    thickness: Any = inf
    parameters: ClassVar[tuple[str, ...]] = ("k", "E0", "thickness")

    @classmethod
    def of(cls, k: float, E0: float = 1.0, thickness: float = inf) -> "PowerLaw":
        """The power law of exponent ``k``."""
        return cls(k, (k > 0) - (k < 0), E0, thickness)

    @property
    def is_singular(self) -> bool:
        """True where E is infinite on the surface."""
        return self.sign < 0

    @property
    def kink_depths(self):
        """The end of the power law."""
        return (self.thickness,)

    def young(self, y):
        """Young's modulus at depth ``y``; constant for k = 0."""
        if self.sign == 0:
            return self.E0
        return self.E0 * up_to(self.thickness, y) ** self.k

    def depth_map(self) -> DepthMap:
        """For k > 0 the coordinate s = y^(1-k), in which the displacement is smooth; y itself for k <= 0."""
        return DepthMap(1.0 / (1.0 - self.k), False) if self.sign > 0 else DepthMap()

    def layer_mean(self, top, bottom):
        """Exact mean of E over depths ``top`` to ``bottom`` (numpy arrays), top < bottom."""
        power, h = 1.0 + self.k, self.thickness
        graded = (up_to(h, bottom) ** power - up_to(h, top) ** power) / power
        below = (bottom - up_to(h, bottom)) - (top - up_to(h, top))
        constant = h**self.k if np.isfinite(h) else 0.0
        return self.E0 * (graded + constant * below) / (bottom - top)

    def surface_moduli(self, h, depth: DepthMap):
        """Finite surface values ``(along, into)`` for a first cell of height ``h`` in the mesh depth.

        On the surface ``E`` is zero or infinite, so that the exact mean over the cell stands for it. In the smooth
        depth coordinate ``E/(dy/ds)`` is the constant ``1 - k``; without it, the cell mean again.
        """
        k = self.k
        if self.sign == 0:
            return self.E0, self.E0
        if depth.is_identity:
            mean = self.E0 * h**k / (1.0 + k)
            return mean, mean
        return self.E0 * (1.0 - k) * h ** (k / (1.0 - k)), self.E0 * (1.0 - k)


@dataclass(frozen=True)
class Coating:
    """E from ``E0`` to ``substrate`` over ``thickness``, constant below; linear, or exponential where asked."""

    E0: Any
    substrate: Any
    thickness: Any
    exponential: bool = False
    k: ClassVar = 0.0
    is_singular: ClassVar = False
    parameters: ClassVar[tuple[str, ...]] = ("E0", "substrate", "thickness")

    @property
    def kink_depths(self):
        """The end of the coating."""
        return (self.thickness,)

    def young(self, y):
        """Young's modulus at depth ``y``."""
        share = up_to(self.thickness, y) / self.thickness
        if self.exponential:
            return self.E0 * (self.substrate / self.E0) ** share
        return self.E0 + (self.substrate - self.E0) * share

    def depth_map(self) -> DepthMap:
        """The depth itself: E is finite on the surface."""
        return DepthMap()

    def surface_moduli(self, h, depth: DepthMap):
        """E on the surface, twice."""
        return self.E0, self.E0


@dataclass(frozen=True)
class Tabulated:
    """E linear between ``values`` at ``depths``, of which the first is 0; constant below the last."""

    depths: tuple
    values: tuple
    k: ClassVar = 0.0
    is_singular: ClassVar = False
    parameters: ClassVar[tuple[str, ...]] = ("depths", "values")

    @property
    def thickness(self):
        """The last depth."""
        return self.depths[-1]

    @property
    def kink_depths(self):
        """All depths below the surface."""
        return self.depths[1:]

    @property
    def E0(self):
        """E on the surface."""
        return self.values[0]

    def young(self, y):
        """Young's modulus at depth ``y``."""
        if not isinstance(y, Expr):
            return np.interp(y, self.depths, self.values)
        E = self.E0
        for i in range(1, len(self.depths)):
            (top, bottom), (above, below) = self.depths[i - 1 : i + 1], self.values[i - 1 : i + 1]
            E = E + (below - above) / (bottom - top) * (up_to(bottom, y) - up_to(top, y))
        return E

    def depth_map(self) -> DepthMap:
        """The depth itself: E is finite on the surface."""
        return DepthMap()

    def surface_moduli(self, h, depth: DepthMap):
        """E on the surface, twice."""
        return self.E0, self.E0


def up_to(limit, y):
    """min(y, limit)."""
    if isinstance(y, Expr):
        return y if limit == inf else ufl.min_value(y, limit)
    return np.minimum(y, limit)
