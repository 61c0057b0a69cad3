"""Options of the direct solver are its own: nothing stays in PETSc's database."""

import pytest
from petsc4py import PETSc

from simulations.solvers.bulk_solver import with_defaults


def test_options_go_after_an_error_too():
    with pytest.raises(ZeroDivisionError):
        with_defaults("fretting_test_", {"pc_type": "lu"}, lambda: 1 / 0)
    assert "fretting_test_pc_type" not in PETSc.Options()
