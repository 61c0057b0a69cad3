"""The coupled contact problem without units, and its state after the normal stage."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..cylinder import CylinderContact
from ..half_plane.linear import ContactNotConverged
from ..half_plane.surface_kernel import PowerLawKernel
from ..normal import ProfileContact
from .exponents import edge_exponent, hilbert_ratio
from .panels import GAUSS, Panels, even_kernel, graded
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
        """Exponents with which p ends at x_l and x_r, and friction p - q at c_l and c_r; q = friction p in slip."""
        minus, plus = (edge_exponent(self.k, self.bk, self.d, s * friction) for s in (-1, 1))
        return minus, plus, plus, minus

    @property
    def tau(self):
        """O is tau times the Hilbert transform of R."""
        return hilbert_ratio(self.k)


class NormalStage:
    """Frictionless contact under P alone, in the units of ``Problem``: the state from which Q starts.

    contact: edges; breaks: where tractions are not smooth; Q, delta_x, delta_y: load and displacements.
    """

    contact = (-1.0, 1.0)
    Q = delta_x = 0.0

    def __init__(self, solid, profile, P):
        self.solid, self.P = solid, P
        self.smooth = getattr(profile, "m", None) == 2 or _is_even(getattr(profile, "m", 1.0))
        self._closed = _normal_contact(solid, profile, P)
        self.a = self._closed.a
        flat = getattr(profile, "flat", 0.0) / self.a
        corners = [] if self.smooth else [-flat, flat] if flat else [0.0]
        self.breaks = np.array(corners)
        self._cylinder = isinstance(self._closed, CylinderContact)

    def problem(self, profile, mu, coupling, order):
        """The tangential problem that follows."""
        solid, a = self.solid, self.a
        unit = self.P * (solid.y0 / a) ** solid.k / solid.E0
        d = PowerLawKernel(solid).d if coupling else 0.0
        if not self.smooth:
            raise ContactNotConverged("the profile is no polynomial: its power has to be even")
        slope = profile.A * profile.m * a**profile.m / unit

        return Problem(
            k=solid.k,
            bk=solid.bk,
            gk=solid.gk,
            d=d,
            mu=mu,
            height=lambda x: profile.height(a * x) / unit,
            slope=lambda x: slope * x ** (profile.m - 1),
            degree=round(profile.m),
            order=order,
        )

    @cached_property
    def _sampled(self):
        """Panels over 0 < x < 1 and the pressure at their nodes, without its root at the edge."""
        points = np.unique(np.abs([0.0, *self.breaks, 1.0]))
        low = points[:-1]
        pieces = [graded(a, b, LEVELS * (not self.smooth), LEVELS, RATIO) for a, b in zip(low, points[1:], strict=True)]
        panels = Panels.between(np.unique(np.concatenate(pieces)))
        x = panels.nodes
        return panels, self._closed.pressure(self.a * x) * self.a / self.P / self._root(x)

    def _root(self, x):
        return np.maximum((1 - x) * (1 + x), 0.0) ** ((1 + self.solid.k) / 2)

    def tractions(self, x):
        """p and q at x, shape (2, n)."""
        if self._cylinder:
            p = self._closed.pressure(self.a * x) * self.a / self.P
        else:
            panels, values = self._sampled
            r = np.minimum(np.abs(x), 1.0)
            j = np.clip(np.searchsorted(panels.low, r, side="right") - 1, 0, len(panels.low) - 1)
            at = (r - panels.middle[j]) / panels.half[j]
            p = _interpolated(at, values.reshape(-1, len(GAUSS))[j]) * self._root(r)
        return np.stack([p, np.zeros_like(p)])

    def limit_between(self, friction, low, high, x):
        """Panels between two points, and friction p - q at their nodes."""
        points = np.array([low, *self.breaks[(self.breaks > low) & (self.breaks < high)], high])
        panels = Panels.between(points)
        return panels, friction * self.tractions(panels.nodes)[0]

    @cached_property
    def delta_y(self):
        """Displacement of the profile's tip."""
        points = np.array([-1.0, *self.breaks, 1.0])
        if 0.0 not in points:
            points = np.sort(np.append(points, 0.0))
        pieces = [graded(a, b, LEVELS, LEVELS, RATIO) for a, b in zip(points, points[1:], strict=False)]
        panels = Panels.between(np.unique(np.concatenate(pieces)))
        kernel = panels.matrices(np.zeros(1), self.solid.k)[0]
        return float(self.solid.bk * (kernel @ self.tractions(panels.nodes)[0])[0])

    @cached_property
    def _sources(self):
        points = np.array([-1.0, *self.breaks, 1.0])
        pieces = [graded(a, b, LEVELS, LEVELS, RATIO) for a, b in zip(points, points[1:], strict=False)]
        panels = Panels.between(np.unique(np.concatenate(pieces)))
        return panels, self.tractions(panels.nodes)[0]

    def displacements(self, problem, x):
        """u_x and u_y - delta_y at x, shape (2, n)."""
        panels, p = self._sources
        even, odd = panels.matrices(x, problem.k)
        u_x, u_y = problem.displacements(even @ p, odd @ p, 0.0, 0.0)
        return np.stack([u_x, u_y - self.delta_y])

    @cached_property
    def _moved(self):
        panels = self._sources[0]
        return Interpolated(panels, (panels.matrices(panels.nodes, self.solid.k)[1] @ self._sources[1])[None])

    def moved(self, problem, x):
        """u_x at x in the contact, interpolated."""
        return problem.d * self._moved(x)[0]

    def unit_of_length_shift(self):
        """R(a/y0): the kernels of ``PowerLawKernel`` have y0 for the length that is a here."""
        return float(even_kernel(np.array([self.a / self.solid.y0]), self.solid.k)[0])


def _is_even(power):
    return power == round(power) and round(power) % 2 == 0


def _normal_contact(solid, profile, P):
    """Closed form of the frictionless contact."""
    if getattr(profile, "m", None) == 2:
        return CylinderContact(solid, 1 / (2 * profile.A), P)
    a_max = max(getattr(profile, "flat", 0.0), 1e-9) * 2
    while ProfileContact(solid, profile, a_max).P < P:
        a_max *= 2
    return ProfileContact.from_load(solid, profile, P, a_max)


def _interpolated(t, values):
    """Polynomials with the given values (n, nodes) at the Gauss nodes of (-1, 1), at t."""
    difference = t[:, None] - GAUSS
    exact = difference == 0
    w = _BARYCENTRIC / np.where(exact, 1.0, difference)
    w = np.where(exact.any(axis=1, keepdims=True), exact, w)
    return (w * values).sum(axis=1) / w.sum(axis=1)


_BARYCENTRIC = np.array([1 / np.prod(x - np.delete(GAUSS, i)) for i, x in enumerate(GAUSS)])
