"""The energy balance of a run, increment by increment, from the fields themselves.

With means of the forces before and after (the trapezoidal rule) this holds exactly for the discrete solution, in every
increment and however large it is, because the stiffness is symmetric and the loads balance:

    work of the indenter + work on the outer boundary + work of the bulk strain - change of u.K u/2
        = work of the contact tractions through the motion between surface and indenter.

u is the deviation from a bulk strain eps, which pulls the surface past the indenter by itself: -∫ q x dx d(eps).

The right side is friction, and what the pressure does through the gap that Nitsche's method leaves, an error of
discretisation. It is formed from the tractions that are reported, the left side from the fields of the whole body.
"""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from ..fem.body import ElasticBody, Y
from .history import Entry


@dataclass(frozen=True)
class EnergyStep:
    """Energies of one increment, in P²/E(a)."""

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
    """Reads the body after every increment; ``steps`` has one EnergyStep for each but the first.

    Every rank calls ``read`` with the entry whose fields are on the body.
    """

    def __init__(self, body: ElasticBody):
        self.body = body
        self.steps: list[EnergyStep] = []
        self._before = None

    def read(self, entry: Entry):
        """Add the increment that ended with ``entry``."""
        body, surface, load = self.body, entry.surface, entry.increment
        body.complete()
        u = body.state.x.petsc_vec.duplicate()
        u.array[:] = body.state.x.petsc_vec.array_r
        force = body.stiffness.createVecLeft()
        body.stiffness.mult(u, force)
        far = body.fixed_dofs[body.fixed_dofs < u.local_size]
        now = {
            "stored": body.symmetry_factor * u.dot(force) / 2 + surface.elastic_energy,
            "boundary": (body.symmetry_factor * force.array_r[far], u.array_r[far].copy()),
            "indenter": (np.array(load.load.components), surface.delta),
            "stretching": (surface.weight * surface.traction, load.load.strain * surface.x),
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

        return EnergyStep(
            indenter=work("indenter"),
            boundary=self.body.mesh.comm.allreduce(work("boundary"), MPI.SUM),
            stretching=-work("stretching"),
            stored=now["stored"] - before["stored"],
            friction=-work("friction"),
            gap=-work("gap"),
        )


def worst_defect(steps: list[EnergyStep], floor: float = 0.0) -> float:
    """Largest defect of an increment over the largest turnover of one; 0 without increments.

    floor: turnover below which round-off, whose scale is P²/E(a) and not the turnover, is all that a defect shows.
    """
    turnover = max((step.turnover for step in steps), default=0.0)
    return max(abs(step.defect) for step in steps) / max(turnover, floor) if turnover else 0.0
