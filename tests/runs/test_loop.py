"""Properties of a solved loop that need no fine mesh."""

from itertools import islice

import numpy as np
import pytest
from solving import coarse_simulation, deviations, simulated, solved, watched

from simulations.fem.mesh import Grading
from simulations.runs.comparison import relative_l2
from simulations.scene.scaling import Scales
from simulations.solvers.newton import SETTLED


@pytest.fixture(scope="module")
def condensed():
    return solved()


def test_a_cycle_counts_once_it_is_full():
    """Work and energy are those between the last two states A; before the second one those since the start."""
    simulation = coarse_simulation(load__cycles=2)
    for entry in simulation.run():
        ends = [e.dissipated for e in simulation.history.entries if e.step.state == "A"]
        expected = ends[-1] - ends[-2] if len(ends) > 1 else entry.dissipated
        assert simulation.history.dissipated_energy == pytest.approx(expected, rel=1e-12, abs=1e-15)
        work = entry.surface.line_load(simulation.history.work)
        assert work == pytest.approx(expected, rel=1e-12, abs=1e-15)
        assert simulation.history.has_cycle == (len(ends) > 1)


def test_both_methods_give_the_same_loop(condensed):
    full = solved(solver__method="full")
    for one, other in zip(condensed.history.entries, full.history.entries, strict=True):
        scale = one.surface.pressure.max()
        assert one.surface.pressure == pytest.approx(other.surface.pressure, abs=1e-7 * scale)
        assert one.surface.traction == pytest.approx(other.surface.traction, abs=1e-7 * scale)
        assert one.slip == pytest.approx(other.slip, abs=1e-8)
    assert condensed.history.dissipated_energy == pytest.approx(full.history.dissipated_energy, rel=1e-7)


def test_fields_are_in_equilibrium_after_condensation(condensed):
    """The recovered displacement field satisfies the full problem, whose residual the condensed solve never formed."""
    problem = condensed.stepping.problem
    force, imbalance = problem.terms.residual(condensed.schedule[-1].load)
    P = condensed.schedule[-1].P
    assert force.norm() < 1e-8 * P
    assert np.abs(imbalance).max() < 1e-8 * P


def test_contact_conditions_hold(condensed):
    mu = condensed.scene.load.mu
    for entry in condensed.history.entries:
        surface = entry.surface
        gap = condensed.scaled.indenter.height(surface.x) + surface.u[1] - surface.delta[1]
        assert surface.pressure.min() >= 0
        assert gap[surface.pressure == 0].min() > 0
        # the discrete gap under pressure is the method's consistency error over gamma, not zero
        assert np.abs(gap[surface.pressure > 0]).max() < 2e-3
        assert np.all(np.abs(surface.traction) <= mu * surface.pressure * (1 + 1e-9))


def test_slip_opposes_traction_and_stick_does_not_move(condensed):
    history = condensed.history
    for before, entry in zip(history.entries[1:], history.entries[2:]):
        moved = entry.slip - before.slip
        assert np.all(entry.surface.weight * entry.surface.traction * moved <= 1e-6 * abs(moved).max())
        stuck = np.abs(entry.surface.x) < 0.9 * entry.c
        assert np.abs(moved[stuck]).max() < 1e-4 * np.abs(moved).max()


@pytest.mark.parametrize("method", ["condensed", "full"])
def test_a_state_out_of_balance_is_not_accepted(method):
    """Moving two mirror nodes leaves the resultants as they are: only the forces node by node tell."""
    simulation = coarse_simulation(solver__method=method)
    entry = next(simulation.run())
    load, body = entry.step.load, simulation.body
    newton, problem = simulation.stepping._newton, simulation.stepping.problem
    assert newton.balance(load).converged
    nodes = simulation.body.surface_nodes.owned
    x = body.displacements.tabulate_dof_coordinates()[nodes, 0]
    body.complete()
    u = body.state.x.array.copy()
    body.state.x.array[2 * nodes[np.argmin(abs(x - 0.5))] + 1] += 2e-4
    body.state.x.array[2 * nodes[np.argmin(abs(x + 0.5))] + 1] -= 2e-4
    assert problem.terms.residual(load)[0].norm() > 1e-4 * load.P
    assert not newton.balance(load).converged
    result = newton.solve(load)
    assert result.converged and result.iterations > 0
    assert problem.terms.residual(load)[0].norm() < 1e-7 * load.P
    body.complete()
    assert body.state.x.array == pytest.approx(u, abs=1e-7)


@pytest.mark.parametrize("share", [1.0, 1e-4])
def test_forces_that_do_not_carry_the_load_are_not_accepted(share, monkeypatch):
    """A millionth of it is too much, however small the load is."""
    simulation = coarse_simulation()
    load, newton = next(simulation.run()).step.load, simulation.stepping._newton
    small = load._replace(P=share * load.P)
    for imbalance, is_accepted in ((1e-6, False), (1e-10, True)):
        monkeypatch.setattr(newton.system, "residual", lambda x, f: (0.0, imbalance * small.P))
        assert newton.balance(small).converged == is_accepted


def test_round_off_counts_over_the_load():
    """The same displacements under a tenth of the load leave ten times as much of it."""
    simulation = coarse_simulation()
    load, newton = next(simulation.run()).step.load, simulation.stepping._newton
    more, less = (newton.balance(load._replace(P=P * load.P)).tolerance for P in (1e-6, 1e-5))
    assert more == pytest.approx(10 * less, rel=1e-9) and less > newton.balance(load).tolerance


