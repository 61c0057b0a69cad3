"""Where contact and stick zone will end, before anything is solved: what the mesh is graded to."""

import numpy as np

from analytic import FrettingLoop, HalfPlaneContact, contact_edges
from analytic.half_plane_linear import ContactNotConverged

from .effects import Effects
from .scaling import Scaled
from .scene import Scene

NODES = 80  # of the half-plane solver: edges to about 1e-3 of the half-width
APART = 0.02  # edges closer than this (over the half-width) are one
MOST = 8  # edges on either side


def half_plane_solver(scene: Scene, scaled: Scaled, effects: Effects, nodes: int = 300) -> HalfPlaneContact:
    """The mesh-free solver of the same problem, in scaled units."""
    return HalfPlaneContact(
        scaled.kernel,
        scaled.indenter,
        mu=scene["load.mu"] if scene.friction else 1.0,
        coupling="coupling" in effects,
        friction_in_normal_stage="friction in normal stage" in effects,
        nodes=nodes,
    )


def expected_edges(
    scene: Scene, scaled: Scaled, loop: FrettingLoop | None, effects: Effects, loads: list[tuple[float, float]]
) -> tuple[float, ...]:
    """Positions > 0 of edges, from the closed form or, where it is another problem, from a rough half-plane solution.

    loads: (P, Q) of the programme, the first with Q = 0.
    """
    if scene.has_closed_form:
        return (scaled.contact.a,) if loop is None else (loop.c, scaled.contact.a)
    try:
        edges = _rough_edges(scene, scaled, effects, loads)
    except (ContactNotConverged, ValueError):  # no reason to stop: the mesh is only less well graded
        return (1.0,)
    return distinct(np.abs(edges[np.isfinite(edges)]), APART)[:MOST]


def _rough_edges(scene, scaled, effects, loads):
    """Edges of contact and stick, (n,): of a loop where it turns, of other programmes at every load, the last first."""
    solver = half_plane_solver(scene, scaled, effects, NODES)
    if scene.is_loop:
        Q_A = scene["load.amplitude"] * solver.mu
        first = solver.friction_in_normal_stage
        found = contact_edges(solver.kernel, solver.profile, 1.0, solver.mu, Q_A, solver.coupling, first, NODES)
        return np.array([*found.contact, *found.stick])
    return np.array([edge for state in solver.run(loads)[::-1] for edge in (*state.contact, *state.stick)])


def distinct(values, apart: float) -> tuple[float, ...]:
    """Those of ``values`` that are further than ``apart`` from the ones before them."""
    kept: list[float] = []
    for value in values:
        if all(abs(value - other) > apart for other in kept):
            kept.append(float(value))
    return tuple(kept)
