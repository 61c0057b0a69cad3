"""Graded coatings on a homogeneous substrate, against the half-plane solver with the kernel of the same coating."""

import numpy as np
import pytest
from solving import solved

from simulations.loading.stepping import SolveError
from simulations.runs import checks
from simulations.runs.comparison import compare, compare_all
from simulations.runs.coupled_loop import serves
from simulations.runs.mesh_free import MeshFree
from simulations.runs.reference import of_same_physics
from simulations.runs.step_free import StepFree
from simulations.scene import SceneError, make_scene
from simulations.scene.effects import Effects
from simulations.scene.scaling import Scaled
from simulations.scene.solid import homogeneous_half_width

CYLINDER = """[indenter]
R = 0.1
[load]
P = 1.0e6
mu = 0.3
amplitude = 0.9
"""
SCENE = """
[solid]
modulus = "{modulus}"
E0 = 210e9
nu = 0.3
{more}
thickness_over_a0 = {thickness}
""" + CYLINDER
TABLE = """
[solid]
modulus = "tabulated"
points = [[0.0, 210e9], [1e-3, 70e9]]
nu = 0.3
""" + CYLINDER
MEDIUM = {
    "mesh__facet": 0.04,
    "mesh__edge_facet": 2e-3,
    "mesh__growth": 1.35,
    "mesh__first_layer": 1e-3,
    "mesh__layer_growth": 1.4,
    "solver__increments": 3,
}
POWER_LAW = "k = 0.3\ny0_over_a0 = 10.0"
COATINGS = {
    "power-law coating": (POWER_LAW, 2.0),
    "linear": ("E_substrate = 70e9", 1.0),
    "exponential": ("E_substrate = 400e9", 0.5),
}


@pytest.mark.parametrize("modulus, coupling", [*((modulus, "true") for modulus in COATINGS), ("linear", "false")])
def test_coated_half_planes_match_the_half_plane_solver(modulus, coupling):
    more, thickness = COATINGS[modulus]
    simulation = solved(
        SCENE.format(modulus=modulus, more=more, thickness=thickness), **MEDIUM, effects__coupling=coupling
    )
    found = compare(simulation.history, MeshFree(simulation))
    for name, limit in {"pressure_l2": 2e-3, "traction_l2": 7e-3, "a": 5e-4, "dissipated_energy": 2e-3}.items():
        assert abs(found[name]) < limit, (name, found[name])


@pytest.mark.slow
def test_a_power_law_coating_has_a_reference_without_load_steps():
    """Known to 2e-6 and not to 3e-4, as the solver with load steps knows itself; the mesh is graded to its edges."""
    more, thickness = COATINGS["power-law coating"]
    simulation = solved(SCENE.format(modulus="power-law coating", more=more, thickness=thickness), **MEDIUM)
    reference = of_same_physics(simulation)
    assert isinstance(reference, StepFree) and not reference.open
    found = compare_all(simulation.history, reference)
    for name, limit in {"pressure_l2": 3e-4, "traction_l2": 3e-3, "slip_l2": 5e-4}.items():
        assert found.worst[name] < limit, (name, found.worst[name])
    assert max(found.own.values()) < 2e-6


@pytest.mark.parametrize(
    "modulus, more, thickness, expected",
    [
        ("power-law coating", POWER_LAW, 0.3, True),
        ("power-law coating", POWER_LAW, 0.05, False),  # too thin for its polynomials
        ("linear", "E_substrate = 70e9", 1.0, True),
        ("linear", "E_substrate = 70e9", 0.1, False),  # too steep
        ("exponential", "E_substrate = 400e9", 0.5, True),
        ("exponential", "E_substrate = 20e9", 0.5, False),
    ],
)
def test_coatings_without_load_steps(modulus, more, thickness, expected):
    text = SCENE.format(modulus=modulus, more=more, thickness=thickness)
    scene = make_scene(base=text)
    assert serves(scene, Effects(scene)) is expected
    pressed = make_scene({"effects.friction_in_normal_stage": True}, text)
    assert not serves(pressed, Effects(pressed))


