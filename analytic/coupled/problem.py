"""The coupled contact problem without units."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from ..checks import ContactNotConverged

LONGEST = 2.0  # panel of tractions, over the depth of the layers,
LONGEST_WITH_KINKS = 0.1  # and over a where kernels have kinks: beside these they are like z² ln|z|
TERMS, TERMS_WITH_KINKS = 6, 9  # polynomials that carry what layers add to u_y, over the order of the basis


@dataclass(frozen=True)
class Problem:
    """Data without units: lengths over a, tractions over P/a, loads over P, displacements over P y0^k/(E0 a^k).

    bk, gk, d: factors of the kernels; mu: friction coefficient; height, slope: profile at x and its derivative,
    a polynomial of this degree; order: of the basis. regular: N, T and D of the layers below a power-law surface, less
    those of the power law and kinks, at distances z >= 0, shape (3, *z.shape); None without layers. kinks: factors (3,)
    of |z| in N and T and of z ln|z| in D, None but for k = 0. longest: panels of tractions that these kernels bear.
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
    regular: Callable | None = None
    kinks: np.ndarray | None = None
    longest: float = inf

    @property
    def terms(self):
        """Number of polynomials that carry what the layers add to u_y; 0 without layers."""
        if not self.regular:
            return 0
        return self.order * (TERMS if self.kinks is None else TERMS_WITH_KINKS)

    def displacements(self, even_p, odd_p, even_q, odd_q):
        """u_x and u_y from the integrals of R and O over p and q, [X6]."""
        return self.gk * even_q + self.d * odd_p, self.bk * even_p - self.d * odd_q

    def of_layers(self, x, nodes):
        """The regular kernels N, T and D at x from line forces at nodes, shape (3, len(x), len(nodes))."""
        assert self.regular
        z = x[:, None] - nodes
        result = self.regular(np.abs(z))
        result[2] *= np.sign(z)
        return result


def problem_of(body, profile, P, mu, coupling, order, a):
    """The problem under P with the half-width ``a``; ContactNotConverged for a profile that is no even power.

    body: a GradedHalfPlane or a LayeredKernel.
    """
    solid = surface_of(body)
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
        **({} if body is solid else _layers(body, a, P / unit, coupling)),
    )


def surface_of(body):
    """The half-plane whose power law the ``body`` follows at its surface."""
    return getattr(body, "surface", body)


def _layers(body, a, factor, coupling):
    """Fields of ``Problem`` for a LayeredKernel, whose values times the factor have no unit."""
    kinks = a * factor * np.array([1, 1, coupling]) * body.kinks

    def regular(z):
        kernels = np.multiply(body.regular(a * z), factor, order="C")  # products of matrices are ten times as fast then
        kernels[2] *= coupling
        kernels[2] += kinks[2] * np.log(a) * z  # az ln(az) = a (z ln z + z ln a)
        return kernels

    has_kinks = bool(kinks.any())
    longest = min(LONGEST * body.first_layer / a, LONGEST_WITH_KINKS if has_kinks else inf)
    return {"regular": regular, "kinks": kinks if has_kinks else None, "longest": longest}
