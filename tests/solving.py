"""Small problems solved in-process by the tests."""

from functools import partial

from mpi4py import MPI
from running import coarse_overrides

from simulations.loading.fallbacks import Options
from simulations.runs.comparison import compare
from simulations.runs.expected_edges import ExpectedEdges
from simulations.runs.reference import closed_form
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, parse
from simulations.studies.stability import read_cases

# Under a constant Q the contact shrinks until all but one point slide; keys of a whole scene.
SHRINKING = read_cases(["reversals at every level"])["reversals at every level: k -0.5"] | {
    "load.points": [[1e6, 0.0], [1e6, 1e5], [5e5, 1e5]]
}


def coarse_simulation(text=DEFAULT_SCENE, cells=None, like=None, **changes) -> Simulation:
    """A coarse simulation of a scene, not yet run."""
    return Simulation(MPI.COMM_SELF, parse(text, coarse_overrides(**changes)), cells, like)


def solved(text=DEFAULT_SCENE, cells=None, **changes) -> Simulation:
    """The same, run to its end."""
    return coarse_simulation(text, cells, **changes).run_to_end()


def limit_stepping(monkeypatch, **options):
    """From now on load stepping has these of its ``Options``."""
    monkeypatch.setattr("simulations.loading.stepping.Options", partial(Options, **options))


def deviations(simulation: Simulation) -> dict[str, float]:
    """Deviations of a finished simulation from its closed forms."""
    return compare(simulation.history, closed_form(simulation))


def of_the_closed_form(scene, scaled, loop, *_) -> ExpectedEdges:
    """In place of ``expected_edges``: a mesh graded to the uncoupled contact, which makes coupled loops hard."""
    return ExpectedEdges((loop.c, loop.a))
