"""Reference of coupled runs: the mesh-free half-plane solver under the same loads, with load steps of its own."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import ceil, log10

import numpy as np

from analytic import PressingWithFriction

from ..fem.load import Load
from ..loading.schedule import SHORT, LoadStep, pressed_first, pressing
from .comparison import NoReference, OfStates, last_cycle
from .expected_edges import half_plane_solver
from .limits import coating_keys
from .simulation import Simulation

Tell = Callable[[int, int], None]  # load steps done, and all of them
NODES = (400, 300)  # the next number is tried where one does not converge
FINER = 2  # load steps of the reference for one of the run: what depends on the steps is not shared
STEPS_TO_POINT = 8  # load steps from point to point of a path: with fewer the error does not yet fall like the step
FEWER_NODES = (200, 150)  # with more load steps: their error is then what counts, and a load step costs a fifth
MANY_STEPS = 48  # load steps a quarter, or to a point of a path, where the error falls more slowly than the load step
SMALL_GROWTH = 0.005  # of P in a load step with coupling, over the largest P: there points come into contact in stick
FIRST_GROWTH = 0.06  # where P begins to grow, load steps are as many as for so much, at least: q is small there
NODES_AS_P_GROWS = (300, 200)  # more would take longer and help less than load steps do
FIRST_CONTACT = 4  # times as many of the first load step under friction, which begins with no contact
STEPS_SINCE_TURN = 24  # in which the distance from the last turn of Q grows tenfold,
FIRST_SINCE_TURN = 0.1  # and the first of them over the distance of the first load after the turn
SHARE_OF_NODES = 0.75  # nodes for one, and half of the load steps, for an estimate of the reference's error


class MeshFree(OfStates):
    """States of the half-plane solver at the load steps of a simulation; NoReference where it fails.

    nodes: numbers of nodes, of which the next is tried where one does not converge, then the one that did converge;
    finer: load steps for one of the simulation, ``steps_for_one`` where not given, and more where P grows; tell: called
    after each. coarser: the same with fewer of both, made if ``estimated``: points that enter contact within a load
    step keep an error of first order in it, also at constant P where coupling moves the contact. The difference is
    about the error of this solution.
    since_turn: numbers of load steps that are divided by ``shares_since_turn``, into ``finer`` steps there; all others
    stay one step.
    """

    name = "mesh-free half-plane solver"

    def __init__(
        self,
        simulation: Simulation,
        tell: Tell | None = None,
        nodes: tuple[int, ...] = NODES,
        finer: int | None = None,
        estimated: bool = False,
        since_turn: Sequence[int] = (),
    ):
        self.since_turn = since_turn
        self.finer = finer or (STEPS_SINCE_TURN if since_turn else steps_for_one(simulation))
        friction_first = "friction in normal stage" in simulation.effects
        if since_turn:
            shares = shares_since_turn(simulation.schedule, since_turn, self.finer)
        else:
            small = SMALL_GROWTH * steps_for_one(simulation) / self.finer if grows(simulation) else np.inf
            shares = equal_shares(simulation.schedule, friction_first, self.finer, small)
        first = FIRST_CONTACT * self.finer if friction_first else 1
        loads, places = refined(simulation.schedule, shares, first)
        failure = None
        for count in nodes:
            try:
                solver = half_plane_solver(simulation.scene, simulation.scaled, simulation.effects, count)
                states = []
                for state in solver.increments(loads):
                    states.append(state)
                    if tell:
                        tell(len(states), len(loads))
                self.nodes = count
                break
            except (RuntimeError, ValueError) as reason:
                failure = failure or reason  # the one of the finest nodes is told
        else:
            coating = coating_keys(simulation.scene)
            raise NoReference(f"{failure}; {coating}" if coating else str(failure))
        found = [states[place] for place in places]
        energy = _dissipated(found, simulation.schedule, simulation.pressing_with_friction)
        super().__init__(found, energy, bool(simulation.hidden_peak))
        self.coarser = self._coarser(simulation, nodes) if estimated else None

    def _coarser(self, simulation, nodes):
        fewer = tuple(int(SHARE_OF_NODES * count) for count in nodes if count <= self.nodes)
        try:
            return MeshFree(simulation, nodes=fewer, finer=self.finer // 2, since_turn=self.since_turn)
        except NoReference as failure:
            raise NoReference(f"the error of the {self.name} is not known: {failure}") from None


def _dissipated(states, schedule, pressing: PressingWithFriction | None) -> float:
    """Of the last full cycle, where there is none since first contact: while P grows alone by the exact contact, where
    that is known, as the load steps of this solver add an error of first order there.
    """
    found = last_cycle(states, schedule)
    if pressing is None or schedule[-1].cycle:
        return found
    pressed = pressed_first(schedule) - 1
    exact = replace(pressing, P=schedule[pressed].load.P).dissipated_energy
    return found + exact - states[pressed].dissipated_energy


def steps_for_one(simulation: Simulation) -> int:
    """Load steps of the reference for one of the simulation."""
    scene = simulation.scene
    least = MANY_STEPS if needs_many_steps(simulation) else STEPS_TO_POINT * scene.is_path
    return max(FINER, ceil(least / scene.solver.increments))


def nodes_for(simulation: Simulation) -> tuple[int, ...]:
    """Numbers of nodes of the reference, the fewer the more load steps it takes."""
    if needs_many_steps(simulation):
        return FEWER_NODES
    return NODES_AS_P_GROWS if grows(simulation) else NODES


def needs_many_steps(simulation: Simulation) -> bool:
    """Whether an error falls more slowly than the load step: the difference from half of the steps is less than it.

    So it is where Q and the bulk strain go round an ellipse, as points that turn between two loads turn late; and with
    elastic slip where coupling moves the contact.
    """
    is_elastic = simulation.scene.effects.elastic_slip is not None
    return any(step.angle for step in simulation.schedule) or is_elastic and "coupling" in simulation.effects


def grows(simulation: Simulation) -> bool:
    """Whether P grows with coupling after the normal stage, while friction acts."""
    steps = pairwise(simulation.schedule) if "coupling" in simulation.effects else ()
    return any(step.P > before.P for before, step in steps if step.branch != "normal")


def equal_shares(
    schedule: Sequence[LoadStep], friction_first: bool, finer: int, small: float = np.inf
) -> list[np.ndarray]:
    """Shares of the way to each load after the first, at which load steps end: ``finer`` equal ones, or so many that
    P grows by no more than ``small`` in one, over its largest value; where it begins to, as many as for FIRST_GROWTH.

    Frictionless pressing, which leaves no memory, stays one step. So does the short step before a turn of an ellipse:
    in parts of it points move by round-off, and the stick zone falls apart.
    """
    shares, largest, grew = [], max(step.P for step in schedule), False
    for before, step in pairwise(schedule):
        moves = friction_first or any(step.load[1:]) or any(before.load[1:])
        is_short = step.state in ("A", "E") and 0 < step.angle < 1.01 * SHORT
        growth = (step.P - before.P) / largest if moves else 0.0
        if growth > 0 and not grew:
            growth = max(growth, FIRST_GROWTH)
        grew = growth > 0
        steps = max(finer, ceil(growth / small)) if moves and not is_short else 1
        shares.append(np.arange(1, steps + 1) / steps)
    return shares


def shares_since_turn(schedule: Sequence[LoadStep], numbers: Sequence[int], steps: int) -> list[np.ndarray]:
    """The same with one step to each load but those of these ``numbers``. On the way there the distance of Q from the
    last turn grows by a constant factor, tenfold in so many ``steps``: just after a turn tractions depend on that
    distance like a power, so it is this factor that tells how far points that come into contact in stick are off.
    """
    shares: list[np.ndarray] = []
    turn = direction = 0.0
    for number, (before, step) in enumerate(pairwise(schedule), 1):
        way = np.sign(step.Q - before.Q)
        if way not in (0.0, direction):
            turn, direction = before.Q, way
        near, far = abs(before.Q - turn), abs(step.Q - turn)
        if number in numbers and far > near:
            least = near or FIRST_SINCE_TURN * far
            distances = np.geomspace(least, far, ceil(steps * log10(far / least)) + 1)
            distances = distances[distances > near]
            shares.append((distances - near) / (far - near))
        else:
            shares.append(np.ones(1))
    return shares


def refined(schedule: Sequence[LoadStep], shares: list[np.ndarray], first: int = 1) -> tuple[list[Load], list[int]]:
    """Loads after these ``shares`` of the way to each but the first, and where those of the schedule are among them.

    first: load steps of pressing to the first of them, about equal in the half-width of contact.
    """
    all_loads = [*(step.load for step in pressing(schedule[0].P, first)[:-1]), schedule[0].load]
    places = [first - 1]
    for (before, step), parts in zip(pairwise(schedule), shares, strict=True):
        all_loads += [step.on_the_way(before.load, share) for share in parts]
        places.append(len(all_loads) - 1)
    return all_loads, places
