"""The energy balance of a run, load step by load step, from the fields themselves.

With means of the forces before and after (the trapezoidal rule) this holds exactly for the discrete solution, in every
load step and however large it is, because the stiffness is symmetric and the loads balance:

    work of the indenter + work on the outer boundary + work of the bulk strain - change of u.K u/2
        = work of the contact tractions through the motion between surface and indenter.

u is the deviation from a bulk strain eps, which pulls the surface past the indenter by itself: -∫ q x dx d(eps).
The change of u.K.u/2 is the mean of K.u times the change of u, as its two values are much larger than it.

The right side is friction, and what the pressure does through the gap that Nitsche's method leaves, an error of
discretisation. It is formed from the tractions that are reported, the left side from the fields of the whole body.
"""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from forms.contact import Y

from ..fem.body import ElasticBody
from .checks import largest
from .history import Entry


@dataclass(frozen=True)
class EnergyStep:
    """Energies of one load step, in P²/E(a)."""

    indenter: float  # Q Δδx + P Δδy
    boundary: float  # work on the outer boundary, whose prescribed displacement follows the loads
    stretching: float  # of the bulk strain, against the traction
    stored: float  # change of the elastic energy
    friction: float  # lost by the reported traction through the slip
    gap: float  # lost by the reported pressure through the gap

    @property
    def defect(self) -> float:
        """What is missing in the balance."""
        return self.indenter + self.boundary + self.stretching - self.stored - self.friction - self.gap

    @property
    def turnover(self) -> float:
        """Sum of what is moved: the scale of round-off."""
        return sum(map(abs, (self.indenter, self.boundary, self.stretching, self.stored, self.friction)))


class EnergyMeter:
    """Reads the body after every load step; ``steps`` has one EnergyStep for each but the first.

    Every rank calls ``read`` with the entry whose fields are on the body.
    """

    def __init__(self, body: ElasticBody):
        self.body = body
        self.steps: list[EnergyStep] = []
        self._forces = _InnerForces(body)
        self._before = None

    def read(self, entry: Entry):
        """Add the load step that ended with ``entry``."""
        body, surface, load = self.body, entry.surface, entry.step.load
        body.complete()
        u = body.state.x.petsc_vec.array_r.copy()
        force = body.symmetry_factor * self._forces.of(u)
        far = body.fixed_dofs[body.fixed_dofs < len(u)]
        now = {
            "body": (force, u),
            "elastic slip": surface.elastic_energy,
            "boundary": (force[far], u[far]),
            "indenter": (np.array(load.components), surface.delta),
            "stretching": (surface.weight * surface.traction, load.strain * surface.x),
            "friction": (surface.weight * surface.traction, surface.relative_displacement),
            "gap": (surface.weight * surface.pressure, surface.u[Y] - surface.delta[Y]),
        }
        if self._before is not None:
            self.steps.append(self._step(self._before, now))
        self._before = now

    def _step(self, before, now):
        def work(name):
            (f0, s0), (f1, s1) = before[name], now[name]
            return float((f0 + f1) @ (s1 - s0) / 2)

        def everywhere(part):
            return self.body.mesh.comm.allreduce(part, MPI.SUM)

        return EnergyStep(
            indenter=work("indenter"),
            boundary=everywhere(work("boundary")),
            stretching=-work("stretching"),
            stored=everywhere(work("body")) + now["elastic slip"] - before["elastic slip"],
            friction=-work("friction"),
            gap=-work("gap"),
        )


class _InnerForces:
    """K.u from differences of the displacement between a node and its neighbours.

    A body that is moved as a whole has no forces. In K.u the last digits of a stiff surface (k near -1) leave some,
    which do work on the way of the indenter.
    """

    def __init__(self, body: ElasticBody):
        ends, columns, self._entries = body.stiffness.getValuesCSR()
        needed, self._column = np.unique(columns, return_inverse=True)
        self._row = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
        vector, self._needed = body.stiffness.createVecRight(), PETSc.Vec().createSeq(len(needed))
        index_set = PETSc.IS().createGeneral(needed.astype(PETSc.IntType), comm=PETSc.COMM_SELF)
        self._scatter, self._vector = PETSc.Scatter().create(vector, index_set, self._needed, None), vector
        owned = body.dofs[: body.owned_nodes]
        self._shifts = []  # dof of the row's node and whether a column has it, for both directions
        for direction, translation in enumerate(body.translations):
            node = np.full(len(ends) - 1, -1)
            node[owned] = owned[:, direction, None]
            moves = self._everywhere(translation.x.petsc_vec.array_r) * (node[self._row] >= 0)
            self._shifts.append((node[self._row], moves))

    def of(self, u: np.ndarray) -> np.ndarray:
        """Forces on this rank's unknowns (n,) under their values ``u``."""
        differences = self._everywhere(u)
        for node, moves in self._shifts:
            differences -= moves * u[node]
        return np.bincount(self._row, self._entries * differences, minlength=len(u))

    def _everywhere(self, u):
        """Values of the matrix's entries' columns."""
        self._vector.array[:] = u
        self._scatter.scatter(self._vector, self._needed)
        return self._needed.array_r[self._column]


def worst_defect(steps: list[EnergyStep], floor: float = 0.0) -> float:
    """Largest defect of a load step over the largest turnover of one; 0 without load steps.

    floor: turnover below which round-off, whose scale is P²/E(a) and not the turnover, is all that a defect shows.
    """
    turnover = largest(step.turnover for step in steps)
    return largest(abs(step.defect) for step in steps) / max(turnover, floor) if turnover else 0.0