def test_a_table_of_two_points_is_a_linear_coating():
    line = make_scene(base=SCENE.format(modulus="linear", more="E_substrate = 70e9", thickness=1.0))
    points = [[0.0, 210e9], [line.solid.thickness, 70e9]]
    table = make_scene({"solid.points": points}, TABLE)
    assert table.half_width == pytest.approx(line.half_width, rel=1e-12)
    assert "grading" in Effects(table)
    one, other = (solved(scene, **MEDIUM).history.entries for scene in (line.to_toml(), table.to_toml()))
    for entry, expected in zip(one, other, strict=True):
        assert (*entry.contact, *entry.stick) == pytest.approx((*expected.contact, *expected.stick), abs=1e-7)


@pytest.mark.parametrize("first, expected", [(1e-5, False), (5e-4, True)])
def test_what_counts_for_a_table_is_its_first_layer(first, expected):
    scene = make_scene({"solid.points": [[0.0, 210e9], [first, 209e9], [1e-3, 70e9]]}, TABLE)
    assert serves(scene, Effects(scene)) is expected
    assert Scaled.of(scene).kernel.first_layer == pytest.approx(first / scene.half_width)


def test_a_film_far_thinner_than_the_contact_has_its_kernel():
    text = SCENE.format(modulus="linear", more="E_substrate = 70e9", thickness=1e-5)
    assert Scaled.of(make_scene(base=text)).kernel.misfit.max() < 1e-6


def test_a_contact_too_wide_for_its_indenter_names_the_table():
    with pytest.raises(SceneError, match="look at solid.points, load.P"):
        make_scene({"load.P": 1e11}, TABLE)


def test_the_scale_of_a_table_that_goes_up_and_down():
    """It is the half-width on a body of the modulus at this depth, which here is beyond those of both ends."""
    points = [[0.0, 127e9], [0.4e-3, 180e9], [0.8e-3, 86e9], [1.2e-3, 90e9], [3e-3, 160e9]]
    scene = make_scene({"solid.points": points}, TABLE)
    a = scene.half_width
    E = float(np.interp(a, *np.transpose(points)))
    assert E < 127e9 and a == pytest.approx(homogeneous_half_width(E, 0.3, scene.shape, scene.P), rel=1e-5)


@pytest.mark.slow
def test_a_table_has_the_reference_of_its_own_modulus():
    """Close to an exponential coating, each beside its own reference; the contact on both differs by what the table's
    six points leave."""
    base = make_scene(base=SCENE.format(modulus="exponential", more="E_substrate = 400e9", thickness=1.0))
    h = base.solid.thickness
    points = [[float(share * h), float(210e9 * (400 / 210) ** share)] for share in np.linspace(0, 1, 6)]
    table = solved(make_scene({"solid.points": points}, TABLE).to_toml(), **MEDIUM)
    reference = of_same_physics(table)
    assert isinstance(reference, StepFree) and not reference.open
    found = compare_all(table.history, reference)
    for name, limit in {"pressure_l2": 1e-3, "traction_l2": 5e-3, "slip_l2": 1e-3}.items():
        assert found.worst[name] < limit, (name, found.worst[name])
    assert max(found.own.values()) < 3e-4
    exponential = solved(base.to_toml(), **MEDIUM).history
    scale = table.scaled.scales.length / base.half_width
    for entry, other in zip(table.history.entries, exponential.entries, strict=True):
        assert entry.a * scale == pytest.approx(other.a, rel=2e-3)
        assert entry.a * scale != pytest.approx(other.a, rel=1e-5)


def test_a_thick_coating_is_the_power_law():
    """What a coating leaves out of the power law falls with its thickness."""
    whole = solved(**MEDIUM, solid__nu=0.3, load__cycles=0, effects__coupling="false")
    off = []
    for thickness in (2.0, 20.0):
        coated = solved(
            SCENE.format(modulus="power-law coating", more=POWER_LAW, thickness=thickness),
            **MEDIUM,
            load__cycles=0,
            effects__coupling="false",
        )
        widths = [s.history.entries[-1].a * s.scaled.scales.length for s in (whole, coated)]
        off.append(abs(widths[1] / widths[0] - 1))
    assert off[0] > 1e-2
    assert off[1] < off[0] / 4


