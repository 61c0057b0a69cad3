"""Quick estimate, with coupling, of where contact and stick will end during fretting: a mesh can be graded to it."""

from dataclasses import dataclass, replace

import numpy as np

from .linear import ContactNotConverged
from .solver import HalfPlaneContact

PRESSING = 4  # increments of the normal stage if friction acts in it


@dataclass(frozen=True)
class EdgeEstimate:
    """Left and right ends [length] of contact and stick.

    contact, stick: at +Q_A at the end of the cycle. contact_range, stick_range: shape (2, 2), for the left and the
    right edge the least and the greatest place between ±Q_A; stick's at the ends of the branches only: in between it
    starts anew at the edge of contact. contact_states, stick_states: shape (4 steps + 1, 2), at all states of the
    cycle, of which the middle one is at -Q_A.
    """

    contact: tuple[float, float]
    stick: tuple[float, float]
    contact_range: np.ndarray
    stick_range: np.ndarray
    contact_states: np.ndarray
    stick_states: np.ndarray


def contact_edges(solver: HalfPlaneContact, P: float, Q_A: float, steps: int = 2) -> EdgeEstimate:
    """Edges of fretting under P between ±Q_A [stress x length], from one coarse cycle of ``solver``.

    steps: increments a quarter cycle. With 80 nodes, against 200 and 4 steps, for -0.5 <= k <= 0.7 and mu up to 0.6,
    contact is met to 0.7 % and stick to 0.2 % of the contact's half-width. Should the cycle fail, twice as many nodes
    are tried; then ContactNotConverged. ValueError as by HalfPlaneContact.
    """
    pressing = PRESSING if solver.friction_in_normal_stage else 1
    share = np.arange(1, steps + 1) / steps
    branch = np.linspace(1, -1, 2 * steps + 1)[1:]
    loads = [(P * (i + 1) / pressing, 0.0) for i in range(pressing)]
    loads += [(P, Q_A * s) for s in (*share, *branch, *-branch)]
    try:
        states = solver.run(loads)
    except ContactNotConverged:
        states = replace(solver, nodes=2 * solver.nodes).run(loads)
    cycle = states[-4 * steps - 1 :]
    ends = cycle[0], cycle[2 * steps], cycle[-1]
    contact = np.array([state.contact for state in cycle])
    stick = np.array([state.stick for state in ends])
    return EdgeEstimate(
        contact=ends[-1].contact,
        stick=ends[-1].stick,
        contact_range=np.array([contact.min(axis=0), contact.max(axis=0)]).T,
        stick_range=np.array([stick.min(axis=0), stick.max(axis=0)]).T,
        contact_states=contact,
        stick_states=np.array([state.stick for state in cycle]),
    )
