"""The coupled contact problem without units."""

from collections.abc import Callable
from dataclasses import dataclass

from ..checks import ContactNotConverged


@dataclass(frozen=True)
class Problem:
    """Data without units: lengths over a, tractions over P/a, loads over P, displacements over P y0^k/(E0 a^k).

    bk, gk, d: factors of the kernels; mu: friction coefficient; height, slope: profile at x and its derivative,
    a polynomial of this degree; order: of the basis.
    """

    k: float
    bk: float
    gk: float
    d: float
    mu: float
    height: Callable
    slope: Callable
    degree: int
    order: int

    def displacements(self, even_p, odd_p, even_q, odd_q):
        """u_x and u_y from the integrals of R and O over p and q, [X6]."""
        return self.gk * even_q + self.d * odd_p, self.bk * even_p - self.d * odd_q


def problem_of(solid, profile, P, mu, coupling, order, a):
    """The problem under P with the half-width ``a``; ContactNotConverged for a profile that is no even power."""
    if getattr(profile, "m", 1.0) % 2:
        raise ContactNotConverged("the profile is no polynomial: its power has to be even")
    unit = P * (solid.y0 / a) ** solid.k / solid.E0
    slope = profile.A * profile.m * a**profile.m / unit
    return Problem(
        k=solid.k,
        bk=solid.bk,
        gk=solid.gk,
        d=solid.d if coupling else 0.0,
        mu=mu,
        height=lambda x: profile.height(a * x) / unit,
        slope=lambda x: slope * x ** (profile.m - 1),
        degree=round(profile.m),
        order=order,
    )
