"""Runs that are possible and beyond what theory or mesh show well: they say so in every place."""

import json

import pytest
from running import COARSE, coarse_arguments, coarse_overrides, run_command
from solving import coarse_simulation, simulated

from analytic import ContactNotConverged
from simulations import parse, run
from simulations.runs import expected_edges
from simulations.runs.comparison import compare, compare_all
from simulations.runs.explain import explain
from simulations.runs.mesh_free import MeshFree
from simulations.runs.reference import closed_form, of_same_physics
from simulations.runs.report_data import compared, summary
from simulations.runs.warnings import NARROWEST_STICK
from simulations.scene import DEFAULT_SCENE, SceneError
from simulations.scene.steepness import SMALL, edge_slope
from simulations.studies.sweeping import sweep

STEEP = {"load.P": 6e8, "load.cycles": 0, "solver.increments": 1}  # a/R = 0.26
WORDS = "a = 0.0256 m on indenter.R = 0.1 m: the slope of the indenter where contact ends is 0.26; up to 0.2"


def test_an_ordinary_run_has_none():
    simulation = coarse_simulation()
    assert simulation.warnings == summary(simulation, None)["warnings"] == []
    assert "warning" not in explain(simulation)


def test_a_steep_indenter_is_told_in_every_place(tmp_path):
    with pytest.warns(UserWarning, match="slope of the indenter") as told:
        simulation = run(COARSE | STEEP).simulation
    (words,) = simulation.warnings
    assert WORDS in words and [str(warning.message) for warning in told] == [words]
    assert explain(simulation).endswith(f"\nwarning                    {words}")
    others = [override for override in coarse_overrides() if override.partition("=")[0] not in STEEP]
    (row,) = sweep(vary=[STEEP], sets=others)
    assert row["warnings"] == words
    done = run_command("--quiet", *coarse_arguments(tmp_path, **STEEP))
    assert done.returncode == 0 and done.stderr == f"warning: {words}\n"
    assert json.loads((tmp_path / "summary.json").read_text())["warnings"] == [words]


def test_a_formula_that_falls_again_is_told():
    """Beside the first crest of a wavy indenter its next ones would touch: their pressure is not in the results."""
    formula = {"indenter__profile": "formula", "load__P": 1e5}
    wavy, round_ = (
        coarse_simulation(indenter__formula=text, **formula).warnings
        for text in ("1e-5*(1-cos(3141.592654*x))", "R*cosh(x/R) - R")
    )
    assert not round_ and len(wavy) == 1 and "indenter.formula falls again: at x = 0.0018" in wavy[0]


def test_a_long_elastic_slip_is_told():
    short, long = (coarse_simulation(effects__elastic_slip=length).warnings for length in (4e-8, 4e-7))
    assert not short and len(long) == 1 and "mu P/E(a), which is long" in long[0]


@pytest.mark.parametrize(
    "keys",
    [
        ("load.P=1e9",),
        ("load.P=1e9", "indenter.profile=circle"),
        ("load.P=2e9", "indenter.profile=rounded flat", "indenter.flat=1e-3"),
        ("load.P=1e9", "solid.modulus=power-law coating", "solid.thickness=1e-3", "solid.nu=0.3"),
    ],
)
def test_the_slope_is_that_of_the_indenter_where_contact_ends(keys):
    """f' from heights on either side of a. A parabola is lower than its circle by slope²/4: at the limit by 1 %."""
    scene = parse(DEFAULT_SCENE, keys)
    a, step = scene.half_width, 1e-6 * scene.half_width
    heights = scene.shape.height([a - step, a + step])
    assert edge_slope(a, scene.indenter) == pytest.approx((heights[1] - heights[0]) / (2 * step), rel=1e-6)
    assert 1 - (SMALL**2 / 2) / (1 - (1 - SMALL**2) ** 0.5) == pytest.approx(0.01, rel=0.02)


@pytest.mark.parametrize("profile", ["parabola", "circle"])
def test_no_contact_is_wider_than_its_cylinder(profile):
    keys = (f"indenter.profile={profile}", "solid.nu=0.3")
    with pytest.raises(SceneError, match="look at solid.E0 = 210 Pa, .* load.P = 1e.06 N/m, indenter.R = 0.1 m"):
        parse(DEFAULT_SCENE, (*keys, "solid.E0=210"))
    assert parse(DEFAULT_SCENE, (*keys, "solid.E0=210e6")).half_width < 0.1


