"""One short loop on all ranks of this run, and on one rank alone: the same numbers, plain and mixed."""

import pytest
from mpi4py import MPI
from running import coarse_overrides

from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, parse

comm = MPI.COMM_WORLD


@pytest.mark.parametrize("method", ["condensed", "full"])
@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_ranks_do_not_change_the_answer(method, nu):
    changes = {"solver__method": method, "solid__nu": nu, "solid__k": 0.0, "load__cycles": 0}
    check(parse(DEFAULT_SCENE, coarse_overrides(**changes)))


def test_ranks_do_not_change_the_answer_with_bulk_strain():
    changes = {"solid__nu": 0.3, "load__bulk_strain": 3e-4, "load__bulk_phase": 60, "reference__kind": '"none"'}
    check(parse(DEFAULT_SCENE, coarse_overrides(**changes)))


def check(scene):
    """Run the scene both ways."""
    together, alone = (Simulation(c, scene).run_to_end().history.entries for c in (comm, MPI.COMM_SELF))
    for one, other in zip(together, alone, strict=True):
        scale = other.surface.pressure.max()
        assert one.surface.pressure == pytest.approx(other.surface.pressure, abs=1e-8 * scale)
        assert one.surface.traction == pytest.approx(other.surface.traction, abs=1e-8 * scale)
        assert one.dissipated == pytest.approx(other.dissipated, rel=1e-8, abs=1e-12)
