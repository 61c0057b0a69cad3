"""Moves the edges of contact and stick to where Newton's method would take them in many iterations.

A linear step keeps the contact states that it was made with. Where an edge of these lies too far out by e, the pressure
(or the reserve of friction) beside it is that of an edge in the right place, B (d - e)^β with β = (1+k)/2 and d the
distance from the edge, up to e²: B d^(β-1) (d - β e). It vanishes at d = β e, and so the next contact states are off by
(1 - β) e still. Where the edge lies too far in, the gap (or the slip) beyond it is G d^(β-k) (d - (β-k+1) e), and the
next edge is too far out by (β-k) e. As both factors are known so is e: states that lie beyond are imposed on the points
between for one step. There points that were made to slide may turn round; they belong to the zone of stick again.

Where the load goes on as it did, the first jump is to the edges expected: those of the last three load steps lie on a
parabola. The test of what is accepted knows nothing of all this.
"""

import numpy as np

from forms.contact import BACKWARD, CLOSED, DRIVEN_BACKWARD, DRIVEN_FORWARD, FORWARD, LIFTED, OPEN, PINNED, Y

from ..fem.contact_problem import ContactProblem
from ..fem.lagrange import lagrange
from ..fem.load import Load
from ..fem.surface_points import SIDES, AllPoints

JUMPS = 4  # first steps of a solve in which edges may jump
LEAST_JUMP = 2  # points between the edge of one iterate and the next for which it is done
ISLAND = 0.1  # share of the points that stick: fewer beside each other are no zone of stick, but still to slide
IMPOSED = np.array([LIFTED, DRIVEN_BACKWARD, PINNED, DRIVEN_FORWARD])  # on OPEN, BACKWARD, CLOSED, FORWARD points
NARROWED = 0.5  # of the stick zone or the contact that Coulomb's law would leave: it does not become narrower


