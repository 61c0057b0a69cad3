"""Surface quantities of a state: pressure, traction, displacement, where points slide, edges of contact and stick."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from forms.contact import X, Y

from .contact_problem import ContactProblem

SKIPPED, FITTED = 5, 10  # nodes next to an edge that carry its discretisation error, and those read beyond them
# A traction this close (relative to the largest limit) to its limit slides: forces are known to 1e-9 P, tractions on
# facets of 1e-3 a a thousand times less well.
AT_LIMIT = 1e-6
BAND = 0.01  # of the contact's width: a narrower band of slip within a stick zone is a node or two, and no end of it


@dataclass(frozen=True)
class SurfaceState:
    """Nodal values (n,) on the strip under the indenter, sorted by x, equal on every rank, dimensionless.

    weight is the length of surface that belongs to a node: sum(weight * pressure) is the line load P.
    """

    x: np.ndarray
    weight: np.ndarray
    pressure: np.ndarray
    traction: np.ndarray
    u: np.ndarray  # (2, n), that of a bulk strain included
    delta: np.ndarray  # (2,)
    neglected: np.ndarray  # (2, n) the u_x of the pressure and the u_y of the traction where coupling is off, else 0
    elastic: float = 0.0  # compliance of elastic slip
    mu: float = 0.0  # coefficient of friction

    @property
    def relative_displacement(self) -> np.ndarray:
        """u_x - delta_x as friction sees it, less the elastic slip -c q, (n,)."""
        return self.u[X] - self.neglected[X] - self.delta[X] + self.elastic * self.traction

    @property
    def approach(self) -> np.ndarray:
        """u_y - delta_y as contact sees it, (n,): the gap is f(x) more."""
        return self.u[Y] - self.neglected[Y] - self.delta[Y]

    @property
    def limit(self) -> np.ndarray:
        """The largest traction that friction allows, mu p (n,)."""
        return self.mu * self.pressure

    @cached_property
    def slides(self) -> np.ndarray:
        """Sign of the traction where points slide (n,), as it is at its limit; 0 elsewhere."""
        limit = self.limit
        at_limit = (limit > 0) & (np.abs(self.traction) >= limit - AT_LIMIT * limit.max())
        return np.where(at_limit, np.sign(self.traction), 0.0)

    @property
    def elastic_energy(self) -> float:
        """Stored by elastic slip,  ∫ c q²/2 dx ."""
        return self.elastic * self.line_load(self.traction**2) / 2

    @property
    def conjugates(self) -> tuple[float, float, float]:
        """What P, Q and the strain of the body do work on: delta_y, delta_x and  ∫ q x dx ."""
        return float(self.delta[Y]), float(self.delta[X]), self.line_load(self.traction * self.x)

    def line_load(self, values) -> float:
        """Integral of nodal values over the surface."""
        return float(self.weight @ values)


class SurfaceSampler:
    """Collects a SurfaceState from all ranks. problem: any on the body; mu: coefficient of friction; uncoupled: the
    pressure's u_x is no slip, and the traction's u_y no gap.
    """

    def __init__(self, problem: ContactProblem, mu: float = 0.0, uncoupled: bool = False):
        self.body, self.mu, self._uncoupled = problem.body, mu, uncoupled
        self._nodes = self.body.surface_nodes
        self.x = self._mirrored(self._nodes.x, -1)
        self.weight = self._collect_sums(problem.terms.tributary_lengths()[self._nodes.owned])

    def sample(self, problem: ContactProblem) -> SurfaceState:
        """The present state of the surface; contact tractions are nodal forces over tributary lengths."""
        force = [self._collect_sums(problem.terms.nodal_forces(i, self._nodes.owned)) for i in (X, Y)]
        dofs = self.body.dofs[self._nodes.owned]
        normal = problem.held.state if problem.held else self.body.state  # of the pressure alone
        u, normal_u = self.body.state.x.array[dofs], normal.x.array[dofs]
        neglected = np.zeros(u.shape)
        if self._uncoupled:
            neglected[:, X], neglected[:, Y] = normal_u[:, X], u[:, Y] - normal_u[:, Y]
        stretching = self.body.stretching(self.x, np.zeros_like(self.x))
        return SurfaceState(
            x=self.x,
            weight=self.weight,
            pressure=force[Y] / self.weight,
            traction=force[X] / self.weight,
            u=self._displacement(u) + stretching.T,
            delta=self.body.delta.value.copy(),
            neglected=self._displacement(neglected),
            elastic=problem.elastic,
            mu=self.mu,
        )

    def _displacement(self, u):
        return np.stack([self._collect(u[:, X], parity=-1), self._collect(u[:, Y])])

    def _collect(self, nodal, parity: int = 1):
        """Sorted values of all ranks, mirrored."""
        return self._mirrored(self._nodes.collect(nodal), parity)

    def _collect_sums(self, nodal):
        """The same for integrals over the surface around a node; on the axis half of it is on the mesh."""
        values = self._collect(nodal)
        if self.body.is_half:
            values[len(values) // 2] *= self.body.symmetry_factor
        return values

    def _mirrored(self, values, parity: int):
        """Values at x > 0, for half a body also those of its mirror image: times ``parity``."""
        return np.concatenate([parity * values[:0:-1], values]) if self.body.is_half else values


def fitted_contact_edges(state: SurfaceState, exponents: tuple[float, float]) -> tuple[float, float]:
    """Edges of the contact, where pressure ends like distance to a power, (1+k)/2 in (44); nan for under 4 nodes."""
    first, last = _longest_run(state.x, state.pressure > 0)
    return _edges(state.x, (state.pressure, state.pressure), first, last, exponents)


def fitted_stick_edges(
    state: SurfaceState, direction: int, exponents: Callable[[float], Sequence[float]]
) -> tuple[float, float]:
    """Left and right edge of the longest stick zone; both are nan where fewer than 4 nodes stick. Zones that are less
    than BAND apart are one.

    The traction's distance from the limit that points beyond an edge slide at, mu p - s q, ends there like a power of
    the distance: (1+k)/2 in (47), and ``exponents`` of s at both edges. s is the sign of q there, which differs between
    both edges where P changes; where no point slides it is ``direction``, that of the load (+1, -1; 0: neither).
    """
    limit, q, slides = state.limit, state.traction, state.slides
    closed = state.x[state.pressure > 0]
    band = BAND * np.ptp(closed) if closed.size else 0.0
    first, last = _longest_run(state.x, (limit > AT_LIMIT * limit.max()) & (slides == 0.0), band)
    signs = [(slides[i] if 0 <= i < len(slides) else 0.0) or direction for i in (first - 1, last)]
    margins = [limit - (s * q if s else np.abs(q)) for s in signs]
    return _edges(state.x, margins, first, last, [exponents(s)[i] for i, s in enumerate(signs)])


def _edges(x, values, first, last, exponents):
    """Where ``values``, of the left and of the right edge, end beside the points from ``first`` to before ``last``."""
    if last - first < 4:
        return np.nan, np.nan
    left, right = (
        np.maximum(value[first:last], 0.0) ** (1.0 / exponent) for value, exponent in zip(values, exponents)
    )
    # where the fit leads away (a traction that runs along its limit) the nodes know better
    end = np.clip(_zero(x[first:last], right), x[last - 2], x[min(last + 1, len(x) - 1)])
    begin = np.clip(-_zero(-x[first:last][::-1], left[::-1]), x[max(first - 2, 0)], x[first + 1])
    return float(begin), float(end)


def _zero(x, values):
    """Where ``values``, smooth and positive up to its right end, reaches zero; between nodes.

    A parabola through FITTED nodes, which leaves out the SKIPPED ones next to the edge, is continued to its zero.
    """
    stop = max(len(x) - SKIPPED, 4)
    start = max(stop - FITTED, 0)
    for degree in (2, 1):  # a line where the parabola turns before it reaches zero
        roots = np.polynomial.Polynomial.fit(x[start:stop], values[start:stop], degree).roots()
        roots = roots[np.isreal(roots)].real
        if roots.size:
            return float(roots[np.argmin(np.abs(roots - x[-1]))])
    return float(x[-1])


def _longest_run(x, mask, gap=0.0):
    """First index and end of the run of True that is longest in x; runs no more than ``gap`` apart are one."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    if ends.size == 0:
        return 0, 0
    starts, stops = ends[::2], ends[1::2]
    first, last = longest_zone(x[starts], x[stops - 1], gap)
    return starts[first], stops[last]


def longest_zone(left, right, gap: float) -> tuple[int, int]:
    """First and last of the zones from ``left`` to ``right`` (n,) that make the longest; those at most ``gap`` apart
    are one.
    """
    apart = left[1:] - right[:-1] > gap
    first, last = np.flatnonzero(np.append(True, apart)), np.flatnonzero(np.append(apart, True))
    longest = np.argmax(right[last] - left[first])
    return int(first[longest]), int(last[longest])
