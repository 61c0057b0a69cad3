"""Elastic slip: against the half-plane solver with the same term, its limit to zero, and what it does not change."""

import numpy as np
import pytest
from solving import coarse_simulation, metered, simulated, solved

from analytic import GradedHalfPlane, HalfPlaneContact, PowerLawKernel
from analytic.half_plane.critical_friction import RateOperator, smallest_singular
from analytic.half_plane.operator import element_moments
from simulations.runs import checks
from simulations.runs.comparison import compare
from simulations.runs.energy import worst_defect
from simulations.runs.mesh_free import MeshFree
from simulations.runs.plan import Plan
from simulations.runs.reference import neglected, of_same_physics
from simulations.runs.report_data import find
from simulations.runs.timing import Stopwatch
from simulations.scene import make_scene

LOOP = {"solid__k": 0.3, "solid__nu": 0.3, "load__mu": 0.3, "load__cycles": 0, "solver__increments": 4}


def with_elastic_slip(length, **changes):
    """A coarse simulation with elastic slip of ``length`` P/E(a)."""
    metres = length * coarse_simulation(**LOOP).scaled.scales.displacement
    return coarse_simulation(**LOOP, effects__elastic_slip=metres, **changes)


def l2(surface, difference, scale):
    return np.sqrt(surface.line_load(difference**2) / surface.line_load(scale**2))


@pytest.fixture(scope="module")
def elastic():
    """A run, and its energy balance."""
    simulation = with_elastic_slip(0.1)
    return simulation, worst_defect(metered(simulation))


def test_is_that_of_the_half_plane_solver_at_every_state(elastic):
    simulation, balance = elastic
    entries, mu = simulation.history.entries, simulation.mu
    solver = HalfPlaneContact(simulation.scaled.kernel, simulation.scaled.indenter, mu, nodes=120, elastic=0.2 / mu)
    states = solver.run([entry.step.load.P, entry.step.load.Q] for entry in entries)
    for entry, state in zip(entries, states, strict=True):
        surface = entry.surface
        p, q = (np.interp(surface.x, state.x, f, left=0, right=0) for f in (state.pressure, state.traction))
        assert l2(surface, surface.pressure - p, p) < 4e-3
        assert l2(surface, surface.traction - q, mu * p) < 4e-3
    assert simulation.history.dissipated_energy == pytest.approx(states[-1].dissipated_energy, rel=2e-2)
    assert balance < 1e-8  # with what the elastic slip stores


def test_the_run_holds_its_checks_and_says_that_it_is_regularised(elastic):
    simulation, _ = elastic
    found = checks.check(simulation.history, simulation.scaled.indenter.height)
    assert checks.hold(found), checks.describe(found)
    assert "elastic slip (regularised)" in simulation.effects


@pytest.mark.parametrize("coupling", ["true", "false"])
def test_its_reference_has_it_too(coupling):
    """Without it the reference would be off by a hundred times as much."""
    simulation = with_elastic_slip(0.1, effects__coupling=coupling).run_to_end()
    reference = of_same_physics(simulation)
    assert isinstance(reference, MeshFree)
    found = compare(simulation.history, reference)
    assert found["pressure_l2"] < 4e-3 and found["traction_l2"] < 6e-3 and found["slip_l2"] < 6e-3
    assert "elastic slip (regularised)" in neglected(simulation)


@pytest.mark.slow
def test_its_stated_error_covers_the_load_steps():
    """Where coupling moves the contact much the mesh-free solver needs many of them too, to be nearer than the run.

    The energy is that of an independent solver of linear elements, 96 load steps a quarter and 450 to 600 nodes.
    """
    loop = {"solid.modulus": "homogeneous", "solid.E0": 210e9, "solid.nu": 0.2, "load.P": 1e6, "load.mu": 0.4}
    loop |= {"load.amplitude": 0.7, "effects.elastic_slip": 1e-6, "solver.increments": 4}
    mesh = {"mesh.facet": 0.1, "mesh.edge_facet": 0.01, "mesh.growth": 1.5}
    simulation = simulated(loop | mesh | {"indenter.R": 0.1}, base=None)
    found = find(simulation)
    error = abs(found.quantities["dissipated_energy"] / 0.08112 - 1)
    stated = abs(found.exact.deviations["dissipated_energy"])
    assert 5e-3 < error < stated < 1.5 * error and abs(found.exact.own["dissipated_energy"]) > 1e-3


@pytest.mark.parametrize("coupling", [False, True])
def test_the_mesh_is_graded_to_its_own_edges(coupling):
    """Stick ends elsewhere than under Coulomb's law, at 0.65 to 0.75 a."""
    loop = {"load.mu": 0.3, "load.amplitude": 0.6, "effects.coupling": coupling, "effects.elastic_slip": 1e-7}
    cells = Plan(make_scene(loop), Stopwatch()).grading()
    stick = [edge for edge in cells.edges if 0 < edge < 0.9]
    assert cells.edge_at < 0 and stick and all(0.65 < edge < 0.76 for edge in stick)


def test_its_limit_is_coulombs_law():
    expected, differences = solved(**LOOP).history.entries[-1].surface.traction, []
    for length in (0.03, 0.01, 0.003):
        last = with_elastic_slip(length).run_to_end().history.entries[-1].surface
        differences.append(l2(last, last.traction - expected, last.traction))
    assert differences[0] < 0.03 and differences[-1] < 0.006
    assert all(b < 0.6 * a for a, b in zip(differences, differences[1:]))


def test_it_does_not_raise_the_critical_coefficient():
    """The patterns have one stuck element, whose own motion does not matter."""
    nodes = np.linspace(-1, 1, 11)
    kernel = PowerLawKernel(GradedHalfPlane(1.0, 0.0, 0.0, 1.0))
    normal, tangential, coupling = element_moments(kernel, (nodes[1:] + nodes[:-1]) / 2, nodes)[:, 0]
    found = [
        smallest_singular(RateOperator.from_compliance(tangential + c * np.eye(10), coupling, -coupling, normal))[0]
        for c in (0.0, 0.1, 10.0)
    ]
    assert found == pytest.approx([found[0]] * 3, rel=1e-6)