class EdgeJumps:
    """Contact states to impose on the points of a frictional problem, from those of successive iterates."""

    def __init__(self, problem: ContactProblem):
        self._points = AllPoints(problem.points)
        self._x, self._lifts = self._points.x, Y in problem.directions
        k = problem.body.modulus.k  # of the surface
        self._inwards, self._outwards = 2 / (1 + k), 2 / (3 - k)
        self._used: np.ndarray | None = None  # edges of the last step,
        self._states: np.ndarray | None = None  # and its states
        self._first: np.ndarray | None = None  # contact states (m,) that the first step has
        self._jumps_left = 0
        self._accepted: list[tuple] = []  # loads and edges of the last load steps that went one way, three at most
        self._expected: np.ndarray | None = None  # edges on the polynomial through these

    def begin(self, load, states: np.ndarray | None):
        """Forget the last step; edges are expected where those accepted lead under ``load`` (fem.load.Load), if any.

        states: contact states (m,) of this rank's points where they are nearly those to be found, else None. The first
        step has them, and no edge jumps.
        """
        self._states = self._used = self._expected = None
        self._first, self._jumps_left = states, JUMPS if states is None else 0
        if load is not None and len(self._accepted) >= 2:
            loads, edges = (np.array(values) for values in zip(*self._accepted))
            done = loads[-1] - loads[-2]
            way = (np.array([*loads, load]) - loads[-1]) @ done
            self._expected = sum(edge * share for edge, share in zip(edges, lagrange(way[:-1], way[-1:])[0]))

    def accept(self, load, states: np.ndarray, turned: bool):
        """Keep the edges of what was solved: a load step has ended with the states (m,) of this rank's points.

        turned: whether it went another way than the step before. Then all of the contact stuck at first.
        """
        edges, kept = self._edges(self._points.gathered(states)), self._accepted[-2:]
        if turned:
            kept = [(before, contact[[0, 0, 3, 3]]) for before, contact in kept[-1:]]
        self._accepted = [] if edges is None else [*kept, (load, edges)]

    def save(self) -> dict[str, np.ndarray]:
        """What was accepted, as an array by name."""
        return {"last edges": np.reshape([[*load, *edges] for load, edges in self._accepted], (-1, 7))}

    def restore(self, saved: dict[str, np.ndarray]):
        """Go on from what ``save`` returned, if it is among ``saved``."""
        self._accepted = [(Load(*row[:3]), row[3:]) for row in saved.get("last edges", ())]

    def after(self, states: np.ndarray) -> np.ndarray | None:
        """What to impose on this rank's points (m,) in the next step, see ``contact.slides``; None for nothing.

        states: those of Coulomb's law at the present iterate (m,).
        """
        jump, self._jumps_left = self._jumps_left > 0, self._jumps_left - 1
        if self._first is not None:
            imposed, self._first = IMPOSED[self._first], None
            return imposed
        law, before = self._points.gathered(states), self._states
        imposed = np.zeros(len(law))
        if before is not None:  # a point that turns round at once has slid back too far: it sticks in between
            turned = _sliding(before) * _sliding(law) == -1
            imposed[turned] = PINNED
            law = np.where(turned, CLOSED, law)
        against = _against(law)
        zones = np.where(against, CLOSED, law)
        edges, used = self._edges(zones), self._used
        if jump and edges is not None and (used is not None or self._expected is not None):
            new = self._expected
            if used is not None:
                new = np.array([self._moved(u, e, side) for u, e, side in zip(used, edges, np.repeat(SIDES, 2))])
            edges = self._jump(new, edges, zones, imposed)
            imposed[against & (self._x > edges[1]) & (self._x < edges[2])] = PINNED
        for value, state in ((DRIVEN_FORWARD, FORWARD), (DRIVEN_BACKWARD, BACKWARD), (LIFTED, OPEN), (PINNED, CLOSED)):
            law = np.where(imposed == value, state, law)
        self._states, self._used = law, edges
        return self._points.mine(imposed) if np.any(imposed) else None

    def _jump(self, new, edges, law, imposed):
        """Impose states (n,) on the points between ``edges`` of Coulomb's law and ``new`` ones, which are returned."""
        for outer, inner in ((0, 3), (1, 2)):
            middle, half = (edges[outer] + edges[inner]) / 2, NARROWED * (edges[inner] - edges[outer]) / 2
            new[outer], new[inner] = min(new[outer], middle - half), max(new[inner], middle + half)
        for side, i in zip(SIDES, (1, 2)):
            most = np.sum(_sliding(law)[side * self._x > side * edges[i]])
            if not most:
                new[i] = edges[i]
            elif new[i] != edges[i]:
                between = (law == CLOSED) & (side * self._x > side * new[i])
                imposed[between] = DRIVEN_FORWARD if most > 0 else DRIVEN_BACKWARD
        if self._lifts and (new[0] != edges[0] or new[3] != edges[3]):
            imposed[(law != OPEN) & ((self._x < new[0]) | (self._x > new[3]))] = LIFTED
        return new

    def _moved(self, used, law, side):
        """Where the edge is, from those of the last step's states and of the next ones by Coulomb's law."""
        low, high = sorted((used, law))
        if np.count_nonzero((self._x > low) & (self._x < high)) < LEAST_JUMP:
            return law
        outwards = side * (law - used)
        return used + side * outwards * (self._outwards if outwards > 0 else self._inwards)

    def _edges(self, states):
        """Left edges of contact and stick, right ones of stick and contact (4,); None where one is missing."""
        contact, stick = np.flatnonzero(states != OPEN), _stick(states)
        if stick is None or contact[0] == 0 or contact[-1] == len(states) - 1:
            return None
        ends = np.array([contact[0], stick.start, stick.stop, contact[-1] + 1])
        return (self._x[ends - 1] + self._x[ends]) / 2


def _stick(states: np.ndarray) -> slice | None:
    """From the first to the last zone of stick; None without stick."""
    sticks = states == CLOSED
    turns = np.flatnonzero(np.diff(np.concatenate([[False], sticks, [False]]).astype(np.int8)))
    zones = turns.reshape(-1, 2)
    zones = zones[np.diff(zones)[:, 0] >= ISLAND * np.count_nonzero(sticks)]
    return slice(zones[0, 0], zones[-1, 1]) if len(zones) else None


def _sliding(states: np.ndarray) -> np.ndarray:
    """Which way points slide (n,): 1 along +x, -1 along -x, 0 where they do not."""
    return np.where(states == OPEN, 0, states.astype(int) - CLOSED)


def _against(states: np.ndarray) -> np.ndarray:
    """Points (bool (n,)) beside the zones of stick that slide against most of those on their side."""
    slides, stick, against = _sliding(states), _stick(states), np.zeros(len(states), bool)
    if stick is not None:
        for side in slice(stick.start), slice(stick.stop, None):
            against[side] = slides[side] * np.sum(slides[side]) < 0
    return against
