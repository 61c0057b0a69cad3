"""Direct solver of the elastic body; its options are open on the command line under the prefix ``fretting_bulk_``."""

from petsc4py import PETSc

BULK_OPTIONS = {
    "ksp_type": "preonly",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_7": 6,  # QAMD ordering: beats the automatic choice on graded meshes
    "mat_mumps_icntl_14": 60,  # working space, per cent
}
BULK_PREFIX = "fretting_bulk_"
TOO_LITTLE_MEMORY = -7, -8, -9, -13, -17, -19, -20  # errors of MUMPS, its INFOG(1)


class FactorisationError(RuntimeError):
    """The matrix of the elastic body cannot be factorised; the message says why."""


def with_defaults(prefix: str, defaults: dict, configure):
    """Call ``configure`` (a setFromOptions) with ``defaults`` under ``prefix``, which the user's options override."""
    options = PETSc.Options()
    missing = {prefix + name: value for name, value in defaults.items() if prefix + name not in options}
    for name, value in missing.items():
        options[name] = value
    try:
        configure()
    finally:
        for name in missing:
            del options[name]


def bulk_solver(matrix: PETSc.Mat, factorisation: str, changes=None, prepare=None) -> PETSc.KSP:
    """Direct solver of the body, ``factorisation`` "lu" or "cholesky", factorised; options under ``fretting_bulk_``.
    FactorisationError where that fails.

    changes: to BULK_OPTIONS; prepare: function of the preconditioner, called before it is factorised.
    """
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOptionsPrefix(BULK_PREFIX)
    ksp.setOperators(matrix)

    def set_up():
        ksp.setFromOptions()
        if prepare is not None:
            prepare(ksp.pc)
        ksp.setUp()  # MUMPS reads its options here

    with_defaults(BULK_PREFIX, BULK_OPTIONS | {"pc_type": factorisation} | (changes or {}), set_up)
    _check(ksp.pc, PETSc.PC.FailedReason.NOERROR)
    return ksp


def factorise(ksp: PETSc.KSP):
    """Factorise the changed matrix. FactorisationError where that fails; a singular one has no finite solution."""
    ksp.setUp()
    _check(ksp.pc, PETSc.PC.FailedReason.NOERROR, PETSc.PC.FailedReason.FACTOR_NUMERIC_ZEROPIVOT)


def _check(pc: PETSc.PC, *allowed: int):
    if pc.getFailedReason() not in allowed:  # PETSc itself goes on, with no solution
        raise FactorisationError(f"the stiffness of the elastic body cannot be factorised: {_why(pc)}")


def _why(pc: PETSc.PC) -> str:
    if pc.getFactorSolverType() != "mumps":
        return f"PETSc's reason {pc.getFailedReason()}"
    code = pc.getFactorMatrix().getMumpsInfog(1)
    memory = ", too little memory; a coarser mesh needs less" if code in TOO_LITTLE_MEMORY else ""
    return f"MUMPS error {code}{memory}"
