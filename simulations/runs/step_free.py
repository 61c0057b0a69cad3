"""Reference of coupled loops: states of the half-plane found directly from the last turn of Q, without load steps."""

from analytic.coupled.loop import ORDER, known
from analytic.half_plane.linear import ContactNotConverged

from .comparison import NoReference, OfStates
from .coupled_loop import loop_of, states_of
from .simulation import Simulation
from .springs import last_cycle

LOWER = 2  # by which the order is lower for the estimate of the error


class StepFree(OfStates):
    """States of ``analytic.CoupledLoop`` at the load steps of a simulation; NoReference where it does not converge.

    order: of its basis; like: states of another order, see ``CoupledLoop.run``. coarser: the same with a lower order,
    made if ``estimated``; the difference is more than the error of this solution.
    """

    name = "half-plane solver without load steps"

    def __init__(self, simulation: Simulation, order: int = ORDER, estimated: bool = False, like=()):
        coupled = "coupling" in simulation.effects
        loop = loop_of(simulation.scaled, simulation.mu, coupled, order)
        loads = tuple((step.P, step.Q) for step in simulation.schedule)
        try:
            states = loop.run(loads, like) if like else known(states_of(loop, loads))
            super().__init__(states, last_cycle(states, simulation.schedule))
        except (ContactNotConverged, ValueError, ArithmeticError) as failure:
            raise NoReference(str(failure)) from None
        self.coarser = self._other(simulation, order) if estimated else None

    def _other(self, simulation, order):
        """Another order of the basis; a higher one where the lower does not converge."""
        try:
            return StepFree(simulation, order - LOWER, like=self.states)
        except NoReference:
            return StepFree(simulation, order + LOWER, like=self.states)
