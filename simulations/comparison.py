"""A run beside the closed forms: relative errors where they describe the same problem, differences otherwise."""

import numpy as np

from analytic import CylinderContact, FrettingLoop

from .history import Entry, History


def relative_l2(weight, computed, exact) -> float:
    """sqrt(∫ (computed - exact)² dx / ∫ exact² dx) with nodal ``weight``; nan where exact vanishes."""
    norm = weight @ exact**2
    return float(np.sqrt(weight @ (computed - exact) ** 2 / norm)) if norm > 0 else float("nan")


def compare_state(entry: Entry, contact: CylinderContact, loop: FrettingLoop | None) -> dict[str, float]:
    """Relative L2 deviations over the contact of one state from the closed forms (44), [X5]."""
    increment, surface = entry.increment, entry.surface
    x, weight = surface.x, surface.weight
    under = weight * (np.abs(x) <= contact.a)
    deviation = {"pressure_l2": relative_l2(weight, surface.pressure, contact.pressure(x))}
    if increment.branch != "normal":
        state = {"Q": increment.Q, "branch": increment.branch}
        deviation["traction_l2"] = relative_l2(weight, surface.traction, loop.traction(x, **state))
        deviation["slip_l2"] = relative_l2(under, entry.slip, -loop.slip(x, **state))
    return deviation


def compare(history: History, contact: CylinderContact, loop: FrettingLoop | None) -> dict[str, float]:
    """Deviations of a run: fields, a and c at its last state, energy of its last cycle (signed where scalar)."""
    last = history.entries[-1]
    deviation = compare_state(last, contact, loop) | {"a": last.a / contact.a - 1}
    if loop is not None:
        deviation["c"] = last.c / loop.c - 1
        if history.has_cycle:
            deviation["dissipated_energy"] = history.dissipated_per_cycle / loop.dissipated_energy - 1
    return deviation


def worst(history: History, contact: CylinderContact, loop: FrettingLoop) -> dict[str, float]:
    """The largest field deviations over every state of the last cycle."""
    states = [compare_state(entry, contact, loop) for entry in history.last_cycle]
    return {name: float(np.nanmax([state[name] for state in states])) for name in states[0]}
