"""Young's modulus over depth, and what is left of it on the surface.

All moduli are dimensionless: depth is measured in contact half-widths ``a`` and the modulus in
``E(a)``, so that the power law (1) is ``E = y^k`` and carries no other constant.
"""

from dataclasses import dataclass

from .depth import DepthMap


@dataclass(frozen=True)
class PowerLaw:
    """``E(y) = y^k``, -1 < k < 1, equation (1)."""

    k: float

    def young(self, y):
        """Young's modulus at depth ``y``; constant 1 for ``k = 0``."""
        return 1.0 if self.k == 0 else y**self.k

    def depth_map(self) -> DepthMap:
        """The depth coordinate in which the displacement is smooth."""
        return DepthMap.regularising(self.k)

    def layer_mean(self, top, bottom):
        """Exact mean of E over depths ``top`` to ``bottom`` (numpy arrays), top < bottom."""
        power = 1.0 + self.k
        return (bottom**power - top**power) / (power * (bottom - top))

    def surface_moduli(self, h, depth: DepthMap):
        """Finite surface values ``(along, into)`` of the modulus for a first cell of height ``h``.

        On the surface ``E`` is zero or infinite, so the traction takes ``E du/dx = along * du/dx``
        with the exact mean of ``E`` over the cell, and ``E du/dy = into * du/ds``. In the smooth
        depth coordinate ``E/(dy/ds)`` is the constant ``1 - k``; without it, the cell mean again.
        """
        k = self.k
        if k == 0:
            return 1.0, 1.0
        if depth.is_identity:
            mean = h**k / (1.0 + k)
            return mean, mean
        return (1.0 - k) * h ** (k / (1.0 - k)), 1.0 - k