def test_edges_are_read_with_the_powers_that_coupling_gives_at_the_surface():
    """A coating as stiff as its substrate has the edges of the homogeneous body; else a is off by 1e-3, c by 3e-3."""
    coating = SCENE.format(modulus="linear", more="E_substrate = 210e9", thickness=1.0)
    plain = SCENE.format(modulus="homogeneous", more="", thickness="").replace("thickness_over_a0 = ", "")
    whole = solved(plain, **MEDIUM, load__mu=0.6)
    coated = solved(coating, whole.cells, **MEDIUM, load__mu=0.6)
    for one, other in zip(coated.history.entries[1:], whole.history.entries[1:], strict=True):
        assert (*one.contact, *one.stick) == pytest.approx((*other.contact, *other.stick), abs=1e-4)


def test_edges_in_facets_thicker_than_the_coating_are_read_with_the_power_of_the_substrate():
    """With that of the coating, (1+k)/2, contact seemed 2 % wider."""
    text = SCENE.format(modulus="power-law coating", more="k = 0.5\ny0_over_a0 = 10.0", thickness=1e-3)
    simulation = solved(text.replace("mu = 0.3\namplitude = 0.9\n", ""))
    assert abs(compare(simulation.history, MeshFree(simulation))["a"]) < 1e-3


def test_the_energy_of_pressing_with_friction_needs_more_load_steps_of_it():
    """So the cause that a check of errors tells names their key: more load steps of Q leave it as it is."""
    text = SCENE.format(modulus="linear", more="E_substrate = 70e9", thickness=1.0)
    text += "[effects]\nfriction_in_normal_stage = true\n"

    def pressed(normal, quarter, cells=None):
        steps = {"solver__normal_increments": normal, "solver__increments": quarter, "load__cycles": 0}
        return solved(text, cells, **steps)

    few = pressed(3, 1)
    energy = few.history.dissipated_energy
    assert pressed(3, 4, few.cells).history.dissipated_energy == pytest.approx(energy, rel=0.01)
    assert pressed(12, 1, few.cells).history.dissipated_energy < 0.96 * energy
    assert "solver.normal_increments" in checks.LARGE


@pytest.mark.parametrize(
    "modulus, more, thickness",
    [
        ("exponential", "E_substrate = 2.1e9", 1.0),  # a substrate 100 times softer
        ("power-law coating", "k = -0.6\ny0_over_a0 = 1.0", 0.3),
    ],
)
def test_stiff_skins_have_a_reference(modulus, more, thickness):
    simulation = solved(SCENE.format(modulus=modulus, more=more, thickness=thickness), **MEDIUM, load__cycles=0)
    found = compare(simulation.history, MeshFree(simulation))
    for name, limit in {"pressure_l2": 5e-3, "traction_l2": 1e-2, "a": 4e-3, "dissipated_energy": 5e-3}.items():
        assert abs(found[name]) < limit, (name, found[name])


def test_a_coating_that_is_out_of_reach_is_named():
    """A soft film on a substrate 1e4 times as stiff: no answer."""
    text = SCENE.format(modulus="linear", more="E_substrate = 2.1e15", thickness=0.01)
    said = r"end of \|x\| < .*solid.thickness = 7.43e-06 m and solid.E_substrate = 1e\+04 s"
    with pytest.raises(SolveError, match=said):
        solved(text, load__cycles=0, effects__coupling="false")


def test_a_coating_too_thin_for_its_cells_is_named():
    """It is the coating's layer that is too thin, and no mesh.first_layer helps: the thickness that is named does."""
    text = SCENE.format(modulus="linear", more="E_substrate = 70e9", thickness=1e-8)
    with pytest.raises(SceneError, match=r"^solid.thickness = .* is too thin .*; (\S+) m or more would do") as refusal:
        solved(text, load__cycles=0, effects__coupling="false")
    would = float(str(refusal.value).split("; ")[1].split(" m ")[0])
    text = text.replace("thickness_over_a0 = 1e-08", f"thickness = {would}")
    solved(text, **MEDIUM, load__cycles=0, effects__coupling="false")
