"""Newton's method for displacements and rigid motion together: PETSc SNES on a bordered system.

    [ J  C ] [du    ]     [ force residual ]
    [ R  D ] [ddelta] = - [ load imbalance ]

J is sparse and factorised; the one or two rigid unknowns cost as many further back-substitutions and a dense
m x m solve. Every option is open on the command line under the prefix ``fretting_``, those of the
factorisation under ``fretting_bulk_``.
"""

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from .problem import ContactProblem

OPTIONS = {
    "snes_type": "newtonls",
    "snes_linesearch_type": "basic",  # full steps: the semismooth method ends after finitely many
    "snes_max_it": 25,
    "ksp_type": "preonly",
    "bulk_ksp_type": "preonly",
    "bulk_pc_type": "lu",
    "bulk_pc_factor_mat_solver_type": "mumps",
    "bulk_mat_mumps_icntl_7": 6,  # QAMD ordering: beats the automatic choice on graded meshes
    "bulk_mat_mumps_icntl_14": 60,  # working space, per cent
}
FORCE_TOLERANCE = 1e-9  # force residual / P
LOAD_TOLERANCE = 1e-10  # load imbalance / P
STEP_TOLERANCE = 1e-11  # a step this small (relative) ends the iteration if round-off holds the residual up ...
ATTAINABLE = 1e-6  # ... below this


@dataclass(frozen=True)
class NewtonResult:
    """How a solve ended: iterations, relative force residual and load imbalance, and a reason if it failed."""

    converged: bool
    iterations: int
    residual: float
    imbalance: float
    reason: str


class BorderedMatrix:
    """Python context of the bordered Jacobian; the rigid unknowns are the last entries of the last rank."""

    def __init__(self, problem: ContactProblem):
        self.problem = problem
        self.bulk = problem.create_matrix()
        self.columns, self.rows, self.corner = [], [], np.zeros((0, 0))
        self.m = len(problem.directions)

    def assemble(self):
        """Linearise at the problem's present state."""
        self.problem.assemble_jacobian(self.bulk)
        self.columns, self.rows, self.corner = self.problem.borders()

    def split(self, vector: PETSc.Vec) -> tuple[PETSc.Vec, np.ndarray]:
        """The bulk part of a bordered vector, copied, and its rigid part on every rank."""
        comm = vector.comm.tompi4py()
        bulk = self.bulk.createVecRight()
        bulk.array[:] = vector.array_r[: bulk.local_size]
        rigid = comm.bcast(vector.array_r[bulk.local_size :].copy(), root=comm.size - 1)
        return bulk, rigid

    def join(self, bulk: PETSc.Vec, rigid: np.ndarray, vector: PETSc.Vec):
        """Inverse of ``split``."""
        with vector as array:
            array[: bulk.local_size] = bulk.array_r
            array[bulk.local_size :] = rigid[: array.size - bulk.local_size]

    def create_vector(self) -> PETSc.Vec:
        """A bordered vector."""
        comm = self.bulk.comm.tompi4py()
        extra = self.m if comm.rank == comm.size - 1 else 0
        return PETSc.Vec().createMPI((self.bulk.getLocalSize()[0] + extra, None), comm=comm)

    def mult(self, matrix, x, y):
        """y = [J C; R D] x."""
        bulk, rigid = self.split(x)
        image = self.bulk.createVecLeft()
        self.bulk.mult(bulk, image)
        for column, value in zip(self.columns, rigid):
            image.axpy(value, column)
        self.join(image, np.array([row.dot(bulk) for row in self.rows]) + self.corner @ rigid, y)


class BorderedLU:
    """Python preconditioner: exact solve of the bordered system by block elimination."""

    def __init__(self, matrix: BorderedMatrix, prefix: str):
        self.matrix = matrix
        self.ksp = PETSc.KSP().create(matrix.bulk.comm)
        self.ksp.setOptionsPrefix(prefix + "bulk_")
        self.ksp.setOperators(matrix.bulk)
        self.ksp.setFromOptions()

    def setUp(self, pc):
        """Factorise, and eliminate the displacements from the rigid equations."""
        self.ksp.setUp()
        self.responses = [self._solve(column) for column in self.matrix.columns]
        rows = self.matrix.rows
        self.schur = self.matrix.corner - np.array([[r.dot(z) for z in self.responses] for r in rows])

    def apply(self, pc, b, x):
        """x = [J C; R D]^-1 b."""
        bulk, rigid = self.matrix.split(b)
        response = self._solve(bulk)
        rigid = rigid - np.array([row.dot(response) for row in self.matrix.rows])
        try:
            rigid = np.linalg.solve(self.schur, rigid)
        except np.linalg.LinAlgError:  # every point slips: the cylinder is free to move
            rigid = np.full_like(rigid, np.nan)
        for z, value in zip(self.responses, rigid):
            response.axpy(-value, z)
        self.matrix.join(response, rigid, x)

    def _solve(self, b):
        x = b.duplicate()
        self.ksp.solve(b, x)
        return x


