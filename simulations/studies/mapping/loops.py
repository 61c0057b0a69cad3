"""Fretting loops with coupling by the mesh-free half-plane solver: energy per cycle and its density, quickly."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from analytic import ContactNotConverged, GradedHalfPlane, HalfPlaneContact, PowerProfile
from analytic.half_plane.state import ContactState

from ...loading.schedule import pressing, rocking

# increments per quarter cycle and nodes of the solver; the next pair is tried where one does not converge
ATTEMPTS = ((4, 100), (4, 130), (5, 110), (7, 100), (10, 100))
POINTS = 2001  # at which the largest energy density is sought


@dataclass(frozen=True)
class SimulatedLoop:
    """States of pressing, first loading and cycles of ``quarter`` increments per Q_A; lengths, stresses as in solid."""

    states: list[ContactState]
    mu: float
    quarter: int

    @property
    def last_cycle(self) -> list[ContactState]:
        """States of the last cycle with the one it starts from."""
        return self.states[-4 * self.quarter - 1 :]

    @property
    def dissipated_energy(self) -> float:
        """Energy of the last cycle [stress x length²]."""
        cycle = self.last_cycle
        return float(cycle[-1].dissipated_energy - cycle[0].dissipated_energy)

    def energy_density(self, x) -> np.ndarray:
        """Energy dissipated in the last cycle per area at x (n,) [stress x length]: mu p over the path slipped."""
        density, cycle = np.zeros(len(x)), self.last_cycle
        for before, after in pairwise(cycle):
            pressure = (before.pressure_at(x) + after.pressure_at(x)) / 2
            density += self.mu * pressure * np.abs(after.slip_at(x) - before.slip_at(x))
        return density

    def peak_density(self) -> float:
        """Largest energy density [stress x length]."""
        left = min(state.contact[0] for state in self.last_cycle)
        right = max(state.contact[1] for state in self.last_cycle)
        return float(self.energy_density(np.linspace(left, right, POINTS)).max())


def simulate(
    solid: GradedHalfPlane,
    profile: PowerProfile,
    P: float,
    mu: float,
    amplitude: float,
    cycles: int = 2,
    attempts=ATTEMPTS,
) -> SimulatedLoop:
    """Coupled loop of amplitude Q_A/(mu P). Two cycles: the energy of the first one is off by up to a few per cent.

    Raises ContactNotConverged where no attempt converges.
    """
    failure = ContactNotConverged("no attempt was asked for")
    for quarter, nodes in attempts:
        solver = HalfPlaneContact(solid, profile, mu=mu, nodes=nodes)
        try:
            states = solver.run(step.load for step in pressing(P) + rocking(P, amplitude * mu * P, cycles, quarter))
        except ContactNotConverged as reason:
            failure = reason
        else:
            return SimulatedLoop(states, mu, quarter)
    raise failure
