"""Reference of coupled loops: states of the half-plane found directly from the last turn of Q, without load steps."""

from analytic import ContactNotConverged
from analytic.coupled.loop import ORDER, known, missing
from analytic.coupled.state import CoupledState

from .comparison import NoReference, OfStates, before_last_cycle
from .coupled_loop import loop_of, states_of
from .mesh_free import FEWER_NODES, MeshFree, Tell
from .simulation import Simulation

LOWER = 2  # by which the order is lower for the estimate of the error
LEAST_ENERGY = 1e-8  # over P²/E(a): all orders share an error of up to 3e-11, however small the energy is


class StepFree(OfStates):
    """States of ``analytic.CoupledLoop`` at the load steps of a simulation; NoReference where it does not converge.

    order: of its basis; like: the same of another order, see ``CoupledLoop.where_known``. coarser: the same with a
    lower order, made if ``estimated``; the difference is more than the error of this solution.
    gaps: numbers of load steps without a state, as points come into contact in stick there. If ``filled`` these states
    are those of ``between``, the mesh-free solver, and so is the energy where these loads leave it open
    (``lacks_energy``): then with load steps that grow from each turn, as all of them count. Else there is no reference.
    An energy below LEAST_ENERGY, as little friction has, is not known.
    tell: see ``MeshFree``.
    """

    name = "half-plane solver without load steps"

    def __init__(
        self,
        simulation: Simulation,
        order: int = ORDER,
        estimated: bool = False,
        filled: bool = False,
        like: "StepFree | None" = None,
        tell: Tell | None = None,
    ):
        self._own = self._found(simulation, order, like)
        reasons: dict[int | None, str] = {n: str(why) for n, why in enumerate(map(missing, self._own)) if why}
        energy: float | None = None
        try:
            known(self._own[-1:])  # where no turn before is uncertain
            found = self._own[-1].dissipated_since(before_last_cycle(self._own, simulation.schedule))
            energy = found if like or found >= LEAST_ENERGY else None
        except ContactNotConverged as failure:
            reasons[None] = str(failure)
        if reasons and not (filled or like and reasons.keys() <= like.open.keys()):
            raise NoReference(next(iter(reasons.values())))
        self.open: dict[int | None, str] = like.open if like else reasons  # by load step, None for the energy
        self.gaps = [number for number in self.open if number is not None]
        self.lacks_energy = None in self.open
        self.between: MeshFree | None = None
        if like and like.between:
            self.between = like.between.coarser
        elif self.open:
            steps = range(1, len(simulation.schedule)) if self.lacks_energy else self.gaps
            self.between = MeshFree(simulation, tell, FEWER_NODES, estimated=estimated, since_turn=steps)
        states = list(self._own)
        for number in self.gaps:
            states[number] = self.between.states[number]
        super().__init__(states, self.between.dissipated_energy() if self.lacks_energy else energy)
        self.coarser = self._other(simulation, order) if estimated else None

    @staticmethod
    def _found(simulation, order, like) -> list:
        """The states, or the reason in the place of one."""
        loop = loop_of(simulation.scaled, simulation.mu, simulation.effects, order)
        loads = tuple((step.P, step.Q) for step in simulation.schedule)
        try:
            if like:
                return loop.where_known(loads, [state for state in like._own if isinstance(state, CoupledState)])
            return states_of(loop, loads)
        except (RuntimeError, ValueError, ArithmeticError) as failure:
            raise NoReference(str(failure)) from None

    def _other(self, simulation, order):
        """Another order of the basis; a higher one where the lower does not converge."""
        try:
            return StepFree(simulation, order - LOWER, like=self)
        except NoReference:
            return StepFree(simulation, order + LOWER, like=self)