class Newton:
    """Solves a ContactProblem for given line loads, from its present state."""

    def __init__(self, problem: ContactProblem, prefix: str = "fretting_"):
        options = PETSc.Options()
        self._defaults = [prefix + name for name in OPTIONS if prefix + name not in options]
        for name in self._defaults:
            options[name] = OPTIONS[name.removeprefix(prefix)]
        self.problem = problem
        comm = problem.body.mesh.comm
        self.jacobian = BorderedMatrix(problem)
        self.x, self._f = self.jacobian.create_vector(), self.jacobian.create_vector()
        shape = (self.x.getLocalSize(), None)
        matrix = PETSc.Mat().createPython((shape, shape), self.jacobian, comm)
        matrix.setUp()
        self.snes = PETSc.SNES().create(comm)
        self.snes.setOptionsPrefix(prefix)
        self.snes.setFunction(self._residual, self._f)
        self.snes.setJacobian(self._linearise, matrix)
        self.snes.setConvergenceTest(self._test)
        pc = self.snes.ksp.pc
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(BorderedLU(self.jacobian, prefix))
        self.snes.setFromOptions()
        for name in self._defaults:
            del options[name]
        self._load, self._scale, self._norms = (0.0, 0.0), 1.0, (np.inf, np.inf)

    def solve(self, load, predict: bool) -> NewtonResult:
        """Balance the line loads ``(Q, P)``; ``predict`` first takes one step with every point sticking."""
        problem = self.problem
        self._load, self._scale = load, abs(load[1])
        problem.body.apply_far_field(load)
        self._gather()
        if predict:
            problem.all_stick.value = 1.0
            self._step()
            problem.all_stick.value = 0.0
        self.snes.solve(None, self.x)
        self._scatter(self.x)
        code = self.snes.getConvergedReason()
        return NewtonResult(
            converged=code > 0,
            iterations=self.snes.getIterationNumber() + int(predict),
            residual=self._norms[0],
            imbalance=self._norms[1],
            reason=_REASONS.get(code, f"SNES reason {code}") if code <= 0 else "",
        )

    def _step(self):
        matrix = self.snes.getJacobian()[0]
        self.snes.computeFunction(self.x, self._f)
        self.snes.computeJacobian(self.x, matrix)
        self.snes.ksp.setOperators(matrix)
        step = self.x.duplicate()
        self.snes.ksp.solve(self._f, step)
        self.x.axpy(-1.0, step)

    def _gather(self):
        problem = self.problem
        self.jacobian.join(problem.body.u.x.petsc_vec, problem.body.delta.value[list(problem.directions)], self.x)

    def _scatter(self, x):
        bulk, rigid = self.jacobian.split(x)
        u = self.problem.body.u.x
        u.array[: bulk.local_size] = bulk.array_r
        u.scatter_forward()
        self.problem.body.delta.value[list(self.problem.directions)] = rigid

    def _residual(self, snes, x, f):
        self._scatter(x)
        force, imbalance = self.problem.residual(self._load)
        self._norms = (force.norm() / self._scale, float(np.abs(imbalance).max()) / self._scale)
        self.jacobian.join(force, imbalance, f)

    def _linearise(self, snes, x, jacobian, preconditioner):
        self._scatter(x)
        self.jacobian.assemble()
        jacobian.assemble()

    def _test(self, snes, iteration, norms):
        force, imbalance = self._norms
        reason = PETSc.SNES.ConvergedReason
        if not np.isfinite(norms[2]):
            return reason.DIVERGED_FNORM_NAN
        if force <= FORCE_TOLERANCE and imbalance <= LOAD_TOLERANCE:
            return reason.CONVERGED_FNORM_ABS
        if iteration > 0 and norms[1] <= STEP_TOLERANCE * norms[0] and max(force, imbalance) <= ATTAINABLE:
            return reason.CONVERGED_SNORM_RELATIVE
        if iteration >= snes.getTolerances()[3]:
            return reason.DIVERGED_MAX_IT
        return reason.CONVERGED_ITERATING


_REASONS = {
    PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN: "the residual is not a number (singular tangent)",
    PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT: "too many iterations",
    PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the linear solve failed",
    PETSc.SNES.ConvergedReason.DIVERGED_LINE_SEARCH: "the line search failed",
}
