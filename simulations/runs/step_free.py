"""Reference of coupled loops: states of the half-plane found directly from the last turn of Q, without load steps."""

from analytic.coupled.loop import ORDER, known
from analytic.half_plane.linear import ContactNotConverged

from .coupled_loop import loop_of, states_of
from .history import Entry
from .mesh_free import NoReference
from .simulation import Simulation
from .springs import last_cycle

LOWER = 2  # by which the order is lower for the estimate of the error


class StepFree:
    """States of ``analytic.CoupledLoop`` at the load steps of a simulation; NoReference where it does not converge.

    order: of its basis; like: states of another order, see ``CoupledLoop.run``. coarser: the same with a lower order,
    made if ``estimated``; the difference is more than the error of this solution.
    """

    name = "half-plane solver without load steps"

    def __init__(self, simulation: Simulation, order: int = ORDER, estimated: bool = False, like=()):
        scaled, self._schedule = simulation.scaled, simulation.schedule
        coupled = "coupling" in simulation.effects
        loop, loads = loop_of(scaled, simulation.mu, coupled, order), tuple((s.P, s.Q) for s in self._schedule)
        try:
            self._states = loop.run(loads, like) if like else known(states_of(loop, loads))
            self._energy = last_cycle(self._states, self._schedule)
        except (ContactNotConverged, ValueError, ArithmeticError) as failure:
            raise NoReference(str(failure)) from None
        self.coarser = self._other(simulation, order) if estimated else None

    def _other(self, simulation, order):
        """Another order of the basis; a higher one where the lower does not converge."""
        try:
            return StepFree(simulation, order - LOWER, like=self._states)
        except NoReference:
            return StepFree(simulation, order + LOWER, like=self._states)

    def pressure(self, entry: Entry, x):
        """p."""
        return self._states[entry.number].pressure_at(x)

    def traction(self, entry: Entry, x):
        """q."""
        return self._states[entry.number].traction_at(x)

    def slip(self, entry: Entry, x):
        """u_x - delta_x since the end of the normal stage."""
        return self._states[entry.number].slip_at(x)

    def contact(self, entry: Entry) -> tuple[float, float]:
        """Edges of the contact."""
        return self._states[entry.number].contact

    def stick(self, entry: Entry) -> tuple[float, float]:
        """Edges of the zone that has stuck since the last turn."""
        return self._states[entry.number].stick

    def stick_half_width(self, entry: Entry) -> float:
        """Half its length."""
        left, right = self.stick(entry)
        return (right - left) / 2

    def dissipated_energy(self) -> float:
        """Of the last full cycle, where there is none since first contact."""
        return self._energy
