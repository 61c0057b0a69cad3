"""The reference of scenes that no closed form describes: the mesh-free half-plane solver with coupling."""

import numpy as np

from analytic import HalfPlaneContact, PowerProfile
from analytic.half_plane_linear import ContactNotConverged
from analytic.half_plane_state import ContactState

from .comparison import relative_l2
from .history import History
from .simulation import Simulation

NAME = "mesh-free half-plane solver with coupling"


class NoReference(RuntimeError):
    """The half-plane solver could not do what the finite elements did; the message says why."""


def solve(simulation: Simulation) -> list[ContactState]:
    """States of the half-plane solver at the loads of a simulation, in scaled units; NoReference where it fails."""
    parabola = PowerProfile(0.5, 2)  # f = x²/2
    solver = HalfPlaneContact(
        simulation.contact.solid,
        parabola,
        mu=simulation.loop.mu,
        coupling=simulation.effects.coupling,
        friction_in_normal_stage=simulation.effects.friction_in_normal_stage,
    )
    try:
        return solver.run([(increment.P, increment.Q) for increment in simulation.programme])
    except ContactNotConverged as failure:
        raise NoReference(str(failure)) from None


def errors(history: History, states: list[ContactState]) -> dict[str, float]:
    """Relative deviations of a run's last state and cycle from the half-plane solver's."""
    last, state = history.entries[-1], states[-1]
    x, weight = last.surface.x, last.surface.weight
    left, right = state.contact

    def at_nodes(values):
        return np.interp(x, state.x, values, left=0.0, right=0.0)

    inside = weight * ((x > left) & (x < right))
    deviation = {
        "pressure_l2": relative_l2(weight, last.surface.pressure, at_nodes(state.pressure)),
        "traction_l2": relative_l2(weight, last.surface.traction, at_nodes(state.traction)),
        "slip_l2": relative_l2(inside, last.slip, at_nodes(state.slip)),
        "a": last.a / (0.5 * (right - left)) - 1,
        "c": last.c / (0.5 * (state.stick[1] - state.stick[0])) - 1,
    }
    if history.has_cycle:
        start = states[len(states) - len(history.last_cycle) - 1]
        dissipated = state.dissipated_energy - start.dissipated_energy
        deviation["dissipated_energy"] = history.dissipated_per_cycle / dissipated - 1
    return deviation
