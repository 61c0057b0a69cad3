"""The path of a load step on which contact states change one by one: where it leads, and where nothing else does."""

from dataclasses import replace
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc
from solving import CYCLING, SHRINKING, coarse_simulation, limit_stepping, solved, without_path

from forms.contact import BACKWARD, CLOSED, FORWARD
from simulations.fem.load import Load
from simulations.loading.stepping import SolveError
from simulations.runs.plan import Plan
from simulations.runs.simulation import Simulation
from simulations.scene import DEFAULT_SCENE, make_scene
from simulations.solvers import newton, path
from simulations.studies.stability import read_cases


def loaded_once(method, coupling="true") -> Simulation:
    """On few nodes, run to its end."""
    scene = {"effects__coupling": coupling, "solid__nu": 0.3, "mesh__facet": 0.2, "load__cycles": 0}
    return solved(solver__method=method, **scene)


FORCES, INDENTER = (slice(-2), 0.1), (slice(-2, None), 0.02)  # unknowns, and by which share they are wrong


@pytest.mark.parametrize(
    "method, coupling, wrong",
    [("condensed", "true", FORCES), ("condensed", "false", FORCES), ("full", "true", INDENTER)],
)
def test_it_leads_to_the_answer(method, coupling, wrong):
    """A single Newton step does not."""
    simulation = loaded_once(method, coupling)
    entry = simulation.history.entries[-1]
    solver, load = simulation.stepping._newton, entry.step.load
    terms, answer = simulation.stepping.problem.terms, solver.x.copy()
    forces = terms.contact_forces().copy()
    answer.copy(solver._best)
    unknowns, share = wrong
    noise = np.random.default_rng(1).standard_normal(answer.local_size)
    solver._best.array[unknowns] += share * (noise * answer.array_r)[unknowns]
    followed = solver.follow(load)
    assert followed.converged and followed.iterations > 5
    assert solver.solve(load).iterations == 0
    assert terms.contact_forces() == pytest.approx(forces, abs=1e-8 * np.abs(forces).max())


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_point_that_sticks_slides_either_way_where_its_traction_is_at_its_limit(side):
    conditions = path._conditions(np.array([CLOSED]), 0.5)
    share, (_, point) = path._first_change(conditions, np.array([[0.0], [1.0]]), np.array([[2.0 * side], [0.0]]))
    assert share == pytest.approx(0.25) and point == 0


class Folded:
    """One unknown x, a point that slides along -x below 0, sticks up to 1 and slides along +x beyond, and a residual
    that goes through the places (x, residual) on straight lines.
    """

    def __init__(self, *places):
        self._x, self._f = map(np.array, zip(*places))
        terms = SimpleNamespace(trials=self._trials, contact_states=self._states)
        body = SimpleNamespace(mesh=SimpleNamespace(comm=MPI.COMM_SELF))
        self.problem = SimpleNamespace(terms=terms, body=body, mu=0.5, friction=True)

    def _trials(self):
        return np.array([[self.x - 0.5], [1.0]])  # the limit of friction is 0.5

    def _states(self):
        return np.array([BACKWARD if self.x < 0 else FORWARD if self.x > 1 else CLOSED])

    def linearise(self, x):
        place = np.clip(np.searchsorted(self._x, x.array_r[0]), 1, len(self._x) - 1)
        self._slope = np.diff(self._f)[place - 1] / np.diff(self._x)[place - 1]

    def solve(self, b, x, fixed=False):
        x.array[:] = b.array_r / self._slope

    def follow(self, start, balanced=1e-9, most=20):
        """Where the path from x = start ends, in how many steps, and whether it arrived."""
        x = PETSc.Vec().createSeq(1)
        x.array[:] = start

        def residual(at):
            self.x, f = at.array_r[0], at.duplicate()
            f.array[:] = np.interp(self.x, self._x, self._f)
            return f, abs(f.array_r[0]) <= balanced

        steps, arrived = path.follow(self, x, residual, Load(1.0), most)
        return x.array_r[0], steps, arrived


def test_where_the_determinant_changes_its_sign_the_path_turns_round():
    """The residual has to grow between 1 and 0, where a whole step of Newton's would lead back."""
    end, steps, arrived = Folded((-9, -6), (0, 3), (1, 1), (9, 9)).follow(3.0)
    assert arrived and end == pytest.approx(-3.0) and steps == 3


def test_a_path_ends_where_round_off_keeps_loads_from_balance():
    """One whole step without a change of state leads to the solution, and another has nothing left to do."""
    end, steps, arrived = Folded((-9, -8), (9, 10)).follow(-3.0, balanced=-1.0)
    assert arrived and steps == 2 and end == pytest.approx(-1.0, abs=1e-12)


def test_a_loop_that_cycles_without_it(monkeypatch):
    """Under strong coupling Newton goes on between sliding either way; along the path no load step is halved."""
    limit_stepping(monkeypatch, halvings=0)
    solved(**CYCLING)
    without_path(monkeypatch)
    with pytest.raises(SolveError, match="too many iterations"):
        solved(**CYCLING)


