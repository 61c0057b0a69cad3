"""Coupled loops solved without load steps, before any finite element: edges for the mesh, states for the reference.

Between two turns of Q each state follows from that at the turn (``analytic.CoupledLoop``). So the edges of contact and
stick after every load step are known, and the mesh has a place for each. The reference takes the same states.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from analytic import CoupledLoop, PowerProfile
from analytic.coupled.loop import ORDER
from analytic.coupled.state import CoupledState

from ..loading.schedule import LoadStep
from ..scene import Scene
from ..scene.effects import Effects
from ..scene.scaling import Scaled
from ..scene.solid import modulus
from .expected_edges import FINER_WITH_COUPLING, MERGED, TURNED, ExpectedEdges, several, share_of_limit, stops_at

LOWEST, HIGHEST = -0.9, 0.9  # k for which docs/accuracy.md has what both orders of the basis differ by
THINNEST = 0.05  # coating over the half-width of contact: edges are known to 5e-6 a there, with 0.02 to 1.4e-4 a
STEEPEST, NEAR = 6.0, 1e-6  # slope of E at the surface over E, times the half-width: q is known to 8e-4 there
STEEP = -0.5  # k below which pressure zigzags where its edge has no place in a facet: by 15 % at k = -0.6
# by degree: smaller facets at edges, over a, gain from better edges; for k < STEEP those of degree 1 at any degree,
# as on larger ones the energy of a load step is known to 1.2e-6 only (k = -0.9)
FINE = {1: 2e-3, 2: 0.02, 3: 0.02}


def serves(scene: Scene, effects: Effects) -> bool:
    """True for coupling on a power law under an even power profile, without bulk strain, at constant P once Q acts; no
    other effect, such as elastic slip. Also on a coating that is not too thin or steep, pressed without friction.
    """
    others = "bulk strain" in effects or effects.without_closed_form
    if "coupling" not in effects or not LOWEST <= scene.k <= HIGHEST or others:
        return False
    if not scene.is_power_law and ("friction in normal stage" in effects or not _is_mild(scene)):
        return False
    profile = scene.shape.analytic()
    return isinstance(profile, PowerProfile) and profile.m % 2 == 0


def _is_mild(scene):
    """Whether a coating changes so little over the half-width of contact that polynomials carry what it adds to u_y."""
    law, a = modulus(scene.material, 1.0, 1.0), scene.half_width
    top = law.kink_depths[0]
    steepness = 0.0 if scene.k else (law.young(NEAR * top) / law.E0 - 1) * a / (NEAR * top)
    return top >= THINNEST * a and abs(steepness) <= STEEPEST


def loop_of(scaled: Scaled, mu: float, effects: Effects | tuple[str, ...], order: int = ORDER) -> CoupledLoop:
    """The loop in scaled units, P = 1; effects: the names of those that are on."""
    coupled, friction_first = "coupling" in effects, "friction in normal stage" in effects
    return CoupledLoop(scaled.kernel, scaled.indenter.analytic(), 1.0, mu, coupled, order, friction_first)


@lru_cache(maxsize=1)
def states_of(loop: CoupledLoop, loads: tuple[tuple[float, float], ...]) -> list:
    """``CoupledLoop.where_known`` at the loads (P, Q), once for mesh and reference of one cycle."""
    return loop.where_known(loads)


def grades(scene: Scene, effects: Effects) -> bool:
    """True where the mesh is graded to the edges of this solution: no closed form has them, and facets so small that
    rough ones do less well.
    """
    if not scene.is_loop or scene.contact_has_closed_form or not serves(scene, effects):
        return False
    return scene.cell_sizes["edge_facet"] < FINE[1 if scene.k < STEEP else scene.mesh.degree]


def loop_edges(scene: Scene, scaled: Scaled, effects: Effects, schedule: Sequence[LoadStep]) -> ExpectedEdges | None:
    """Edges of contact and stick after the load steps of the first cycle that have a state; None where a turn has none.

    A stop of the contact costs q = mu p what it costs p; one of stick costs q alone.
    """
    loads = tuple((step.P, step.Q) for step in schedule if step.cycle <= 1)
    try:
        found = states_of(loop_of(scaled, scene.mu, effects), loads)
    except (RuntimeError, ValueError, ArithmeticError):
        return None
    states = [state for state in found if isinstance(state, CoupledState)]
    states = states[sum(state.branch is None for state in states) - 1 :]  # from the end of pressing on
    Q_A = max(state.Q for state in states)
    ends: list[float] = []
    stops = [(abs(edge), 1.0) for edge in states[0].contact if scene.k < STEEP]  # of pressing: q is 0
    kink = 1.0
    with_friction = "friction in normal stage" in effects
    pressed = states[0]
    if with_friction:  # its q is not 0
        states.insert(0, pressed)
    for before, state in zip(states, states[1:]):
        kink = TURNED if state.Q < before.Q else kink
        edges = (*state.contact, *state.stick)
        length = np.sqrt(state.weight)
        share = share_of_limit(length * state.traction, length * state.pressure, scene.mu)
        if np.isclose(abs(state.Q), Q_A) or (scene.mesh.edges == "states" and _is_quarter(state.Q / Q_A)):
            ends = [*edges, *ends]  # the last first
        else:
            stops += [(abs(edge), float(part)) for edge, part in zip(edges, share / np.array([1.0, 1.0, kink, kink]))]
    stopped = stops_at(stops, MERGED * scene.cell_sizes["edge_facet"])
    expected = ExpectedEdges(several(ends), stops=stopped, exact=True)
    if not with_friction:
        return expected
    slid = pressed.stick[1], pressed.contact[1]  # where points slid while P grew
    first = 1 / scene.solver.normal_increments
    return replace(expected, first=first, stick_way=slid, fineness=FINER_WITH_COUPLING)


def _is_quarter(share):
    return np.isclose(2 * share, round(2 * share))
