"""Small problems solved in-process by the tests."""

from functools import partial

from mpi4py import MPI
from running import coarse_overrides

from simulations.loading.fallbacks import FALLBACKS, Limits
from simulations.runs.comparison import OfStates, compare
from simulations.runs.energy import EnergyMeter, EnergyStep
from simulations.runs.history import History
from simulations.runs.reference import closed_form
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, make_scene, parse
from simulations.studies.stability import read_cases

# Under a constant Q the contact shrinks until all but one point slide; keys of a whole scene.
SHRINKING = read_cases(["reversals at every level"])["reversals at every level: k -0.5"] | {
    "load.points": [[1e6, 0.0], [1e6, 1e5], [5e5, 1e5]]
}

# Coupling and friction so strong that Newton's method does not end on reloading.
CYCLING = {"solid__k": -0.5, "solid__nu": 0.3, "load__mu": 2.0, "load__amplitude": 0.9999, "solver__increments": 2}
CYCLING |= {"mesh__degree": 1, "mesh__facet": 0.05, "mesh__edge_facet": 0.004, "mesh__first_layer": 0.004}
CYCLING |= {"mesh__growth": 1.3, "mesh__layer_growth": 1.6}


def coarse_simulation(text=DEFAULT_SCENE, cells=None, **changes) -> Simulation:
    """A coarse simulation of a scene, not yet run."""
    return Simulation(MPI.COMM_SELF, parse(text, coarse_overrides(**changes)), cells)


def solved(text=DEFAULT_SCENE, cells=None, **changes) -> Simulation:
    """The same, run to its end."""
    return coarse_simulation(text, cells, **changes).run_to_end()


def simulated(keys, base=DEFAULT_SCENE, cells=None) -> Simulation:
    """A scene with these keys on the mesh that it asks for, or that of ``cells``, run to its end."""
    return Simulation(MPI.COMM_SELF, make_scene(keys, base), cells).run_to_end()


def metered(simulation: Simulation) -> list[EnergyStep]:
    """The energies of each load step of a simulation, which is run to its end."""
    meter = EnergyMeter(simulation.body)
    for entry in simulation.run():
        meter.read(entry)
    return meter.steps


def limit_stepping(monkeypatch, **limits):
    """From now on load stepping has these of its ``Limits``."""
    monkeypatch.setattr("simulations.loading.stepping.Limits", partial(Limits, **limits))


def without_path(monkeypatch):
    """From now on load stepping has Newton's method alone."""
    ways = [way for way in FALLBACKS if way.name != "path"]
    monkeypatch.setattr("simulations.loading.stepping.FALLBACKS", ways)


def watched(monkeypatch, owner, name: str) -> list[tuple]:
    """The arguments of every call of a function of a module or class from now on."""
    calls, function = [], getattr(owner, name)
    monkeypatch.setattr(owner, name, lambda *arguments: calls.append(arguments) or function(*arguments))
    return calls


def of_history(history: History) -> OfStates:
    """Another run of the same schedule as reference."""
    return OfStates(history.entries, history.dissipated_energy)


def deviations(simulation: Simulation) -> dict[str, float]:
    """Deviations of a finished simulation from its closed forms."""
    return compare(simulation.history, closed_form(simulation))
