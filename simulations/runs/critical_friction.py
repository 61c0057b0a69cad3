"""The coefficient of friction of a scene beside the critical one, above which rates of stick and slip are not unique.

docs/critical_friction.md says what the bounds are bounds of.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf, isfinite
from typing import TYPE_CHECKING

from analytic import GradedHalfPlane, PowerLawKernel
from analytic.half_plane.critical_friction import (
    ELEMENTS,
    CriticalFriction,
    RateOperator,
    critical_friction,
    sliver_singular,
)

from ..scene.effects import Effects
from ..scene.scene import Scene
from ..solvers.condensed.system import CondensedSystem

if TYPE_CHECKING:
    from .simulation import Simulation

OTHER_METHOD = "solver.theta = 0 or a larger solver.gamma0 may help"
ELASTIC_SLIP = 0.03  # over mu P/E(a): smooths what an edge of contact leaves, docs/stability.md
PLACES = 12  # of a sliver on the mesh
LARGEST = 400  # surface nodes in contact for which the mesh's own bound is looked for


def expected(scene: Scene, effects: Effects) -> CriticalFriction | None:
    """Bounds for equal surface elements on the half-plane; None without coupling, where rates are always unique.

    The patterns are as short as elements: of a coating the power law at its surface is taken.
    """
    return _of_half_plane(scene.k, scene.solid.nu) if "coupling" in effects else None


@lru_cache
def _of_half_plane(k, nu):
    return critical_friction(RateOperator.of(PowerLawKernel(GradedHalfPlane(1.0, nu, k, 1.0))))


def of_mesh(simulation: Simulation) -> float | None:
    """Smallest mu known to leave the rates on the mesh of a finished run without a unique solution. On rank 0.

    inf where none is known; None without coupling, without the condensed system, for too many nodes in contact, and
    on other ranks.
    """
    system = simulation.solver.system
    if simulation.body.mesh.comm.rank:
        return None
    closed = simulation.history.entries[-1].surface.pressure > 0
    is_small = 3 <= closed.sum() <= LARGEST
    if "coupling" not in simulation.effects or not isinstance(system, CondensedSystem) or not is_small:
        return None
    compliance, m = system.compliance.nodal(closed), int(closed.sum())
    x, y = slice(m), slice(m, 2 * m)
    blocks = (compliance[row, column] for row in (x, y) for column in (x, y))
    return sliver_singular(RateOperator.from_compliance(*blocks), PLACES)[0]


def side(scene: Scene) -> str:
    """``describe`` of any scene with friction; "no coupling" where rates are always unique."""
    critical = expected(scene, Effects(scene))
    return "no coupling" if critical is None else describe(scene, critical)


def describe(scene: Scene, critical: CriticalFriction) -> str:
    """On which side of the bounds the scene lies."""
    if not isfinite(critical.upper):
        return f"mu = {scene.mu:g}: no second rate solution is known for any mu"
    bounds = f"{critical.lower:.3g} and {critical.upper:.3g} of {ELEMENTS} equal half-plane elements"
    if scene.mu <= critical.lower:
        return f"mu = {scene.mu:g} is below the bounds {bounds}: rates of stick and slip are unique"
    if scene.mu < critical.upper:
        return f"mu = {scene.mu:g} is between the bounds {bounds}: rates of stick and slip are not known to be unique"
    return f"mu = {scene.mu:g} is above the bounds {bounds}: rates of stick and slip are not unique"


def numbers(critical: CriticalFriction | None) -> dict[str, float | str | None]:
    """For summary.json: ``lower`` and ``upper``, None where there is no bound, and the ``pattern`` of the upper one."""
    values = vars(critical or CriticalFriction(inf, inf, ""))
    return {name: None if value == inf else value for name, value in values.items()}


def why_no_answer(simulation: Simulation) -> str:
    """What may leave a load step without an answer, and what can be done; "" where rates are unique."""
    scene = simulation.scene
    critical = expected(scene, simulation.effects) if scene.friction else None
    if critical is None or scene.mu <= critical.lower:
        return ""
    return f"{describe(scene, critical)}; {_elastic_slip(simulation)} or a smaller load.mu may help"


def _elastic_slip(simulation) -> str:
    """The key with a value that may help."""
    return f"effects.elastic_slip = {ELASTIC_SLIP * simulation.mu * simulation.scaled.scales.displacement:.1g} m"


def cause(simulation: Simulation) -> str:
    """Why tractions may go up and down from node to node, and what can be done. On rank 0."""
    scene = simulation.scene
    critical, own = expected(scene, simulation.effects), of_mesh(simulation)
    slip = _elastic_slip(simulation)
    remedy = f"{slip}, a smaller load.mu or another mesh.degree may help"
    smoother = f"{slip}, a smaller mesh.edge_facet or another number of solver.increments may help"
    if scene.solver.theta > 0:
        return f"with solver.theta = {scene.solver.theta} not every gamma0 is stable: {OTHER_METHOD}"
    if critical is None:
        return f"rates of stick and slip are unique without coupling: {smoother}"
    if own is None:
        return f"{describe(scene, critical)}: {remedy if scene.mu > critical.lower else smoother}"
    if scene.mu >= own:
        lost = "from where on Coulomb's law has no unique rate solution on this mesh"
        return f"mu = {scene.mu:g} is above {own:.3g}, {lost}: {remedy}"
    known = "up to where no second rate solution is known on this mesh"
    return f"mu = {scene.mu:g} is below {own:.3g}, {known}: {smoother}"
