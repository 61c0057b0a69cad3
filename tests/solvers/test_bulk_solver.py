"""The direct solver: its options are its own, nothing stays in PETSc's database; what it cannot factorise it says."""

import pytest
from petsc4py import PETSc
from solving import coarse_simulation

from simulations.loading.stepping import SolveError
from simulations.solvers.bulk_solver import with_defaults


def test_options_go_after_an_error_too():
    with pytest.raises(ZeroDivisionError):
        with_defaults("fretting_test_", {"pc_type": "lu"}, lambda: 1 / 0)
    assert "fretting_test_pc_type" not in PETSc.Options()


@pytest.mark.parametrize("method", ["condensed", "full"])
def test_a_body_that_does_not_fit_into_memory_is_no_singular_matrix(method):
    """MUMPS with 1 MB: it was a traceback, or the reason "singular tangent"."""
    simulation, options = coarse_simulation(solver__method=f'"{method}"'), PETSc.Options("fretting_bulk_")
    options["mat_mumps_icntl_23"] = 1
    try:
        with pytest.raises(SolveError, match=r"load step 1 .* factorised: MUMPS error -\d+, too little memory"):
            simulation.run_to_end()
    finally:
        del options["mat_mumps_icntl_23"]


def test_a_later_step_that_does_not_fit_is_no_singular_matrix_either():
    """1 MB from the second load step on: pivots of its tangent may ask for more than those before."""
    states = (simulation := coarse_simulation(solver__method='"full"')).run()
    next(states), next(states)
    simulation.stepping.system._ksp.pc.getFactorMatrix().setMumpsIcntl(23, 1)
    with pytest.raises(SolveError, match=r"load step 3 .* factorised: MUMPS error -\d+, too little memory"):
        next(states)
