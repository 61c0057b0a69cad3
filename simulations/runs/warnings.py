"""What theory or mesh show badly though a run is possible, in words; "" or nothing where they show it well.

Every bound is measured (docs/stability.md). All lengths are in contact half-widths.
"""

from math import inf

import numpy as np

from analytic import FrettingLoop, PowerProfile, PressingWithFriction, normal_contact

from ..fem.mesh import Grading
from ..scene import Scene, rounded
from ..scene.scaling import Scaled
from ..scene.steepness import steepness_warning

NARROWEST_STICK = 5.0  # c over edge_facet: there c is off by 3 %, with 4 by 20 %, with 1 it is lost
LONG_ELASTIC_SLIP = 0.1  # over mu P/E(a)
NARROWEST_PEAK = 20.0  # c of pressing with friction over the distance of nodes: the peak is 5 % low at 11
BLUNTED = 0.01  # of the peak under a sharp tip, by which the mean over the distance of nodes may be lower
SAMPLES = 4001  # of a formula, up to the end of the domain


def warnings_of(scene: Scene, cells: Grading, loop: FrettingLoop | None, scaled: Scaled) -> list[str]:
    """A steep indenter, one that falls again, edges that were not found, a long elastic slip, a narrow stick zone.

    The last spoils no more than c: p, q and energy do not feel it.
    """
    found, facet = [steepness_warning(scene.half_width, scene.indenter)], min(cells.edge_facet, cells.facet)
    found.append(_touches_again(scene, cells, scaled))
    if cells.unknown:
        found.append(f"the mesh is fine at x = a and -a only, as the edges were not found before: {cells.unknown}")
    if loop is not None and loop.c < NARROWEST_STICK * facet:
        found.append(
            f"mesh.edge_facet = {cells.edge_facet:g} is too coarse for c/a: the stick half-width is {loop.c:.2g} a at "
            f"load.amplitude = {scene.load.amplitude} and needs {rounded(loop.c / NARROWEST_STICK):g} or less"
        )
    soft = scaled.elastic_compliance(scene) / 2
    if soft > LONG_ELASTIC_SLIP:
        found.append(
            f"effects.elastic_slip = {scene.effects.elastic_slip:g} m is {soft:.2g} mu P/E(a), which is long: at 0.1 "
            "the energy of a cycle with load.amplitude = 0.9 is 4 % too large, at 0.3 16 %, with small amplitudes more"
        )
    return [words for words in found if words]


def hidden_peak(pressing: PressingWithFriction | None, spacing: float, scaled: Scaled) -> str:
    """What to say of a peak of pressure at x = 0, in a narrow stick zone or none, that nodes ``spacing`` a apart miss.

    Friction from first contact makes it: slip from both sides meets there. "" where the nodes show it.
    """
    if pressing is None or pressing.stick_half_width > NARROWEST_PEAK * spacing:
        return ""
    zone, peak = "where every point slips", "infinite"
    if pressing.stick_ratio:
        zone = f"in a stick zone of half-width {pressing.stick_half_width:.2g} a"
        peak = f"{pressing.pressure(0.0) * scaled.scales.stress:.3g} Pa"
    return (
        f"the pressure peaks at x = 0, {zone}, and nodes are {spacing:.2g} a apart there: the exact peak after "
        f"pressing is {peak}, the one of this mesh is lower, and it is not compared"
    )


def hidden_tip(spacing: float, scaled: Scaled) -> str:
    """What to say of the pressure under a tip f ~ |x|^order, sharper than a parabola, that nodes ``spacing`` a apart
    miss.

    There p falls from its peak like |x|^(order+k-1), from an infinite one for order + k <= 1. "" where the nodes show
    it.
    """
    order = scaled.indenter.order
    if order >= 2.0:
        return ""
    tip = normal_contact(scaled.solid, PowerProfile(1.0, order), 1.0)
    length = spacing * tip.a
    if tip.pressure_within(length / 2) / length > (1 - BLUNTED) * tip.pressure(0.0):
        return ""
    peak = "not known"
    if scaled.contact is not None:
        exact = float(scaled.contact.pressure(0.0)) * scaled.scales.stress
        peak = f"{exact:.3g} Pa" if exact < inf else "infinite"
    return (
        f"the pressure peaks at x = 0, under a tip f ~ |x|^{order:g}, and nodes are {spacing:.2g} a apart there: the "
        f"exact peak under the largest load without coupling is {peak}, the one of this mesh is lower, and it is not "
        "compared"
    )


def _touches_again(scene: Scene, cells: Grading, scaled: Scaled) -> str:
    """Where a formula falls again beside the surface on which contact is looked for; "" where it does not."""
    if scene.indenter.profile != "formula":
        return ""
    x = np.linspace(cells.strip, cells.extent, SAMPLES)
    with np.errstate(all="ignore"):
        height = scaled.indenter.height(x)
    falls = height < height[0]
    if not falls.any():
        return ""
    at, reach = x[np.argmax(falls)] * scaled.scales.length, cells.strip * scaled.scales.length
    return (
        f"indenter.formula falls again: at x = {at:.3g} m it is below its value at {reach:.3g} m, up to which contact "
        "is looked for; what may touch there is left out"
    )
