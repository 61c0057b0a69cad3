"""Incremental frictional contact of a rigid convex profile with a half-plane, normal-tangential coupling included.

A boundary-element reference without mesh of the body: tractions on nodes that follow the edges of contact and
stick from increment to increment, the surface kernels integrated exactly, and the conditions of Signorini and
Coulomb fulfilled node by node. Beyond the paper, whose theory neglects the coupling [X6].
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, log

import numpy as np

from ..checks import ContactNotConverged, require, require_partial_slip
from ..material import GradedHalfPlane
from ..normal import half_width_where
from .edges import stuck_runs
from .increment import Increment
from .interpolation import Interpolant
from .layered_kernel import require_reach
from .layout import Layout, first_distance
from .linear import ContactSets, Data
from .operator import displacement_of, element_moments
from .state import ContactState, Memory, PiecewiseField, StoredField
from .surface_kernel import PowerLawKernel, SurfaceKernel
from .work import worked

COARSE_MARGIN, MARGIN = 0.1, 0.01  # nodes beyond the contact over its width: while the edges are sought, and then
SOUGHT = 2e-3  # motion of the edges over the width of the contact, below which all nodes are used
SETTLED = 0.3  # motion over the distance from an edge to its first few nodes, below which the edges rest
SLOW = 0.5  # ratio of successive motions above which edges are thought to go to and fro, and move half way only
HALF_PASSES = 5  # with half of the nodes, after a first one; twice as many with all, then a motion below SOUGHT is rest
PASSES = 20
UNSETTLED = 0.02  # motion of the edges of contact over its width that is never borne with
FLOOR = 1e-100  # of a ratio whose logarithm is taken
HALVINGS = 4  # of an increment, one after the other


@dataclass(frozen=True)
class HalfPlaneContact:
    """Rigid profile f(x) under loads P and Q on a half-plane, f + u_y - delta_y >= 0, |q| <= mu p.

    The half-plane may also be stretched by a uniform strain along x, which is then part of u_x [X7].

    solid: a GradedHalfPlane or any SurfaceKernel. profile: has ``height(x)`` [length], convex with its tip at x = 0,
    and if need be ``flat`` and ``order`` like a Profile or PowerProfile, which tell where it is not smooth.
    mu: friction coefficient. coupling: False leaves out the coupling kernel, the approximation of the closed forms.
    friction_in_normal_stage: whether friction acts from first contact, or only after the leading loads with Q = 0.
    nodes: their number at every increment; half of them while the edges are sought.
    elastic: compliance c of elastic slip [length/stress]; the slip of a state is then that of u_x + c q.
    """

    solid: GradedHalfPlane | SurfaceKernel
    profile: object
    mu: float
    coupling: bool = True
    friction_in_normal_stage: bool = False
    nodes: int = 300
    elastic: float = 0.0

    @cached_property
    def kernel(self) -> SurfaceKernel:
        """Surface kernel of the solid."""
        return PowerLawKernel(self.solid) if isinstance(self.solid, GradedHalfPlane) else self.solid

    def run(self, loads: Iterable[tuple[float, ...]]) -> list[ContactState]:
        """State after every load (P, Q) or (P, Q, strain), starting from no contact; see ``increments``."""
        return list(self.increments(loads))

    def increments(self, loads: Iterable[tuple[float, ...]]) -> Iterator[ContactState]:
        """States one by one.

        Raises ValueError for P <= 0, |Q| >= mu P, a first Q != 0, and for mu < 0 or numbers that are not finite;
        ContactNotConverged, with the reason.
        """
        memory, normal_stage = None, True
        for P, Q, *rest in loads:
            strain = rest[0] if rest else 0.0
            require_partial_slip(P, Q, self.mu)
            require("strain", strain, -np.inf)
            if memory is None:
                if Q != 0:
                    raise ValueError(f"Q = {Q!r} at first contact: the first load has Q = 0")
                memory = Memory(None, Layout.first(self._guessed_half_width(P), self._corners))
            normal_stage = normal_stage and Q == 0 and strain == 0
            memory = self._reached(memory, (P, Q, strain), normal_stage)
            yield memory.state

    def _reached(self, memory, load, normal_stage, halvings=HALVINGS):
        """Memory of the load (P, Q, strain), reached in two halves should one step fail."""
        try:
            return self._advance(memory, load, normal_stage)
        except ContactNotConverged:
            if not halvings:
                raise
        before = memory.state.load if memory.state else (0.0, 0.0, 0.0)
        middle = tuple((b + a) / 2 for b, a in zip(before, load, strict=True))
        half = self._reached(memory, middle, normal_stage, halvings - 1)
        return self._reached(half, load, normal_stage, halvings - 1)

    def _advance(self, memory, load, normal_stage):
        """Solves on nodes that follow the edges until these rest: with half of the nodes first, then with all."""
        P, Q, _ = load
        k = self.kernel.k
        mu = self._friction(normal_stage)
        layout, old_edges = memory.layout, memory.edges_left_behind(load)
        fine, solution, motion = 0, None, np.inf
        earlier: list[Layout] = []
        settled = SETTLED * first_distance(self.nodes, k)
        for number in range(PASSES):
            operator, solution = self._solved(layout, fine > 0, fine > 0, memory, mu, load, solution)
            new = layout.of(solution, mu, k, old_edges)
            last_motion, motion = motion, new.distance(layout)
            if fine and motion < (SOUGHT if fine > 2 * HALF_PASSES else settled):
                return self._remember(memory, new, operator, solution, load, normal_stage)
            if any(new.distance(other) < settled for other in earlier):  # edges go round: once more
                if fine > 2 * HALF_PASSES:
                    break
                fine, earlier = 2 * HALF_PASSES, []
            if fine:
                earlier.append(new)
            fine += fine > 0 or motion < SOUGHT or number >= HALF_PASSES
            layout = layout.halfway(new) if motion > SLOW * last_motion else new
        # Some edge goes to and fro between nodes: straight lines do not ask where it is.
        layout = layout.with_edges_of(new)
        operator, solution = self._solved(layout, True, False, memory, mu, load, solution)
        new = layout.of(solution, mu, k, old_edges)
        if (motion := new.distance_of_contact(layout)) > UNSETTLED:
            raise ContactNotConverged(
                f"P = {P:g}, Q = {Q:g}: after {number + 1} passes the edges of contact still move "
                f"by {motion:.1e} of the width of the contact"
            )
        return self._remember(memory, new, operator, solution, load, normal_stage)

    def _solved(self, layout, fine, adapted, memory, mu, load, previous):
        """Operator and solution on the nodes of ``layout``, more of them should the contact reach the last.

        The solution's u_x is without strain: what has stuck has moved back from where it was by strain x.
        """
        P, Q, strain = load
        margin = layout.width * (MARGIN if fine else COARSE_MARGIN)
        while True:
            x = layout.nodes(self.nodes if fine else self.nodes // 2, margin, self.kernel.k)
            operator = layout.operator(self.kernel, x, adapted, self.coupling)
            height = self._height(x)
            if not np.isfinite(height).all():
                beyond = x[~np.isfinite(height)][0]
                raise ValueError(
                    f"P = {P:g}, Q = {Q:g}: the profile has no height at x = {beyond:g}, just outside "
                    f"the contact between {layout.contact[0]:g} and {layout.contact[1]:g}"
                )
            if self.elastic:
                operator = replace(operator, tangential=operator.tangential + self.elastic * np.eye(len(x)))
            increment = Increment(operator, mu, Data(height, memory.position(x) - strain * x, P, Q))
            previous = increment.solve(_initial_sets(x, layout, previous))
            if not previous.sets.closed[[0, -1]].any():
                return operator, previous
            margin += 0.1 * layout.width

    def _remember(self, memory, layout, operator, solution, load, normal_stage):
        require_reach(self.kernel, layout.width)
        P, Q, strain = load
        x = operator.nodes
        reached = solution.position + strain * x
        stuck = x[stuck_runs(solution, self._friction(normal_stage))]
        q = Interpolant.of(x, operator.of_traction, solution.traction)
        p = Interpolant.of(x, operator.of_pressure, solution.pressure)

        def displacements(y):  # holds no matrix of the load step, as parts of it are kept for many
            N, T, D = element_moments(self.kernel, y, x)
            u_x, u_y = displacement_of(T, q.coefficients), displacement_of(N, p.coefficients)
            if self.coupling:
                u_x += displacement_of(D, p.coefficients)
                u_y -= displacement_of(D, q.coefficients)
            return u_x, u_y

        def position(y):
            return displacements(y)[0] + self.elastic * q(y) - solution.delta_x + strain * y

        def gap(y):
            return self._height(y) + displacements(y)[1] - solution.delta_y

        place, opening = StoredField(x, reached, position), StoredField(x, solution.gap, gap)
        if normal_stage:
            slip, slip_field = np.zeros(len(x)), np.zeros_like
            reference = PiecewiseField.kept_in(stuck, memory.reference, place)
        else:
            reference = memory.reference
            slip = np.where(solution.sets.stuck, memory.slip(x), reached - reference(x))
            new = StoredField(x, slip, lambda y: position(y) - reference(y))
            slip_field = PiecewiseField.kept_in(stuck, memory.slip, new)
        energy, begun, way = worked(self.mu, memory, operator, solution, load, normal_stage, (p, opening), (q, place))
        state = ContactState(
            P, Q, strain, x, operator.weight, operator.weight_q,
            solution.pressure, solution.traction, slip, solution.gap,
            layout.contact, layout.stick, layout.zones, energy, solution.delta_x, solution.delta_y,
        )
        return Memory(state, layout, slip_field, reference, p, q, opening, way, begun, memory.directions(load))

    def _friction(self, normal_stage):
        return self.mu if self.friction_in_normal_stage or not normal_stage else 0.0

    @property
    def _corners(self):
        """Where the profile is not smooth [length]: at the ends of its flat, or at a tip sharper than a parabola."""
        flat = getattr(self.profile, "flat", 0.0)
        return [-flat, flat] if flat else [0.0] * (getattr(self.profile, "order", 2.0) < 2)

    def _height(self, x):
        with np.errstate(invalid="ignore", over="ignore"):  # beyond the end of an arc, say
            return self.profile.height(x)

    def _guessed_half_width(self, P):
        """Length l over which the load P makes a displacement of the order of the indenter's height f(l)."""
        flat = getattr(self.profile, "flat", 0.0)

        def excess(log_width):
            length = flat + exp(log_width)
            near, far = self.kernel.values(np.array([length / 2, length]))[0]
            height = float(self._height(length))
            if not np.isfinite(height):  # beyond the indenter's end
                return log(1 / FLOOR)
            return log(max(height / (P * (near - far)), FLOOR))

        return flat + half_width_where(excess, log(flat) if flat else 0.0, step=5)


def _initial_sets(x, layout, previous):
    """Sets of the previous pass on new nodes; in the first pass every node in contact sticks, the predictor."""
    closed = (x > layout.contact[0]) & (x < layout.contact[1])
    if previous is None:
        return ContactSets(closed, np.zeros(len(x)))
    nearest = np.searchsorted((previous.x[1:] + previous.x[:-1]) / 2, x)
    slipping = np.where(closed, previous.sets.slipping[nearest], 0.0)
    centre = np.mean(layout.stick if len(layout.zones) else layout.contact)
    slipping[np.abs(x - centre).argmin()] = 0.0  # a stick zone may lie between two nodes
    return ContactSets(closed, slipping)