def test_where_all_points_slide_the_indenter_is_held(monkeypatch):
    """Under a constant Q the contact shrinks until all but one point slide, towards each other."""

    def shrunk():
        return Simulation(MPI.COMM_SELF, make_scene(SHRINKING, base=None)).run_to_end()

    assert shrunk().history.entries[-1].step.load[:2] == pytest.approx((0.5, 0.1))
    monkeypatch.setattr(path, "_fix_indenter", lambda *_: False)
    with pytest.raises(SolveError, match="singular"):
        shrunk()


@pytest.mark.parametrize("method", ["condensed", "full"])
def test_a_held_indenter_does_not_move_aside(method):
    """All equations hold but that of Q, the last but one."""
    newton = loaded_once(method).stepping._newton
    system, x = newton.system, newton.x
    b, y = x.duplicate(), x.duplicate()
    b.array[:] = np.random.default_rng(1).standard_normal(b.local_size)
    system.linearise(x)
    step = x.duplicate()
    system.solve(b, step, fixed=True)
    system.multiply(step, y)
    assert step.array_r[-2] == 0.0
    others = np.arange(b.local_size) != b.local_size - 2
    scale = np.abs(b.array_r).max()
    assert y.array_r[others] == pytest.approx(b.array_r[others], abs=1e-6 * scale)
    assert abs(y.array_r[-2] - b.array_r[-2]) > 1e-3 * scale


@pytest.mark.slow
def test_a_symmetric_contact_of_which_no_point_sticks():
    """Pressed on with little friction: where the middle is between two nodes all slide, and carry Q = 0 as they are."""
    case = "friction from first contact: friction_in_normal_stage True, k -0.5, mu 0.01"
    simulation = Simulation(MPI.COMM_SELF, make_scene(read_cases([case.partition(":")[0]])[case], base=None))
    entries = [entry for entry in simulation.run() if entry.step.branch == "normal"]
    assert not any(entry.cuts for entry in entries)
    assert max(entry.residual / entry.tolerance for entry in entries) <= 1.0


def test_a_first_contact_of_three_nodes_that_hardly_sticks(monkeypatch):
    """Where all points slide the indenter is fixed where one sticks, which is on less than 1e-9 of its way there."""
    scene = {"solid.E0": 210e9, "solid.k": -0.716, "solid.nu": -0.081, "solid.y0_over_a0": 10.0, "indenter.R": 0.1}
    load = {"load.P": 1e6, "load.mu": 0.0446, "load.amplitude": 0.65, "effects.friction_in_normal_stage": True}
    monkeypatch.setattr(Plan, "pressing_with_friction", None)  # as if a(P) were not known
    simulation = Simulation(MPI.COMM_SELF, make_scene(scene | load | {"solver.increments": 4}, base=None))
    entries = [*islice(simulation.run(), 2)]
    assert [entry.cuts for entry in entries] == [0, 0]
    assert np.count_nonzero(entries[0].surface.pressure) == 3


@pytest.mark.parametrize("cuts", [0, 1])
def test_a_new_pressure_without_coupling_is_sought_like_any_state(monkeypatch, cuts):
    """Under a new P the frictionless contact is solved beneath the tangential one: along the path, or in half steps."""
    load = DEFAULT_SCENE[DEFAULT_SCENE.index("P = 1.0e6") :]
    text = DEFAULT_SCENE.replace(load, "mu = 0.3\npoints = [[1e6, 0], [1e6, 1e5], [8e5, 1e5]]\n")
    scene = {"effects__coupling": "false", "solid__nu": 0.3, "solver__increments": 1, "reference__kind": "none"}
    expected = coarse_simulation(text, **scene).run_to_end().history.entries[-1]
    solve, missed = newton.Newton.solve, []

    def missing_once(self, load, **options):
        result = solve(self, load, **options)
        if self.system.problem.friction or load.P > 0.9 or missed:
            return result
        missed.append(load)
        return replace(result, converged=False)

    monkeypatch.setattr(newton.Newton, "solve", missing_once)
    if cuts:
        without_path(monkeypatch)
    last = coarse_simulation(text, **scene).run_to_end().history.entries[-1]
    assert missed and last.cuts == cuts
    assert last.surface.pressure == pytest.approx(expected.surface.pressure, abs=1e-8 * expected.peak_pressure)
    assert last.surface.traction == pytest.approx(expected.surface.traction, abs=0.02 * expected.peak_pressure)


def test_a_path_that_is_too_long_ends(monkeypatch):
    """It says so, with the steps that it was allowed, and no state is made of where it was."""
    limit_stepping(monkeypatch, halvings=0)
    monkeypatch.setattr(newton, "PATH", ("path_max_it", 2))
    simulation = coarse_simulation(**CYCLING)
    with pytest.raises(SolveError, match="the path does not arrive in 2 steps"):
        simulation.run_to_end()
    assert all(entry.residual <= entry.tolerance for entry in simulation.history.entries)
