"""Edges of contact and stick that jump to where the active set would creep."""

from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI
from solving import solved

from forms.contact import BACKWARD, CLOSED, DRIVEN_FORWARD, FORWARD, LIFTED, OPEN, PINNED, X, Y
from simulations import run
from simulations.fem.load import Load
from simulations.solvers.edge_jumps import EdgeJumps
from simulations.solvers.last_steps import LastSteps

POINTS = np.linspace(-1.2, 1.2, 2402)
SPACING = POINTS[1] - POINTS[0]


def jumps(k):
    """For points with a gap of SPACING on a solid of exponent k."""
    body = SimpleNamespace(mesh=SimpleNamespace(comm=MPI.COMM_SELF), modulus=SimpleNamespace(k=k))
    points = SimpleNamespace(x=POINTS, middle=POINTS, body=body)
    found = EdgeJumps(SimpleNamespace(body=body, directions=(X, Y), points=points))
    found.begin(None, None)
    return found


def states(left, inner_left, inner_right, right):
    """Contact from ``left`` to ``right`` that sticks between the inner ones and slides forward beside them."""
    inside = (left < POINTS) & (right > POINTS)
    sticks = (inner_left < POINTS) & (inner_right > POINTS)
    return np.where(sticks, CLOSED, np.where(inside, FORWARD, OPEN)).astype(np.int8)


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.3])
def test_an_edge_goes_on_by_what_theory_leaves_open(k):
    """An edge that was e too far out is seen e (1+k)/2 further in; one too far in is seen e (3-k)/2 further out."""
    found = jumps(k)
    assert found.after(states(-1.0, -0.8, 0.8, 1.0)) is None
    e = 0.04
    imposed = found.after(states(-1.0, -0.8 + e * (1 + k) / 2, 0.8 + e * (3 - k) / 2, 1 - e * (1 + k) / 2))
    left, right = POINTS[(imposed == DRIVEN_FORWARD) & (POINTS < 0)], POINTS[(imposed == DRIVEN_FORWARD) & (POINTS > 0)]
    assert left[-1] == pytest.approx(-0.8 + e, abs=3 * SPACING / (1 + k))
    assert right[0] == pytest.approx(0.8 + e, abs=3 * SPACING)
    assert POINTS[imposed == LIFTED].min() == pytest.approx(1 - e, abs=3 * SPACING / (1 + k))


def test_a_jump_leaves_half_of_the_stick_zone():
    """Edges of stick that go inwards by 0.5 are expected to go by twice that, and would pass each other."""
    found = jumps(0.0)
    found.after(states(-1.0, -0.8, 0.8, 1.0))
    imposed = found.after(states(-1.0, -0.3, 0.3, 1.0))
    assert np.abs(POINTS[imposed == DRIVEN_FORWARD]).min() == pytest.approx(0.15, abs=3 * SPACING)


def test_nothing_is_made_to_slide_where_nothing_slides():
    found = jumps(0.0)
    found.after(states(-1.0, -0.8, 0.8, 1.0))
    assert found.after(states(-1.0, -1.0, 1.0, 1.0)) is None


def test_a_load_far_ahead_of_the_last_two_is_not_on_their_line():
    steps = LastSteps()
    for P in (1.0, 1.1):
        steps.keep(Load(P), np.zeros(1))
    assert steps.ahead(Load(1.35)) == pytest.approx(2.5) and steps.ahead(Load(1.6)) == 0.0
    assert steps.stays(Load(1.1)) and not steps.stays(Load(1.1, 1e-6))  # a short step is no dwell


def test_edges_that_rest_impose_nothing():
    found = jumps(0.0)
    assert [found.after(states(-1.0, -0.5, 0.6, 0.9)) for _ in range(3)] == [None] * 3


def test_a_point_that_turns_round_sticks_in_between():
    found = jumps(0.0)
    before = states(-1.0, -0.5, 0.6, 0.9)
    found.begin(None, before)
    assert np.array_equal(found.after(np.roll(before, 100)) == DRIVEN_FORWARD, before == FORWARD)  # as it was at first
    found.after(before)
    turned = np.isclose(POINTS, -0.7, atol=SPACING)
    imposed = found.after(np.where(turned, BACKWARD, before))
    assert np.array_equal(imposed == PINNED, turned) and not np.any(imposed[~turned])
    assert found.after(np.where(turned, BACKWARD, before)) is None  # it may slide back now


