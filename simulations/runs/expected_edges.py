"""Expected edges of contact and stick zone, before anything is solved: the mesh is graded to them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import log
from typing import NamedTuple

import numpy as np

from analytic import ContactNotConverged, FrettingLoop, HalfPlaneContact, SpringPath

from ..loading.schedule import LoadStep, pressing, rocking
from ..scene import Scene
from ..scene.effects import Effects
from ..scene.scaling import Scaled
from .limits import expected_error, size_for

NODES = 80  # of the half-plane solver: contact is met to 0.7 % and stick to 0.2 % of the half-width, k from -0.5 to 0.7
ROUGH_QUARTER, ROUGH_PRESSING = 2, 4  # its load steps per Q_A, and of the normal stage if friction acts in it
ONE_EDGE = 0.005  # edges closer than this (over the half-width) are one
FACETS = 3  # from a stop to the next, so that both can be placed in theirs
SAMPLES = 200  # of q, for its norm
MOST = 30  # edges on either side
FINER_WITH_COUPLING = 3.0  # facets on the way of the edges of stick, where stops are not known
EARLY, FURTHER_INSIDE = 3.0, 0.1  # finer where the edge of stick stops first, when q is small; so much further inside
FINEST = 4.0  # the finest on that way with coupling, which k < -0.3 comes to: more takes minutes
AT_STOPS = 2.0, 0.8  # error of q at k < 0 on the way of the edges of stick, without coupling and with it
ON_THE_WAY = 0.07, 0.15  # error of p on the contact's way, k >= 0 and k < 0, over that of ``facet`` and k = 0
FACETS_OF_WAY = 300  # facets on either side of the contact's way: its length is half the contact's where mu is above 1
STOP = 2.0, 4.0  # error of q that a stop may cost (limits.expected_error) over facet², for k >= 0 and k < 0
MERGED = 0.5  # smallest facets between edges, below which both have one place
TURNED = 2.0  # where slip has turned, q changes by 2 mu p
FIRST = 3  # facets, either side, in the contact of the first load step with friction


def half_plane_solver(scene: Scene, scaled: Scaled, effects: Effects, nodes: int) -> HalfPlaneContact:
    """The mesh-free solver of the same problem, in scaled units."""
    return HalfPlaneContact(
        scaled.kernel,
        scaled.indenter,
        mu=scene.mu if scene.friction else 1.0,
        coupling="coupling" in effects,
        friction_in_normal_stage="friction in normal stage" in effects,
        nodes=nodes,
        elastic=scaled.elastic_compliance(scene),
    )


@dataclass(frozen=True)
class ExpectedEdges:
    """Places x > 0 where edges turn round, and ways (from, to) of the contact's and of the stick's between them.

    What is at x is at -x too. first: half-width of contact after the first load step, if friction acts in it; stops:
    where an edge of stick or contact is after a load step, and the size of q there (Stop); exact: none is an estimate;
    fineness: ``facet`` over the facets on the way of the edges of stick, if more than 1; early: about where it stops
    first, where these are not known; pressed: half-widths of contact after load steps that press with friction, exact;
    unknown: why none was found.
    """

    edges: tuple[float, ...]
    contact_way: tuple[float, float] | None = None
    stick_way: tuple[float, float] | None = None
    first: float | None = None
    stops: tuple["Stop", ...] = ()
    exact: bool = False
    fineness: float = 1.0
    early: float | None = None
    pressed: tuple[float, ...] = ()
    unknown: str = ""

    def sweeps(self, k: float, facet: float, edge_facet: float) -> tuple[tuple[float, float, float], ...]:
        """Intervals (from, to, facet length) over which edges move, on both sides.

        For k < 0 traction ends the more steeply: facets are so small that an edge costs twice what it does at k = 0.
        Where pressure ends too, it costs ON_THE_WAY; for k < 0 facets there only come close to ``edge_facet``. At a
        stop they are smaller the smaller q is in that state, so that its relative error is that of the others. The
        first contact has FIRST facets on either side. After pressing with friction contact ends in facets of the way,
        but has its place in them.
        """
        wanted = AT_STOPS[self.early is not None] * expected_error(0.0, facet)
        steep = min(size_for(wanted, min(k, 0.0)), facet / self.fineness)
        if self.early is not None:
            steep = max(steep, facet / FINEST)
        ways = []
        if self.stick_way and steep < facet:
            ways.append((*self.stick_way, max(steep, edge_facet)))
        if self.early and self.contact_way and self.early - FURTHER_INSIDE < self.contact_way[0]:
            ways.append((self.early - FURTHER_INSIDE, self.contact_way[0], max(steep / EARLY, edge_facet)))
        if self.contact_way:
            size = min(size_for(ON_THE_WAY[k < 0] * expected_error(0.0, facet), k), facet / 2)
            if k < 0:
                size = max(size, edge_facet**0.9 * facet**0.1)
            size = max(size, (self.contact_way[1] - self.contact_way[0]) / FACETS_OF_WAY)
            ways.append((*self.contact_way, max(size, edge_facet)))
        error = STOP[k < 0] * facet**2  # that of the smooth part of q falls like this too
        for stop in self.stops:
            apart = min((abs(stop.x - x) for x in {*self.edges, *(s.x for s in self.stops)} - {stop.x}), default=1.0)
            size = min(size_for(error * stop.share, k), facet / 2, apart / FACETS)
            ways.append((stop.x, stop.x, max(size, edge_facet)))
        if self.first:
            ways.append((0.0, 2 * self.first, self.first / FIRST))
        ways += [(x, x, max(steep, edge_facet)) for x in self.pressed]
        return tuple(sorted({*ways, *((-right, -left, size) for left, right, size in ways)}))


class Stop(NamedTuple):
    """Place x > 0 of an edge after a load step, and q in that state over mu p (L2) and over the turns of the edge."""

    x: float
    share: float


def expected_edges(
    scene: Scene, scaled: Scaled, loop: FrettingLoop | None, effects: Effects, schedule: Sequence[LoadStep]
) -> ExpectedEdges:
    """From the closed form or, where it is another problem, from a rough half-plane solution.

    schedule: its first load has Q = 0.
    """
    if effects.has_closed_form:
        contact = scaled.contact
        assert contact is not None  # has_closed_form
        a = contact.a
        if loop is None and not scene.friction:
            points = [P / scene.P for P, _ in scene.load.points] if scene.is_path else [1.0]
            edges = several([a, *(contact.half_width(log(P)) for P in points[::-1])])
            widths = {contact.half_width(log(step.P)) for step in schedule}
            passed = [(x, 1.0) for x in widths if all(abs(x - edge) > ONE_EDGE for edge in edges)]
            return ExpectedEdges(edges, stops=stops_at(passed), exact=True)
        states = SpringPath(contact, scene.mu).run([(step.P, step.Q) for step in schedule])
        if loop is None:
            edges = np.array([(state.contact_half_width, state.stick_half_width) for state in states])
            stops = stops_at(_stops(states, contact_moves=True), MERGED * scene.cell_sizes["edge_facet"])
            return ExpectedEdges(_at_points(schedule, edges), stops=stops, exact=True)
        shares = (0.5, 0.0, -0.5) if scene.mesh.edges == "states" else ()
        between = [loop.active_half_width(share * loop.Q_A, "unloading") for share in shares]
        return ExpectedEdges((loop.c, a, *between), stops=stops_at(_stops(states)), exact=True)
    try:
        return _rough_edges(scene, scaled, effects, schedule)
    except (RuntimeError, ValueError) as reason:  # none to stop: the mesh is only less well graded
        return ExpectedEdges((1.0,), unknown=str(reason))


def share_of_limit(q, p, mu: float) -> float:
    """Size of q over that of its limit mu p, in L2, from values at points that stand for equal lengths."""
    return float(np.linalg.norm(q) / (mu * np.linalg.norm(p)))


def _stops(states, contact_moves: bool = False) -> Iterable[tuple[float, float]]:
    """Of states of a SpringPath places and shares of q: edges of stick, each once, and of contact if they move."""
    seen = set()  # on the way up q is what it was on the way down, with the other sign
    width, p = 0.0, np.zeros(0)
    for state in states:
        a, c, turns = state.contact_half_width, state.stick_half_width, len(state.memory.P)
        if (key := (round(a, 9), round(c, 9), turns)) in seen or not (contact_moves or c < a):
            continue
        seen.add(key)
        x = a * np.linspace(-1.0, 1.0, SAMPLES + 2)[SAMPLES // 2 + 1 : -1]  # half of them: p and q are even
        if a != width:
            width, p = a, state.pressure(x)
        share = share_of_limit(state.traction(x), p, state.memory.mu)
        if contact_moves:  # where q ends too, if there is any
            yield a, share or 1.0
        if c < a:
            yield c, share if turns <= 3 else share / TURNED


def stops_at(found: Iterable[tuple[float, float]], merged: float = 1e-9) -> tuple[Stop, ...]:
    """Stops from places x and shares of q: places within ``merged`` are one, in their middle, with the least share."""
    groups: list[list[tuple[float, float]]] = []
    for stop in sorted(found):
        if groups and stop[0] - groups[-1][0][0] < merged:
            groups[-1].append(stop)
        else:
            groups.append([stop])
    stops = (Stop((group[0][0] + group[-1][0]) / 2, min(share for _, share in group)) for group in groups)
    return tuple(stop for stop in stops if stop.share > 0.0)


def _at_points(schedule, edges) -> tuple[float, ...]:
    """Of edges (s, n) after each load step those at the points of a path, of which the last comes first, however many
    load steps lie between; and the widest of all."""
    pairs = enumerate(zip(schedule, schedule[1:]))
    reached = [n for n, (step, after) in pairs if step.state or step.branch != after.branch]
    return several([np.nanmax(edges), *edges[[len(edges) - 1, *reached[::-1]]].ravel()])


def _rough_edges(scene, scaled, effects, schedule):
    """Of a loop where it turns, of a path at its points."""
    solver = half_plane_solver(scene, scaled, effects, NODES)
    if scene.is_loop:
        return _rough_edges_of_loop(scene, solver, next(step.Q for step in schedule if step.Q))
    edges = np.abs([(*state.contact, *state.stick) for state in solver.run([step.load for step in schedule])])
    way = float(np.nanmin(edges)), float(np.nanmax(edges))
    return ExpectedEdges(_at_points(schedule, edges), stick_way=way, fineness=FINER_WITH_COUPLING)


def _rough_edges_of_loop(scene, solver, first_Q) -> ExpectedEdges:
    """From one cycle with few load steps, with twice as many nodes should it fail; first_Q: of the run itself."""
    friction_first = solver.friction_in_normal_stage
    steps = pressing(1.0, ROUGH_PRESSING if friction_first else 1, power=1.0)
    loads = [step.load for step in steps + rocking(1.0, scene.load.amplitude * solver.mu, 1, ROUGH_QUARTER)]
    try:
        states = solver.run(loads)
    except ContactNotConverged:
        states = replace(solver, nodes=2 * solver.nodes).run(loads)
    cycle = states[-4 * ROUGH_QUARTER - 1 :]
    contact, stick = (np.array([getattr(state, name) for state in cycle]) for name in ("contact", "stick"))
    turned = stick[:: 2 * ROUGH_QUARTER]
    # the first loading's edges of stick lie inside the later ones, where nothing smooths what it left
    ends = [*contact[-1], *turned[-1], *np.array([turned.min(axis=0), turned.max(axis=0)]).T.ravel()]
    if scene.mesh.edges == "states":
        ends += [*contact.ravel(), *stick.ravel()]
    edges, way = several(ends), np.abs(contact)
    return ExpectedEdges(
        edges,
        contact_way=(float(way.min()), float(way.max())),
        stick_way=(min(edges), float(way.max())),
        fineness=FINER_WITH_COUPLING,
        early=float((1 - first_Q / solver.mu) ** (1 / (2 + scene.k))),  # (48)
        first=1 / scene.solver.normal_increments if friction_first else None,
    )


def several(edges) -> tuple[float, ...]:
    """Their distances from the middle, each once: the widest, to which contact reaches, and the first of the others."""
    edges = np.abs(edges)
    edges = edges[np.isfinite(edges)]
    kept: list[float] = []
    for edge in [edges.max(), *edges]:
        if all(abs(edge - other) > ONE_EDGE for other in kept):
            kept.append(float(edge))
    return tuple(kept[:MOST])
