"""Near and at nu = 1/2: the mixed form, where plain displacements lock."""

import pytest
from solving import deviations, solved

MEDIUM = {
    "mesh__facet": 0.05,
    "mesh__edge_facet": 2e-3,
    "mesh__growth": 1.35,
    "mesh__first_layer": 2e-3,
    "mesh__layer_growth": 1.4,
    "solver__increments": 3,
}
HOMOGENEOUS = {"solid__k": 0.0}
UNCOUPLED = {"effects__coupling": "false", "load__cycles": 0}


@pytest.mark.parametrize("nu", [0.4999, 0.5])
def test_coupled_loop_matches_cattaneo_and_mindlin(nu):
    """At k = 0 the Holl ratio is 1/2: the coupling of nu = 0.4999 is itself below 1e-4."""
    for name, deviation in deviations(solved(**MEDIUM, **HOMOGENEOUS, solid__nu=nu)).items():
        assert abs(deviation) < 1e-3, name


def test_plain_displacements_lock():
    """What the mixed form is there for: the same mesh without it misses the pressure by a tenth."""
    locked = solved(**MEDIUM, **HOMOGENEOUS, solid__nu=0.4999, effects__incompressibility="false", **UNCOUPLED)
    assert deviations(locked)["pressure_l2"] > 0.05


@pytest.mark.parametrize("k", [0.0, 0.3, -0.3])
def test_both_forms_agree_where_both_hold(k):
    scene = {"solid__k": k, "solid__nu": 0.3, "effects__coupling": "false"} | MEDIUM
    found = {
        on: deviations(solved(**scene, effects__incompressibility=on))["pressure_l2"] for on in ("true", "false")
    }
    assert found["true"] == pytest.approx(found["false"], abs=1e-4)
    assert found["true"] < 1.1e-3


@pytest.mark.parametrize("k", [0.3, 0.7, -0.3])
def test_graded_incompressible_half_planes(k):
    found = deviations(solved(**MEDIUM, solid__k=k, solid__nu=0.5, effects__coupling="false"))
    for name, deviation in found.items():
        assert abs(deviation) < 1.5e-3, name