@pytest.mark.parametrize("share, least, most", [(1.0, 1e-3, 0.05), (0.6, 0.1, 0.3)])
def test_a_stick_zone_is_told_where_its_half_width_is_off(share, least, most):
    """By the closed form c = (1 - Q_A/(mu P))^(1/(2+k)) a: with 5 edge_facet c is off by 3 %, with 3 by 24 %."""
    c = 1.001 * share * NARROWEST_STICK * 4e-3
    keys = {"solid.k": 0.5, "solid.nu": 0.3, "load.amplitude": 1 - c**2.5, "effects.coupling": False}
    keys |= {"mesh.edge_facet": 4e-3, "solver.increments": 2}
    simulation = simulated(keys)
    assert least < abs(compare(simulation.history, of_same_physics(simulation))["c"]) < most
    told = [words for words in simulation.warnings if "is too coarse for c/a" in words]
    assert len(told) == (share < 1)
    for words in told:
        assert f"mesh.edge_facet = 0.004 is too coarse for c/a: the stick half-width is {c:.2g} a" in words
        assert words.endswith(f"at load.amplitude = {1 - c**2.5} and needs 0.002 or less")  # rounded it could be 1


@pytest.mark.parametrize(
    "k, mu, low, told", [(-0.5, 0.8, 0.14, "is 6.2e+09 Pa"), (-0.5, 0.5, 1.0, "is infinite"), (0.3, 0.3, 0.0, "")]
)
def test_a_peak_that_the_mesh_hides_is_told_and_not_compared(k, mu, low, told):
    """By Spence's similar solution: pressed on with friction, slip from both sides meets at x = 0."""
    keys = {"solid.k": k, "solid.nu": 0.0, "load.mu": mu, "effects.friction_in_normal_stage": True}
    keys |= {"load.cycles": 0, "solver.increments": 1, "load.amplitude": 0.1}
    simulation = simulated(keys)
    pressed = [entry for entry in simulation.history.entries if entry.step.branch == "normal"][-1]
    exact = simulation.pressing_with_friction.pressure(0.0)
    assert 1 - pressed.peak_pressure / exact == pytest.approx(low, abs=0.01)
    words = [words for words in simulation.warnings if "the pressure peaks at x = 0" in words]
    assert len(words) == bool(told) and all(f"the exact peak after pressing {told}" in one for one in words)
    assert ("peak_pressure" in compared(simulation, closed_form(simulation)).values) == (not told)
    if told == "is infinite":  # what a node lacks of that is no error of the field
        reference = MeshFree(simulation, nodes=(100,))
        without = compare_all(simulation.history, reference).worst["pressure_l2"]
        reference.without_middle = False
        assert without < 0.015 and compare_all(simulation.history, reference).worst["pressure_l2"] > 0.025


@pytest.mark.parametrize("m, k, low, told", [(1.2, 0.0, 0.22, True), (1.3, -0.3, None, True), (1.5, 0.4, 7e-4, False)])
def test_a_sharp_tip_that_the_mesh_blunts_is_told_and_not_compared(m, k, low, told):
    """p falls from its peak like |x|^(m+k-1), from an infinite one where this power is not positive."""
    keys = {"solid.E0": 210e9, "solid.nu": 0.25, "solid.k": k, "solid.y0": 2e-3, "indenter.profile": "power"}
    keys |= {"indenter.R": 0.1, "indenter.exponent": m, "load.P": 1e6}
    simulation = simulated(keys, base=None)
    exact, (last,) = simulation.contact.pressure(0.0), simulation.history.entries
    if low is None:
        assert exact == float("inf")
    else:
        assert 1 - last.peak_pressure / exact == pytest.approx(low, rel=0.05)
    words = [words for words in simulation.warnings if f"under a tip f ~ |x|^{m}" in words]
    assert len(words) == told and all(("is infinite" in one) == (low is None) for one in words)
    found = compared(simulation, of_same_physics(simulation))
    assert ("peak_pressure" in found.values) == (not told)
    if not told:
        assert found.deviations["peak_pressure"] == pytest.approx(-low, rel=0.05)
        assert found.deviations["pressure_l2"] < 1.2e-4


def test_edges_that_are_not_found_before_are_told(monkeypatch):
    """As far above the critical coefficient of friction: the mesh is less well graded, which is no reason to stop."""

    def fail(*_):
        raise ContactNotConverged("more than 320 changes of status")

    monkeypatch.setattr(expected_edges, "_rough_edges_of_loop", fail)
    simulation = coarse_simulation(load__mu=0.9, effects__elastic_slip=1e-8)
    (words,) = simulation.warnings
    assert simulation.cells.edges == (-1.0, 1.0) and "edges were not found before: more than 320 changes" in words
