"""k close to 0, where the far field is nearly a translation of order 1/k; k close to 1, where dy/ds underflows."""

import numpy as np
import pytest
from solving import coarse_simulation, deviations, solved

from simulations.scene import SceneError

UNCOUPLED = {"solid__nu": 0.3, "effects__coupling": "false", "load__cycles": 0}


@pytest.fixture(scope="module")
def homogeneous():
    return solved(**UNCOUPLED, solid__k=0.0)


@pytest.mark.parametrize("k", [1e-12, 1e-9, 1e-7, 1e-6, 1e-5, -1e-7])
def test_close_to_zero_it_is_the_homogeneous_contact(k, homogeneous):
    simulation = solved(**UNCOUPLED, solid__k=k)
    for entry, other in zip(simulation.history.entries, homogeneous.history.entries, strict=True):
        assert entry.tolerance == pytest.approx(1e-9)  # round-off does not raise it
        assert entry.residual < 1e-11
        scale = other.surface.pressure.max()
        assert entry.surface.pressure == pytest.approx(other.surface.pressure, abs=(1e-8 + abs(k)) * scale)
        assert entry.surface.traction == pytest.approx(other.surface.traction, abs=(1e-8 + abs(k)) * scale)


def test_where_the_far_field_is_measured_from_changes_displacements_alone():
    """Below k = 0.01 from the depth of the domain, above from infinity: two conventions, one contact."""
    below, above = (solved(**UNCOUPLED, solid__k=k).history.entries[-1].surface for k in (0.01 - 1e-9, 0.01))
    assert above.pressure == pytest.approx(below.pressure, abs=1e-8 * below.pressure.max())
    assert above.traction == pytest.approx(below.traction, abs=1e-8 * below.pressure.max())
    assert above.relative_displacement == pytest.approx(below.relative_displacement, abs=1e-8)
    assert above.delta[1] > 10 * below.delta[1]


def test_close_to_one_it_still_matches_the_closed_form():
    for name, deviation in deviations(solved(**UNCOUPLED, solid__k=0.98)).items():
        assert abs(deviation) < 2e-3, name


@pytest.mark.parametrize("k", [0.99, 0.999, 1 - 1e-12])
def test_too_close_to_one_is_refused_in_a_line(k):
    reason = r"solid.k = 0.99.* is too close to 1: .*; 0.985 or less is possible"
    with pytest.raises(SceneError, match=reason) as refusal:
        coarse_simulation(**UNCOUPLED, solid__k=k, load__P=1.0)  # so near to 1 a larger contact is refused for its size
    assert "\n" not in str(refusal.value)


def test_what_the_refusal_allows_is_solved():
    (entry, *_) = coarse_simulation(**UNCOUPLED, solid__k=0.985).run()
    assert np.all(np.isfinite(entry.surface.pressure)) and entry.residual < 1e-9
