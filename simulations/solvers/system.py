"""What solves a load step: a system that can be linearised, whatever its unknowns are."""

from typing import Protocol

import numpy as np
from petsc4py import PETSc

from forms.contact import X

from ..fem.contact_problem import ContactProblem


class System(Protocol):
    """A linearisable system whose unknowns are a PETSc vector; ``problem`` is the contact problem behind it."""

    problem: ContactProblem

    def create_vector(self) -> PETSc.Vec:
        """A vector of the unknowns."""

    def begin(self, load, x: PETSc.Vec):
        """Prescribe the line loads and fill ``x`` with the present state."""

    def start_elsewhere(self):
        """After ``begin``: the unknowns to start from are not those of the present state."""
        return

    def residual(self, x: PETSc.Vec, f: PETSc.Vec) -> tuple[float, float]:
        """Fill ``f``; return the norm of the force residual and the largest load imbalance."""

    def linearise(self, x: PETSc.Vec):
        """Prepare ``solve`` at ``x``."""

    def solve(self, b: PETSc.Vec, x: PETSc.Vec, fixed: bool = False):
        """x = J^-1 b; nan where J is singular. fixed: the indenter stays where it is along the surface, whatever Q."""

    def multiply(self, x: PETSc.Vec, y: PETSc.Vec):
        """y = J x."""

    def move_indenter(self, x: PETSc.Vec, distance: float):
        """Add ``distance`` along the surface to the rigid displacements in ``x``, whose last entries these are."""
        directions = self.problem.directions
        if x.comm.rank == 0:
            x.setValue(x.getSize() - len(directions) + directions.index(X), distance, PETSc.InsertMode.ADD_VALUES)
        x.assemble()

    def finish(self, x: PETSc.Vec):
        """Leave the state ``x`` in the problem's fields."""

    def last_forces(self) -> np.ndarray:
        """Contact forces that ``finish`` left, beyond what the fields hold; empty where they hold all."""
        return np.zeros(0)

    def take_up(self, forces: np.ndarray):
        """Go on from fields that an earlier run's ``finish`` left with these forces."""
        return
