"""Two graded bodies with the same exponent k in contact: the sums in equation (2)."""

from dataclasses import dataclass

from .material import GradedHalfPlane


@dataclass(frozen=True)
class GradedPair:
    """Takes the place of a half-plane in closed forms without coupling; R is then that of the relative curvature.

    Different exponents k raise ValueError. Normal and tangential problems decouple exactly if both
    bodies are alike or both have the Holl ratio.
    """

    first: GradedHalfPlane
    second: GradedHalfPlane

    def __post_init__(self):
        if self.first.k != self.second.k:
            raise ValueError(
                f"k = {self.first.k!r} and k = {self.second.k!r}: "
                "both bodies must have the same exponent k"
            )

    @property
    def k(self):
        """Common exponent of (1)."""
        return self.first.k

    @property
    def normal_compliance(self):
        """Sum of (b_i k) y0_i^k / E0_i [length^k / stress], (2)."""
        return self.first.normal_compliance + self.second.normal_compliance

    @property
    def tangential_compliance(self):
        """Sum of (g_i k) y0_i^k / E0_i [length^k / stress], (2)."""
        return self.first.tangential_compliance + self.second.tangential_compliance

    @property
    def homogeneous_compliance(self):
        """Sum of (1-nu_i²)/E0_i [1/stress]."""
        return self.first.homogeneous_compliance + self.second.homogeneous_compliance

    @property
    def alpha(self):
        """Ratio of tangential to normal compliance, (37) with the sums of (2)."""
        return self.tangential_compliance / self.normal_compliance
