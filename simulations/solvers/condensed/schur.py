"""Partial sparse factorisation: some unknowns are kept, and their dense Schur complement is returned.

MUMPS does this and PETSc passes it on, but petsc4py 3.22 has no such call. So the PETSc functions are called
through ctypes, from the library that petsc4py itself is linked to. Solving for every column of the surface
compliance instead takes 2.8 s where this takes 0.4 s (58 098 unknowns).
"""

import ctypes

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_matrix

from ..bulk_solver import bulk_solver

NESTED_DISSECTION = {"mat_mumps_icntl_7": 5}  # METIS: with a Schur complement it beats QAMD at every size measured
_petsc = ctypes.CDLL(PETSc.__file__)  # symbols of the PETSc library that petsc4py itself is linked to


class PartialFactor:
    """Factor of a symmetric sequential matrix without the unknowns ``kept``.

    schur: dense (m, m), what the matrix is to the kept unknowns when no force acts on the others.
    """

    def __init__(self, matrix: csr_matrix, kept: np.ndarray, definite: bool):
        csr = (matrix.indptr.astype(PETSc.IntType), matrix.indices.astype(PETSc.IntType), matrix.data)
        self._matrix = PETSc.Mat().createAIJ(matrix.shape, csr=csr, comm=PETSc.COMM_SELF)
        self._matrix.setOption(PETSc.Mat.Option.SPD, definite)
        self._ksp = bulk_solver(self._matrix, "cholesky", NESTED_DISSECTION, lambda pc: _keep(pc, kept))
        self.schur = _schur_complement(self._ksp.pc.getFactorMatrix(), len(kept))

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Solution (n,) of the whole system, the kept unknowns included."""
        x, right = self._matrix.createVecs()
        right.array[:] = b
        self._ksp.solve(right, x)
        return x.array.copy()


def _keep(pc: PETSc.PC, unknowns):
    index_set = PETSc.IS().createGeneral(np.asarray(unknowns, PETSc.IntType), comm=PETSc.COMM_SELF)
    pc.setFactorSetUpSolverType()
    _call("MatFactorSetSchurIS", pc.getFactorMatrix(), ctypes.c_void_p(index_set.handle))


def _schur_complement(factor: PETSc.Mat, m: int) -> np.ndarray:
    """A copy of the Schur complement that the numerical factorisation has left."""
    matrix, array = ctypes.c_void_p(), ctypes.POINTER(ctypes.c_double)()
    _call("MatFactorCreateSchurComplement", factor, ctypes.byref(matrix), ctypes.byref(ctypes.c_int()))
    _call("MatDenseGetArrayRead", matrix, ctypes.byref(array))
    dense = np.ctypeslib.as_array(array, (m, m)).copy()  # symmetric: by rows or by columns
    _call("MatDenseRestoreArrayRead", matrix, ctypes.byref(array))
    _call("MatDestroy", ctypes.byref(matrix))
    return dense


def _call(name: str, first, *others):
    """Call a PETSc function whose first argument is an object; RuntimeError where this PETSc has no such function."""
    if not hasattr(_petsc, name):
        raise RuntimeError(f'this PETSc has no {name}: set solver.method = "full"')
    handle = ctypes.c_void_p(first.handle) if isinstance(first, PETSc.Object) else first
    code = getattr(_petsc, name)(handle, *others)
    if code:
        raise PETSc.Error(code)
