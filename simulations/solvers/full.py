"""The full Newton step: every displacement and the rigid motion of the indenter.

    [ J  C ] [du    ]     [ force residual ]
    [ R  D ] [ddelta] = - [ load imbalance ]

J is sparse and factorised; the one or two rigid unknowns cost as many further back-substitutions and a dense
solve of their own size.
"""

import numpy as np
from petsc4py import PETSc

from forms.contact import X

from ..fem.contact_problem import ContactProblem
from ..fem.load import NO_LOAD
from .bulk_solver import bulk_solver, factorise
from .system import System

SINGULAR = 1e12  # condition of the equations of the indenter, which is free to move beyond it


class FullSystem(System):
    """Unknowns (u, delta), the whole state; the rigid displacements are the last entries of the last rank."""

    def __init__(self, problem: ContactProblem):
        self.problem = problem
        self._rigid = list(problem.directions)
        self._comm = problem.body.mesh.comm
        self._load = NO_LOAD
        self.jacobian = problem.body.constrained_stiffness.copy()
        self._ksp = bulk_solver(self.jacobian, "lu")
        self._columns = self._rows = self._responses = list[PETSc.Vec]()  # C, R and J^-1 C
        self._corner = self._schur = np.zeros((0, 0))  # D and D - R J^-1 C

    def create_vector(self) -> PETSc.Vec:
        """A vector of the unknowns."""
        extra = len(self._rigid) if self._comm.rank == self._comm.size - 1 else 0
        return PETSc.Vec().createMPI((self.jacobian.getLocalSize()[0] + extra, None), comm=self._comm)

    def begin(self, load, x):
        """Prescribe the line loads and fill ``x`` with the present state."""
        self._load = load
        body = self.problem.body
        body.apply_far_field(load)
        self._join(body.state.x.petsc_vec, body.delta.value[self._rigid], x)

    def residual(self, x, f) -> tuple[float, float]:
        """Fill ``f``; return the norm of the force residual and the largest load imbalance."""
        self.finish(x)
        force, imbalance = self.problem.terms.residual(self._load)
        self._join(force, imbalance, f)
        return force.norm(), float(np.abs(imbalance).max())

    def linearise(self, x):
        """Assemble and factorise J; eliminate the displacements from the rigid equations."""
        self.finish(x)
        self.problem.terms.assemble_jacobian(self.jacobian)
        factorise(self._ksp)
        self._columns, self._rows, self._corner = self.problem.terms.borders()
        self._responses = [self._bulk_solve(column) for column in self._columns]
        self._schur = self._corner - np.array([[row.dot(z) for z in self._responses] for row in self._rows])

    def solve(self, b, x, fixed=False):
        """x = J^-1 b by block elimination; nan where the indenter is free to move (every point slips) and not fixed."""
        bulk, rigid = self._split(b)
        response = self._bulk_solve(bulk)
        rigid = rigid - np.array([row.dot(response) for row in self._rows])
        schur = self._schur.copy()
        if fixed:
            aside = self._rigid.index(X)
            schur[aside], rigid[aside] = np.eye(len(rigid))[aside], 0.0
        regular = bool(np.isfinite(schur).all()) and np.linalg.cond(schur) < SINGULAR
        rigid = np.linalg.solve(schur, rigid) if regular else np.full_like(rigid, np.nan)
        for z, value in zip(self._responses, rigid):
            response.axpy(-value, z)
        self._join(response, rigid, x)

    def multiply(self, x, y):
        """y = J x."""
        bulk, rigid = self._split(x)
        image = self.jacobian.createVecLeft()
        self.jacobian.mult(bulk, image)
        for column, value in zip(self._columns, rigid):
            image.axpy(value, column)
        self._join(image, np.array([row.dot(bulk) for row in self._rows]) + self._corner @ rigid, y)

    def finish(self, x):
        """Leave the state ``x`` in the problem's fields."""
        bulk, rigid = self._split(x)
        body = self.problem.body
        body.state.x.array[: bulk.local_size] = bulk.array_r
        body.state.x.scatter_forward()
        body.delta.value[self._rigid] = rigid

    def _bulk_solve(self, b):
        x = b.duplicate()
        self._ksp.solve(b, x)
        return x

    def _split(self, vector):
        bulk = self.jacobian.createVecRight()
        bulk.array[:] = vector.array_r[: bulk.local_size]
        rigid = self._comm.bcast(vector.array_r[bulk.local_size :].copy(), root=self._comm.size - 1)
        return bulk, rigid

    def _join(self, bulk, rigid, vector):
        array = vector.array
        array[: bulk.local_size] = bulk.array_r
        array[bulk.local_size :] = rigid[: array.size - bulk.local_size]
