"""Expected edges of contact and stick zone under bulk strain: the mesh is graded to them."""

import numpy as np

from analytic import StretchedLoop

from ..fem.load import Load
from ..scene import Scene, SceneError
from ..scene.effects import Effects
from ..scene.scaling import Scaled
from .expected_edges import NODES, SAMPLES, TURNED, ExpectedEdges, half_plane_solver, several, share_of_limit, stops_at
from .limits import NARROWEST

FINER_FACETS = 6.0  # facets on the ways of the edges of stick where these are not known exactly


def exact_edges(loop: StretchedLoop, loads: list[Load]) -> ExpectedEdges:
    """The stick zone of a schedule's every load step is moved aside, [X7]; loop: in the units of the loads."""
    a, ends = loop.loop.a, loop.shift + loop.c * np.array([-1.0, 1.0])
    x = a * np.linspace(-1.0, 1.0, SAMPLES + 2)[1:-1]
    p, found = loop.loop.contact.pressure(x), []
    for before, load in zip(loads, loads[1:]):
        branch = "unloading" if load.Q < before.Q else "initial"
        if abs(load.Q) == loop.loop.Q_A or (branch == "initial" and before.Q < 0):
            continue  # an edge where the load turns; or the mirror image of an unloading
        centre, c = loop.zone(load.Q, branch)
        kink = 1.0 if branch == "initial" else TURNED
        share = share_of_limit(loop.traction(x, load.Q, branch), p, loop.loop.mu) / kink
        found += [(abs(end), share) for end in (centre - c, centre + c) if round(abs(end) / a, 9) < 1.0]
    return ExpectedEdges(several([*ends / a, 1.0]), stops=stops_at(found), exact=True)


def rough_edges(scene: Scene, scaled: Scaled, effects: Effects, loads: list[Load]) -> ExpectedEdges:
    """Beyond the closed form, from a rough half-plane solution under the ``loads`` of a loop with few load steps.

    SceneError where the whole contact slips.
    """
    Q_A, states = max(abs(load.Q) for load in loads), []
    solver = half_plane_solver(scene, scaled, effects, NODES)
    try:
        for state in solver.increments(loads):
            states.append(state)
            if abs(state.Q) == Q_A:  # at once: what follows takes the longer the less sticks
                _check_stick(scene, state)
    except (RuntimeError, ValueError) as reason:  # none to stop: the mesh is only less well graded
        return ExpectedEdges((1.0,), unknown=str(reason))
    turns = [state for state in states[::-1] if abs(state.Q) == Q_A]
    shown = states[::-1] if scene.bulk_phase or scene.mesh.edges == "states" else turns
    contact = np.abs([state.contact for state in states if state.Q])
    edges = several([edge for state in shown for edge in (*state.contact, *state.stick)])
    way = (float(contact.min()), float(contact.max())) if "coupling" in effects else None
    sticks = np.array([state.stick for state in states if state.Q or state.strain])
    crossed = (sticks[:, 0].max() > 0) or (sticks[:, 1].min() < 0)  # the middle
    stick_way = 0.0 if crossed else float(np.abs(sticks).min()), float(contact.max())
    return ExpectedEdges(edges, contact_way=way, stick_way=stick_way, fineness=FINER_FACETS)


def _check_stick(scene, state):
    stick = np.ptp(state.stick_zones, axis=1).max(initial=0.0)
    if stick < NARROWEST * min(scene.mesh.edge_facet, scene.mesh.facet):
        key = "bulk_strain" if scene.load.bulk_stress is None else "bulk_stress"
        raise SceneError(
            f"load.{key} = {getattr(scene.load, key):g} is not allowed: it makes the whole contact slip, only "
            f"{stick:.1g} a would stick at Q_A; less strain, or a smaller load.amplitude"
        )
