"""Indenters other than the parabola, each against the closed form of its own profile (5)-(8), and given load paths."""

import numpy as np
import pytest
from solving import deviations, simulated, solved

from simulations.runs import checks
from simulations.runs.comparison import compare, compare_state
from simulations.runs.mesh_free import MeshFree
from simulations.runs.reference import closed_form
from simulations.scene import DEFAULT_SCENE, parse

MEDIUM = {
    "mesh__facet": 0.04,
    "mesh__edge_facet": 1e-3,
    "mesh__growth": 1.3,
    "mesh__first_layer": 1e-3,
    "mesh__layer_growth": 1.4,
    "solver__increments": 2,
}
UNCOUPLED = {"effects__coupling": "false", "solid__nu": 0.3}
PROFILES = {
    "cubic": 'profile = "power"\nexponent = 3',
    "quartic": 'profile = "power"\nexponent = 4',
    "circle": 'profile = "circle"',
    "rounded flat": 'profile = "rounded flat"\nflat = 4e-4',
    "formula": 'profile = "formula"\nformula = "R*cosh(x/R) - R + x**4/(1e-6*R)"',
}


def scene_with(profile):
    return DEFAULT_SCENE.replace("[indenter]", "[indenter]\n" + PROFILES[profile])


@pytest.mark.parametrize("profile, k", [("cubic", 0.3), ("quartic", 0.0)])
def test_powers_match_the_abel_solution(profile, k):
    for name, deviation in deviations(solved(scene_with(profile), **MEDIUM, **UNCOUPLED, solid__k=k)).items():
        assert abs(deviation) < 1e-3, name


@pytest.mark.parametrize("profile", ["circle", "rounded flat", "formula"])
def test_other_profiles_match_their_closed_form(profile):
    for name, deviation in deviations(solved(scene_with(profile), **MEDIUM)).items():
        assert abs(deviation) < 2e-3, name


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_contact_that_ends_on_the_flat_has_a_gap():
    solid = {"solid.E0": 210e9, "solid.nu": 0.3, "solid.modulus": "homogeneous"}
    pressed = solid | {"indenter.profile": "rounded flat", "indenter.R": 0.1, "indenter.flat": 1e-3, "load.P": 1.0}
    simulation = simulated(pressed, base=None)
    found = checks.check(simulation.history, simulation.scaled.indenter.height)
    assert found["gap >= 0"].holds


@pytest.mark.parametrize("R", [0.09, 0.095, 0.1, 1e5])
def test_the_digits_of_the_radius_are_not_in_the_order(R):
    assert parse(DEFAULT_SCENE, (f"indenter.R={R}", f"load.P={1e7 * R}")).shape.order == 2.0


def test_a_circle_may_end_above_the_mesh():
    """Under a large load the domain may be wider than the cylinder."""
    simulation = solved(scene_with("circle"), load__P=1.6e7, load__cycles=0, mesh__extent=40)
    assert simulation.cells.extent * simulation.scaled.scales.length > simulation.scene.indenter.R


def test_a_formula_is_its_profile():
    """The parabola written out runs through sympy and the general closed form, and changes nothing."""
    written = DEFAULT_SCENE.replace("[indenter]", '[indenter]\nprofile = "formula"\nformula = "x**2/(2*R)"')
    one, other = solved(), solved(written)
    assert other.history.entries[-1].surface.traction == pytest.approx(
        one.history.entries[-1].surface.traction, rel=1e-6, abs=1e-7
    )


@pytest.mark.parametrize("coupling", ["false", "true"])
def test_any_path_of_loads_with_varying_pressure(coupling):
    """P rises and falls while Q moves, the contact shrinks and grows: against the half-plane solver."""
    lines = [line for line in DEFAULT_SCENE.splitlines() if not line.startswith(("P ", "amplitude", "cycles"))]
    path = "[[1.0e6, 0.0], [1.0e6, 2.0e5], [0.6e6, 1.0e5], [1.0e6, -1.0e5]]"
    text = "\n".join(lines) + f"\npoints = {path}\n"
    steps = 6
    coarser = {"mesh__edge_facet": 3e-3, "mesh__first_layer": 3e-3, "solver__increments": steps}
    simulation = solved(text, **(MEDIUM | coarser), effects__coupling=coupling, solid__nu=0.3)
    other = MeshFree(simulation, nodes=(300,))
    found = [compare_state(entry, other) for entry in simulation.history.entries]
    # while P is constant, or falls
    for name, limit in {"pressure_l2": 1e-3, "traction_l2": 5e-3, "slip_l2": 5e-3}.items():
        assert max(state.get(name, 0.0) for state in found[: 1 + 2 * steps]) < limit, name
    # Where P grows again the solver, with load steps of its own, is of first order in them: with two for one of the run
    # q is 3e-2 off what it has with eight.
    assert found[-1]["pressure_l2"] < 2e-3 and found[-1]["traction_l2"] < 6e-2
    deviation = compare(simulation.history, other)
    assert abs(deviation["a"]) < 1e-3 and abs(deviation["dissipated_energy"]) < 1e-2
    P = [entry.surface.line_load(entry.surface.pressure) for entry in simulation.history.entries]
    assert P == pytest.approx([step.P for step in simulation.schedule], rel=1e-8)
    assert np.ptp(P) == pytest.approx(0.4)


@pytest.mark.parametrize("shape", [{}, {"profile": "power", "exponent": 4}, {"profile": "rounded flat", "flat": 2e-4}])
def test_relief_without_friction_ends_in_fine_facets(shape):
    """Contact is measured as well after relief as under the largest load: the mesh is graded to every point."""
    keys = {"solid.E0": 210e9, "solid.k": 0.3, "solid.nu": 0.3, "solid.y0": 5e-3, "indenter": {"R": 0.1} | shape}
    keys |= {"load.points": [[1e6, 0], [2e6, 0], [4e5, 0]], "solver.increments": 2}
    simulation = simulated(keys | {"mesh.facet": 0.1, "mesh.edge_facet": 0.01, "mesh.first_layer": 0.01}, base=None)
    found = compare(simulation.history, closed_form(simulation))
    assert abs(found["a"]) < 1.5e-2 and found["pressure_l2"] < 5e-3
