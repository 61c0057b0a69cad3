"""Short loops on all ranks of this run, and on one rank alone: the same numbers, plain and mixed, by either method."""

import pytest
from mpi4py import MPI
from running import coarse_overrides
from solving import SHRINKING

from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, make_scene, parse

comm = MPI.COMM_WORLD


def coarse(**changes):
    return parse(DEFAULT_SCENE, coarse_overrides(**changes))


def homogeneous(method, nu):
    return coarse(solver__method=method, solid__nu=nu, solid__k=0.0, load__cycles=0)


SCENES = {
    "condensed": homogeneous("condensed", 0.3),
    "full": homogeneous("full", 0.3),
    "condensed mixed": homogeneous("condensed", 0.5),
    "full mixed": homogeneous("full", 0.5),
    "bulk strain": coarse(solid__nu=0.3, load__bulk_strain=3e-4, load__bulk_phase=60),
    "coupled loop": coarse(solid__nu=0.3, solid__k=-0.3, solver__increments=3),
    "all but one slide": make_scene(SHRINKING, base=None),
}
if comm.size > 2:
    del SCENES["full"]  # "full mixed" has all of it, and costs half


def numbers(ranks, scene):
    """Of every state: p, q, dissipated energy, displacements of the indenter and contact half-width."""
    entries = Simulation(ranks, scene).run_to_end().history.entries
    changes = [(entry.iterations, entry.changes) for entry in entries]
    assert ranks.allgather(changes) == ranks.size * [changes]  # of all ranks' points, and the same on each
    return [(e.surface.pressure, e.surface.traction, e.dissipated, e.surface.delta, e.a) for e in entries]


@pytest.fixture(scope="module")
def alone():
    """The numbers by scene; each rank solves other scenes."""
    mine = {name: numbers(MPI.COMM_SELF, SCENES[name]) for name in list(SCENES)[comm.rank :: comm.size]}
    return {name: found for share in comm.allgather(mine) for name, found in share.items()}


@pytest.mark.parametrize("name", SCENES)
def test_ranks_do_not_change_the_answer(name, alone):
    for one, other in zip(numbers(comm, SCENES[name]), alone[name], strict=True):
        scale = other[0].max()
        for mine, theirs in zip(one[:2], other[:2]):
            assert mine == pytest.approx(theirs, abs=1e-8 * scale)
        assert one[2] == pytest.approx(other[2], rel=1e-8, abs=1e-12)


@pytest.mark.skipif(comm.size != 2, reason="of two ranks")
def test_all_but_one_point_slide_by_the_full_method(alone):
    ends = numbers(comm, make_scene(SHRINKING | {"solver.method": "full"}, base=None))
    for one, other in zip(ends[-1][2:], alone["all but one slide"][-1][2:], strict=True):
        assert one == pytest.approx(other, rel=1e-7)
