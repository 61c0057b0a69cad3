"""Coupled frictional contact under a tangential load that goes to and fro at constant P, without load steps."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from ..checks import ContactNotConverged, require_partial_slip
from ..half_plane.layered_kernel import LayeredKernel
from ..material import GradedHalfPlane
from . import guess
from .branch import SAME, Branch
from .pressed import NormalStage, PressedWithFriction
from .problem import surface_of
from .state import CoupledState
from .work import FrictionalWork

ORDER = 10  # of the basis, which also says at how many loads a branch is solved for its energy


@dataclass(frozen=True)
class CoupledLoop:
    """Rigid profile on a graded half-plane, pressed by P, and then loaded by Q.

    solid: a GradedHalfPlane, or a LayeredKernel of a modulus that is a power law down to some depth; profile: a
    PowerProfile of an even power; P: line load [stress x length]; mu: friction coefficient; coupling: False leaves out
    the coupling kernel; order: of the basis, see ``stick``; friction_first: pressed with friction from first contact,
    where without coupling nothing slips.
    Between two turns of Q the state depends on that at the first turn only: where it sticks its displacement is that
    at the turn, elsewhere |q| = mu p. So each state is found directly, and does not depend on those before it.
    """

    solid: GradedHalfPlane | LayeredKernel
    profile: object
    P: float
    mu: float
    coupling: bool = True
    order: int = ORDER
    friction_first: bool = False

    def run(self, loads, like: Sequence[CoupledState] = ()) -> list[CoupledState]:
        """State after every load (P, Q) of ``loads``; see ``where_known``, of which none may be missing.

        Raises ValueError for P <= 0, |Q| >= mu P or a first Q != 0; ContactNotConverged, with the reason.
        """
        return known(self.where_known(loads, like))

    def where_known(self, loads, like: Sequence[CoupledState] = ()) -> list["CoupledState | ContactNotConverged"]:
        """State after every load (P, Q) of ``loads``; the first ones have Q = 0, the others the same P.

        like: states at the same loads of a basis of another order, from which the edges are guessed; the least load
        that is solved for the energy is larger then, so that the difference is about the error. A load between turns
        without a state has the reason in its place: points may come into contact in stick just after a turn. States
        soon after such loads are not certain, see ``CoupledState``.

        Raises ValueError for P <= 0, |Q| >= mu P or a first Q != 0; ContactNotConverged, with the reason.
        """
        loads = [(float(P), float(Q)) for P, Q in loads]
        for P, Q in loads:
            require_partial_slip(P, Q, self.mu)
        if loads and loads[0][1] != 0:
            raise ValueError(f"Q = {loads[0][1]!r} at first contact: the first load has Q = 0")
        first = next((i for i, (_, Q) in enumerate(loads) if abs(Q) > SAME * P), len(loads))
        for P, _ in loads[max(first - 1, 0) :]:
            if P != self.P:
                raise ContactNotConverged(f"P = {P!r} while Q acts: P has to stay at {self.P!r} after the normal stage")
        if self.friction_first and any(P < before for (before, _), (P, _) in pairwise(loads[:first])):
            raise ContactNotConverged("P falls before Q acts, and friction from first contact remembers it")
        normal_stages = [self._normal(P) for P, _ in loads[:first]]
        states: list[CoupledState | ContactNotConverged] = [CoupledState(normal, normal) for normal in normal_stages]
        if first == len(loads):
            return states
        alike = list(dict.fromkeys(state.branch for state in like if state.branch))
        return states + self._tangential(normal_stages[-1], [Q / self.P for _, Q in loads[first:]], alike)

    def _normal(self, P):
        if self.friction_first and self.coupling:
            if surface_of(self.solid) is not self.solid:
                raise ContactNotConverged("no contact pressed with friction on layers is similar to itself")
            return PressedWithFriction(self.solid, self.profile, P, self.mu, self.order)
        return NormalStage(self.solid, self.profile, P, self.mu, self.coupling, self.order)

    def _tangential(self, normal, loads, alike):
        """States at the loads Q/P after the normal stage; alike: branches of a loop at the same loads, or none."""
        base, turn = normal, None
        branches: list[Branch] = []  # those that are remembered
        states: list[CoupledState | ContactNotConverged] = []
        for number, (direction, Qs) in enumerate(branches_of(loads)):
            span = abs(Qs[-1] - base.Q)
            try:
                guessed = self._guess(branches, base, direction)
                branch = Branch(base, direction, span, guessed, alike[number] if alike else None)
                branch.solve_at(np.unique(np.abs(np.subtract(Qs, base.Q))))
            except ContactNotConverged as failure:
                raise ContactNotConverged(f"P = {self.P:g}, Q up to {Qs[-1] * self.P:g}: {failure}") from None
            friction = FrictionalWork(branch)
            for Q in Qs:
                try:
                    reached = branch.checked(Q)
                    states.append(CoupledState(normal, reached, branch, friction, turn))
                except ContactNotConverged as failure:
                    states.append(failure)
            if isinstance(turn := states[-1], ContactNotConverged):
                raise turn
            base = reached
            branches.append(branch)
            while len(branches) > 2 and branches[-2].is_undone(Qs[-1]):
                del branches[-2:]  # the one before them goes on, as without the turns that are passed
        return states

    def _guess(self, branches, base, direction):
        """Guess of the edges after a turn as a function of the load, from the branches before it."""
        within = self._guess_within(branches, base, direction)
        return partial(guess.beyond, branches[-2], branches[-1], within, base, direction) if branches[1:] else within

    def _guess_within(self, branches, base, direction):
        """The same as far as Q does not go past the turn before."""
        if isinstance(base, PressedWithFriction):
            return partial(guess.pressed, base, direction)
        if not branches:
            return partial(guess.uncoupled, self.solid.k, self.mu)
        if len(branches) == 1 and isinstance(branches[0].base, PressedWithFriction):  # slip there was wide at once
            return partial(guess.uncoupled, self.solid.k, 2 * self.mu)
        if len(branches) > 2:
            return branches[-2].guessed
        return partial(guess.mirrored if len(branches) == 2 else guess.turned, branches[-1])


def known(states: Sequence[CoupledState | ContactNotConverged]) -> list[CoupledState]:
    """The states, if all are certain; else ContactNotConverged, the first reason."""
    for reason in map(missing, states):
        if reason:
            raise reason
    return list(states)  # type: ignore[arg-type]  # no reason is among them


def missing(state: CoupledState | ContactNotConverged) -> ContactNotConverged | None:
    """Why there is no certain state; None where there is."""
    if isinstance(state, ContactNotConverged):
        return state
    if state.is_certain:
        return None
    return ContactNotConverged(f"Q = {state.Q / state.P:g} P: points that came into contact in stick may stick still")


def branches_of(loads):
    """Parts of ``loads`` between turns, each a direction and its loads; they start from zero."""
    parts: list[tuple[float, list[float]]] = []
    last = 0.0
    for Q in loads:
        if abs(Q - last) <= SAME:
            Q = last
        direction = float(np.sign(Q - last))
        if parts and direction in (0.0, parts[-1][0]):
            parts[-1][1].append(Q)
        elif direction:
            parts.append((direction, [Q]))
        last = Q
    return parts