def test_tractions_that_do_not_carry_the_load_are_seen_though_the_forces_do():
    """The nodal forces stay as the indenter goes deeper, and the pressure that is reported grows."""
    simulation = coarse_simulation()
    load, solver = next(simulation.run()).step.load, simulation.stepping
    system, x = solver._newton.system, solver._newton.x
    system.begin(load, x)
    x.array[-1] += 1e-4
    _, imbalance = system.residual(x, x.duplicate())
    system.finish(x)
    surface = simulation.sampler.sample(solver.problem)
    assert imbalance == pytest.approx(surface.line_load(surface.pressure) - load.P, rel=1e-6) and imbalance > 1e-4


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_what_a_step_of_newtons_method_raises_is_no_error_of_petsc(error, monkeypatch):
    simulation = coarse_simulation()
    load, newton = next(simulation.run()).step.load, simulation.stepping._newton

    def stop(x):
        raise error("stop")

    monkeypatch.setattr(newton.system, "linearise", stop)
    with pytest.raises(error, match="stop"):
        newton.solve(load._replace(P=load.P / 2))


@pytest.mark.parametrize("predict", [False, True])
def test_every_linear_solve_is_an_iteration(predict, monkeypatch):
    """The predictor too."""
    simulation = coarse_simulation()
    load = [entry.step.load for entry in islice(simulation.run(), 2)][-1]
    newton = simulation.stepping._newton
    solves = watched(monkeypatch, newton.system, "solve")
    result = newton.solve(load._replace(Q=(1.1 - 0.2 * predict) * load.Q), predict=predict)
    assert result.converged and result.iterations == len(solves) > 1


def test_an_end_by_a_rule_of_petsc_is_no_solution():
    """One linear step, after which SNES says that it has converged."""
    simulation = coarse_simulation()
    load, newton = next(simulation.run()).step.load, simulation.stepping._newton
    newton.snes.setType("ksponly")
    assert not newton.solve(load._replace(P=load.P / 2)).converged and newton.snes.getConvergedReason() > 0


def test_a_balanced_state_gets_one_more_step(condensed):
    assert max(entry.residual for entry in condensed.history.entries) < SETTLED


def test_repeated_increment_changes_nothing():
    simulation = coarse_simulation()
    states = simulation.run()
    for _ in range(3):
        entry = next(states)
    u = simulation.body.state.x.array.copy()
    result = simulation.stepping._newton.solve(entry.step.load)
    assert result.converged and result.iterations <= 1
    assert simulation.body.state.x.array == pytest.approx(u, abs=1e-8)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_units(condensed, factor):
    """Lengths and stresses in other units give the same numbers in those units."""
    length, stress = factor, 1 / factor**1.5
    keys = condensed.scene.to_keys()
    factors = {"solid.E0": stress, "solid.y0": length, "indenter.R": length, "load.P": stress * length}
    other = simulated(keys | {name: keys[name] * by for name, by in factors.items()}, base=None)
    mine, theirs = condensed.history.entries[-1], other.history.entries[-1]
    units, others = Scales.of(condensed.scene), Scales.of(other.scene)
    assert others.stress * theirs.surface.pressure == pytest.approx(
        units.stress * stress * mine.surface.pressure, rel=1e-7, abs=1e-7 * units.stress * stress
    )
    assert others.displacement * theirs.slip == pytest.approx(
        units.displacement * length * mine.slip, rel=1e-7, abs=1e-9 * units.displacement * length
    )
    energy = units.energy * stress * length**2 * condensed.history.dissipated_energy
    assert others.energy * other.history.dissipated_energy == pytest.approx(energy, rel=1e-8)


def test_edges_are_read_off_the_solution():
    """Refinement put 4 % off the edges, to either side: the edges found stay where they are."""
    for shift in (-0.04, 0.04):
        loop = coarse_simulation().loop
        edges = [sign * (position + shift) for sign in (-1, 1) for position in (loop.a, loop.c)]
        cells = Grading(tuple(edges), facet=0.02, edge_facet=2e-3, first_layer=5e-3, layer_growth=1.4)
        deviation = deviations(solved(cells=cells))
        assert abs(deviation["a"]) < 1e-3
        assert abs(deviation["c"]) < 2e-3


def test_pressure_converges_with_second_order():
    """Halving the facets (and the grading with them) divides the nodal pressure error by about four."""
    errors = []
    for facet, growth in ((0.1, 2.0), (0.05, 2.0**0.5), (0.025, 2.0**0.25)):
        simulation = coarse_simulation(
            mesh__facet=facet,
            mesh__growth=growth,
            mesh__edge_facet=1e-3,
            mesh__layer_growth=1.25,
            load__cycles=0,  # no edge stops between the others, where facets would stay as they are
            solver__increments=1,
        )
        entry = next(simulation.run())
        exact = simulation.loop.contact.pressure(entry.surface.x)
        errors.append(relative_l2(entry.surface.weight, entry.surface.pressure, exact))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates == pytest.approx(2.0, abs=0.5), f"errors {errors}"


def test_domain_of_20_a_is_large_enough():
    """With the far field prescribed the truncation error falls like extent^-3.3; at 20 a it is about 1e-6."""
    fine = {"mesh__facet": 0.05, "mesh__growth": 1.2, "mesh__edge_facet": 1e-3, "mesh__layer_growth": 1.2}
    energy = {
        extent: solved(**fine, mesh__extent=extent, solver__increments=1).history.dissipated_energy
        for extent in (5.0, 10.0, 20.0, 40.0)
    }
    difference = {extent: abs(energy[extent] / energy[40.0] - 1) for extent in (5.0, 10.0, 20.0)}
    assert difference[20.0] < 3e-6
    assert difference[10.0] < difference[5.0] / 5
    assert difference[20.0] < difference[10.0] / 5
