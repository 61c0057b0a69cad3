"""The coefficient of friction of a scene beside the critical one, above which rates of stick and slip are not unique.

docs/critical_friction.md says what the bounds are bounds of.
"""

from functools import lru_cache
from math import inf, isfinite

from analytic import GradedHalfPlane, PowerLawKernel
from analytic.half_plane.critical_friction import ELEMENTS, CriticalFriction, RateOperator, critical_friction

from ..scene.effects import Effects
from ..scene.scene import Scene
from .plan import Plan

LONGER = 3.0  # times as long as an elastic slip that did not help
ELASTIC_SLIP = 0.03  # over mu P/E(a): smooths what an edge of contact leaves, docs/stability.md


def expected(scene: Scene, effects: Effects) -> CriticalFriction | None:
    """Bounds for equal surface elements on the half-plane; None without coupling, where rates are always unique.

    The patterns are as short as elements: of a coating the power law at its surface is taken.
    """
    return of_half_plane(scene.k, scene.solid.nu) if "coupling" in effects else None


@lru_cache
def of_half_plane(k: float, nu: float) -> CriticalFriction:
    """The same bounds at k and ν alone."""
    return critical_friction(RateOperator.of(PowerLawKernel(GradedHalfPlane(1.0, nu, k, 1.0))))


def side(scene: Scene) -> str:
    """``describe`` of any scene with friction; "no coupling" where rates are always unique."""
    critical = expected(scene, Effects(scene))
    return "no coupling" if critical is None else describe(scene, critical)


def describe(scene: Scene, critical: CriticalFriction) -> str:
    """On which side of the bounds the scene lies."""
    if not isfinite(critical.upper):
        return f"mu = {scene.mu:g}: no second rate solution is known for any mu"
    law = "" if scene.is_power_law else " with E(y) as at the surface of the coating"
    bounds = f"{critical.lower:.3g} and {critical.upper:.3g} of {ELEMENTS} equal half-plane elements{law}"
    if scene.mu <= critical.lower:
        return f"mu = {scene.mu:g} is below the bounds {bounds}: rates of stick and slip are unique"
    if scene.mu < critical.upper:
        return f"mu = {scene.mu:g} is between the bounds {bounds}: rates of stick and slip are not known to be unique"
    return f"mu = {scene.mu:g} is above the bounds {bounds}: rates of stick and slip are not unique"


def numbers(critical: CriticalFriction | None) -> dict[str, float | str | None]:
    """For summary.json: ``lower`` and ``upper``, None where there is no bound, and the ``pattern`` of the upper one."""
    values = vars(critical or CriticalFriction(inf, inf, ""))
    return {name: None if value == inf else value for name, value in values.items()}


def why_no_answer(plan: Plan) -> str:
    """What may leave a load step with friction without an answer, and what can be done; "" where rates are unique."""
    scene = plan.scene
    critical = expected(scene, plan.effects) if scene.friction else None
    if critical is None or scene.mu <= critical.lower:
        return ""
    return f"{describe(scene, critical)}; {elastic_slip(plan)} or a smaller load.mu may help"


def elastic_slip(plan: Plan) -> str:
    """The key with a value that may help, longer than the one that the scene has."""
    usual, tried = ELASTIC_SLIP * plan.mu * plan.scaled.scales.displacement, plan.scene.effects.elastic_slip or 0.0
    length = max(usual, LONGER * tried)
    return f"effects.elastic_slip = {length:.1g} m"
