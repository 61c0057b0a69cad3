"""The coupled contact problem without units, and its state after the normal stage."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..cylinder import CylinderContact
from ..half_plane.linear import ContactNotConverged
from ..half_plane.surface_kernel import PowerLawKernel
from ..normal import normal_contact
from .exponents import edge_exponents, hilbert_ratio
from .panels import Panels, graded
from .tractions import Interpolated

LEVELS, RATIO = 15, 0.4  # of the panels on which the pressure of the normal stage is integrated or interpolated


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

    def exponents(self, friction):
        """``edge_exponents``."""
        return edge_exponents(self.k, self.bk, self.d, friction)

    @property
    def tau(self):
        """O is tau times the Hilbert transform of R."""
        return hilbert_ratio(self.k)


class NormalStage:
    """Frictionless contact under P alone, in the units of ``Problem``: the state from which Q starts.

    problem: the tangential problem that follows; contact: edges; breaks: where tractions are not smooth, nowhere; Q,
    delta_x, delta_y: load and displacements.

    Raises ContactNotConverged for a profile that is no even power.
    """

    contact = (-1.0, 1.0)
    breaks = np.empty(0)
    Q = delta_x = 0.0

    def __init__(self, solid, profile, P, mu, coupling, order):
        self.solid, self.P = solid, P
        if getattr(profile, "m", 1.0) % 2:
            raise ContactNotConverged("the profile is no polynomial: its power has to be even")
        self._closed = normal_contact(solid, profile, P)
        self.a = self._closed.a
        self._cylinder = isinstance(self._closed, CylinderContact)
        a = self.a
        unit = P * (solid.y0 / a) ** solid.k / solid.E0
        slope = profile.A * profile.m * a**profile.m / unit
        self.problem = Problem(
            k=solid.k,
            bk=solid.bk,
            gk=solid.gk,
            d=PowerLawKernel(solid).d if coupling else 0.0,
            mu=mu,
            height=lambda x: profile.height(a * x) / unit,
            slope=lambda x: slope * x ** (profile.m - 1),
            degree=round(profile.m),
            order=order,
        )

    @cached_property
    def _smooth(self):
        """The pressure over 0 < x < 1, without its root at the edge."""
        panels = Panels.between(graded(0.0, 1.0, 0, LEVELS, RATIO))
        x = panels.nodes
        return Interpolated(panels, (self._closed.pressure(self.a * x) * self.a / self.P / self._root(x))[None])

    def _root(self, x):
        return np.maximum((1 - x) * (1 + x), 0.0) ** ((1 + self.solid.k) / 2)

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        if self._cylinder:
            p = self._closed.pressure(self.a * x) * self.a / self.P
        else:
            r = np.minimum(np.abs(x), 1.0)
            p = self._smooth(r)[0] * self._root(r)
        return np.stack([p, np.zeros_like(p)])

    @cached_property
    def delta_y(self):
        """Displacement of the profile's tip."""
        panels, p = self._sources
        kernel = panels.matrices(np.zeros(1), self.solid.k)[0]
        return float(self.solid.bk * (kernel @ p)[0])

    @cached_property
    def _sources(self):
        """Panels over the contact, and the pressure at their nodes."""
        panels = Panels.between(graded(*self.contact, LEVELS, LEVELS, RATIO))
        return panels, self.tractions(panels.nodes)[0]

    def displacements(self, x):
        """u_x and u_y - delta_y at x, shape (2, n)."""
        panels, p = self._sources
        even, odd = panels.matrices(x, self.problem.k)
        u_x, u_y = self.problem.displacements(even @ p, odd @ p, 0.0, 0.0)
        return np.stack([u_x, u_y - self.delta_y])

    @cached_property
    def _moved(self):
        panels = self._sources[0]
        return Interpolated(panels, (panels.matrices(panels.nodes, self.solid.k)[1] @ self._sources[1])[None])

    def moved(self, x):
        """u_x at x in the contact, interpolated."""
        return self.problem.d * self._moved(x)[0]