def test_points_that_slide_against_their_zone_belong_to_stick():
    """Beside an edge of stick too far in: one node slides on, those beyond it turn round or stick again."""
    found, e = jumps(0.0), 0.05
    found.after(states(-1.0, -0.5, 0.6 - e, 0.9))
    again = states(-1.0, -0.5, 0.6, 0.9)
    against = np.isclose(POINTS, 0.6 - e, atol=SPACING)
    imposed = found.after(np.where(against, BACKWARD, again))
    assert np.all(imposed[against] == PINNED)
    assert POINTS[imposed == DRIVEN_FORWARD].min() == pytest.approx(0.6 - e / 3, abs=3 * SPACING)  # e 2/3 further out


def ends(Q):
    """Edges of contact and stick, left to right, that move smoothly with Q."""
    return np.array([-1 + 0.1 * Q**2, -0.9 + 0.4 * Q + 0.2 * Q**2, 0.9 - 0.3 * Q - 0.3 * Q**2, 1 + 0.1 * Q])


def test_edges_are_expected_on_the_parabola_through_the_last_three():
    found = jumps(0.0)
    for Q in (0.2, 0.3, 0.5):
        found.accept(Load(1.0, Q), states(*ends(Q)), turned=False)
    found.begin(Load(1.0, 0.6), None)
    imposed = found.after(states(*ends(0.55)))
    left, inner_left, inner_right, _ = ends(0.6)
    driven = POINTS[imposed == DRIVEN_FORWARD]
    assert driven[driven < 0].max() == pytest.approx(inner_left, abs=4 * SPACING)
    assert driven[driven > 0].min() == pytest.approx(inner_right, abs=4 * SPACING)
    assert POINTS[imposed == LIFTED].max() == pytest.approx(left, abs=4 * SPACING)


def test_where_the_load_turned_all_of_the_contact_stuck():
    found = jumps(0.0)
    for Q, turned in ((0.1, False), (0.5, False), (0.4, True)):
        found.accept(Load(1.0, Q), states(-1.0, -0.8, 0.8, 1.0), turned)
    found.begin(Load(1.0, 0.3), None)
    imposed = found.after(states(-1.0, -0.8, 0.8, 1.0))
    driven = POINTS[imposed == DRIVEN_FORWARD]
    assert driven[driven < 0].max() == pytest.approx(-0.6, abs=3 * SPACING)  # from -1 by -0.8: as far again
    found.begin(None, None)  # no step that goes on
    assert found.after(states(-1.0, -0.8, 0.8, 1.0)) is None


def test_the_answer_does_not_depend_on_the_jumps(monkeypatch):
    """Nor on where a step starts; with both there are fewer iterations."""
    keys = {"solid__k": 0.0, "solid__nu": 0.3, "solver__increments": 5}
    one = solved(**keys).history
    monkeypatch.setattr(EdgeJumps, "after", lambda *_: None)
    monkeypatch.setattr(LastSteps, "ahead", lambda *_: 0.0)
    other = solved(**keys).history
    for a, b in zip(one.entries, other.entries, strict=True):
        for name in ("pressure", "traction"):
            assert getattr(a.surface, name) == pytest.approx(getattr(b.surface, name), abs=1e-8)
    assert one.dissipated_energy == pytest.approx(other.dissipated_energy, rel=1e-8)
    assert sum(e.iterations for e in one.entries) < 0.9 * sum(e.iterations for e in other.entries)


def test_solves_with_new_anchors_begin_with_the_states_of_the_last_ones(monkeypatch):
    """Far fewer iterations, and the same answer: by the old displacement all points whose anchor moved would slide."""
    changes = {"solid.k": -0.4, "solid.nu": -0.2, "load.mu": 0.4, "load.amplitude": 0.15}
    changes |= {"solver.increments": 2, "mesh.edge_facet": 0.004}
    changes |= {"mesh.facet": 0.1, "mesh.growth": 1.6, "mesh.layer_growth": 1.6}
    one = run(changes).simulation.history
    begin = EdgeJumps.begin
    monkeypatch.setattr(EdgeJumps, "begin", lambda self, load, states: begin(self, load, None))
    other = run(changes).simulation.history
    assert one.dissipated_energy == pytest.approx(other.dissipated_energy, rel=1e-6)
    assert sum(e.iterations for e in one.entries) < 0.6 * sum(e.iterations for e in other.entries)
