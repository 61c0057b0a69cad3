"""The record of a run: one entry an increment, with everything that files, plots and errors are made from."""

from dataclasses import dataclass, field

import numpy as np

from ..fem.surface import SurfaceState, fitted_contact_edges, fitted_stick_edges
from ..loading.schedule import LoadStep
from ..loading.stepping import Outcome
from .frictional_work import Moment, frictional_work


@dataclass(frozen=True)
class Entry:
    """State at the end of an increment (dimensionless) and what it took."""

    increment: LoadStep
    surface: SurfaceState
    slip: np.ndarray  # (n,) u_x - delta_x since tangential loading began
    contact: tuple[float, float]  # edges of the contact
    stick: tuple[float, float]  # edges of the stick zone
    dissipated: float  # energy since the start
    iterations: int
    cuts: int
    residual: float
    imbalance: float
    seconds: float
    tolerance: float = 0.0  # of the residual
    changes: tuple[int, ...] = ()  # points whose contact state changed, in each iteration of the solve that counts
    number: int = 0  # place in the history

    @property
    def a(self) -> float:
        """Contact half-width."""
        return float(self.contact[1] - self.contact[0]) / 2

    @property
    def c(self) -> float:
        """Stick half-width."""
        return float(self.stick[1] - self.stick[0]) / 2


@dataclass
class History:
    """Entries of a run so far. k and mu are the grading and the coefficient of friction (0: no tangential problem)."""

    k: float
    mu: float
    entries: list[Entry] = field(default_factory=list)

    def append(self, outcome: Outcome, surface: SurfaceState, seconds: float) -> Entry:
        """Add the state that ``outcome`` ended with."""
        increment, s = outcome.step, surface.relative_displacement
        contact = fitted_contact_edges(surface, self.k)
        stick, dissipated = contact, 0.0
        if self.friction and np.any(surface.traction):
            stick = fitted_stick_edges(surface, self.mu, increment.direction, self.k)
        if self.entries:
            dissipated = self.entries[-1].dissipated + self._work(Moment(surface, contact))
        if increment.branch == "normal":
            self._rest = s
        entry = Entry(
            increment=increment,
            surface=surface,
            slip=s - self._rest,
            contact=contact,
            stick=stick,
            dissipated=dissipated,
            iterations=outcome.iterations,
            cuts=outcome.cuts,
            residual=outcome.results[-1].residual,
            imbalance=outcome.results[-1].imbalance,
            seconds=seconds,
            tolerance=max(result.tolerance for result in outcome.results),
            changes=outcome.results[-1].changes,
            number=len(self.entries),
        )
        self.entries.append(entry)
        return entry

    def _work(self, after: Moment) -> float:
        if not self.friction:
            return 0.0
        *earlier, before = (Moment(e.surface, e.contact) for e in self.entries[-2:])
        return frictional_work(before, after, self.mu, self.k, earlier[0] if earlier else None)

    @property
    def friction(self) -> bool:
        """True where there is a tangential problem."""
        return self.mu > 0

    @property
    def has_cycle(self) -> bool:
        """True once a full cycle is done."""
        return self.entries[-1].increment.cycle > 0

    @property
    def last_cycle(self) -> list[Entry]:
        """Entries of the last full cycle, without the one it starts from."""
        cycle = self.entries[-1].increment.cycle
        return [entry for entry in self.entries if entry.increment.cycle == cycle]

    @property
    def dissipated_energy(self) -> float:
        """Energy dissipated in the last full cycle; where there is none, since the start."""
        if not self.has_cycle:
            return float(self.entries[-1].dissipated)
        cycle = self.last_cycle
        start = self.entries[len(self.entries) - len(cycle) - 1]
        return float(cycle[-1].dissipated - start.dissipated)
