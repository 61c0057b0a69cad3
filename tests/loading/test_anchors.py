"""Anchors of points that enter contact within a load step: from the states before and after."""

from types import SimpleNamespace

import numpy as np
import pytest
from surfaces import X, touching

from analytic import GradedHalfPlane
from analytic.stuck_edge import StuckEdge
from forms.contact import CLOSED, OPEN
from simulations.loading.anchors import AnchorIteration, EnteringPoints
from simulations.loading.approach import Approach, Ratio
from simulations.loading.contact_points import Surface, edge_by_clearance, edge_of_contact
from simulations.loading.stopped_points import accelerated


def approach(left=0.0, right=0.0, edge=None) -> Approach:
    """With these r at the edges of contact."""
    made = Approach(X, edge)
    made.ratios = {-1: Ratio(left), 1: Ratio(right)}
    return made


def values(found: Approach):
    return found.ratios[-1].value, found.ratios[1].value


def test_open_points_move_by_the_ratio_until_they_touch():
    before = touching(0.5, s=0.1)
    anchors = approach(0.2, -0.3).anchors(before, touching(0.7))
    inside = np.abs(X) <= 0.5
    assert np.array_equal(anchors[inside], before.s[inside])
    assert anchors[X > 0.5] == pytest.approx(0.1 - 0.3 * before.clearance[X > 0.5])
    assert anchors[X < -0.5] == pytest.approx(0.1 + 0.2 * before.clearance[X < -0.5])


@pytest.mark.parametrize("is_uncoupled, near, far", [(False, 0.02, 0.11), (True, 0.19, 0.41)])
def test_the_ratio_is_measured_on_points_that_are_open_still(is_uncoupled, near, far):
    """From so near to so far beyond an edge that comes 0.2 further, without coupling beyond eight points beside it."""
    before, after = touching(0.51), touching(0.71)
    moved = np.where(X > 0, -0.3, 0.2) * (before.clearance - after.clearance)
    beyond = np.abs(X) - 0.725
    moved[(beyond < near) | (beyond > far)] = 7.0  # nothing is learnt from these
    found = Approach(X, None, is_uncoupled)
    found.measure(before, Surface(after.states, before.s + moved, after.clearance))
    assert values(found) == pytest.approx((0.2, -0.3))


@pytest.mark.parametrize("k, nu", [(0.534, -0.19), (0.0, 0.0), (-0.5, 0.2)])
def test_ahead_of_a_stuck_edge_open_points_tell_where_those_passed_touched(k, nu, monkeypatch):
    """Rates are complex powers of the distance from the edge, which comes from 0.5 to 0.7 on the right."""
    halfway = "simulations.loading.approach.edge_by_clearance"
    monkeypatch.setattr(halfway, lambda x, surface, side, power: edge_of_contact(x, surface.states, side))
    edge, start, end = StuckEdge(GradedHalfPlane(E0=1.0, nu=nu, k=k, y0=1.0)), 0.5125, 0.7125  # half way between nodes
    power = (3 - k) / 2 + 1j * edge.oscillation
    ahead, left = np.maximum(X - start, 0.0), np.maximum(X - end, 0.0)
    # of a contact of this width the rates go with ln(distance/(distance + width))
    moved = (0.8 - 0.5j) * (ahead**power - left**power) * (ahead + 2 * start) ** (-1j * edge.oscillation)
    s = np.sqrt(edge.solid.alpha) * moved.imag
    before, after = touching(0.51), touching(0.71, s=s)
    before.clearance[:] = moved.real + left
    after.clearance[:] = left
    found = approach(edge=edge)
    found.measure(before, after)
    anchors = found.anchors(before, after)
    passed = (X > 0.51) & (X < 0.71)
    assert anchors[passed] == pytest.approx(s[passed], rel=1e-9)
    single = approach(*values(found)).anchors(before, after)[passed]
    assert np.any(np.abs(single - s[passed]) > 0.05 * np.abs(s[passed]))


@pytest.mark.parametrize("k, nu", [(0.534, -0.19), (0.0, 0.0), (-0.5, 0.2)])
def test_open_points_beside_a_stuck_edge_go_on_from_the_last_that_it_passed(k, nu, monkeypatch):
    """How far they move until they touch, from before the load step and from after it, on the right and on the left."""
    halfway = "simulations.loading.approach.edge_by_clearance"
    monkeypatch.setattr(halfway, lambda x, surface, side, power: edge_of_contact(x, surface.states, side))
    edge, start, end = StuckEdge(GradedHalfPlane(E0=1.0, nu=nu, k=k, y0=1.0)), 0.5125, 0.7125
    power = (3 - k) / 2 + 1j * edge.oscillation

    def to_touch(distance):
        moved = (0.8 - 0.5j) * np.maximum(distance, 0.0) ** power
        return moved * (np.abs(X) + start) ** (-1j * edge.oscillation)  # the contact's other edge stays

    for side in (-1, 1):
        whole, rest = to_touch(side * X - start), to_touch(side * X - end)
        before, after = touching(start), touching(end)
        before.clearance[:] = np.where(side * X > 0, whole.real, before.clearance)
        after.clearance[:] = np.where(side * X > 0, rest.real, after.clearance)
        inside = np.flatnonzero(side * X < end)[[-1 if side > 0 else 0]]
        beyond = np.flatnonzero(side * X > end)
        scale = side * np.sqrt(edge.solid.alpha)
        r = scale * whole.imag[inside] / whole.real[inside]
        found = approach(edge=edge).beside(r, before, after, side, inside, beyond)
        for ratio, way in zip(found, (whole, rest)):
            assert ratio == pytest.approx(scale * way.imag[beyond] / way.real[beyond], rel=1e-9)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("edge", [0.501, 0.51, 0.524])
def test_an_edge_is_known_within_its_facet(side, edge):
    """Not to a half of the facet 0.025; where the clearance does not grow, and at the end of the points, it is."""
    surface = touching(edge)
    assert edge_by_clearance(X, surface, side, 1.5) == pytest.approx(side * edge, abs=1e-12)
    surface.clearance[np.abs(X) > 0.55] = 0.0
    assert edge_by_clearance(X, surface, side, 1.5) == pytest.approx(side * 0.5125)
    assert edge_by_clearance(X, touching(1.451), side, 1.5) == pytest.approx(side * 1.4625)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("seen, edge", [(0.3, 0.5), (0.55, 0.525)])
def test_an_edge_does_not_leave_its_facet(side, seen, edge):
    surface = Surface(touching(0.5).states, np.zeros(len(X)), np.maximum(np.abs(X) - seen, 0.0) ** 1.5)
    assert edge_by_clearance(X, surface, side, 1.5) == pytest.approx(side * edge)


@pytest.mark.parametrize("measured, value", [(1.99, 3.97), (3.0, 1.6)])
def test_a_secant_step_is_between_three_tenths_of_the_defect_and_three_times_it(measured, value):
    ratio = Ratio()
    ratio.improve(1.0)
    ratio.improve(measured)
    assert ratio.value == pytest.approx(value)


def anchored_beside_the_edges(before, after, rest=0.0) -> np.ndarray:
    """Anchors (n,) at the end of a coupled load step, where those of all points were 0 and r is 1, then ``rest``."""
    put: list[np.ndarray] = []
    entering = SimpleNamespace(
        iteration=SimpleNamespace(before=before, after=after, starts={}),
        _approach=SimpleNamespace(is_uncoupled=False, beside=lambda r, *_: (1.0 + 0.0 * r, rest)),
        _points=SimpleNamespace(gathered=lambda values: values),
        _problem=SimpleNamespace(memory=SimpleNamespace(anchors=lambda: np.zeros(len(X)))),
        _put=put.append,
    )
    EnteringPoints.end(entering)
    return put[0]


@pytest.mark.parametrize("rest", [0.0, 1.0])
def test_with_coupling_the_ratio_fades_out_beyond_the_edge(rest):
    """The eight points beside it are anchored less and less where the ratios have them, and those further out not.

    They have come the whole way to where they would touch, less the rest of it.
    """
    before, after = touching(0.5), touching(0.7)
    after.clearance[:] *= 0.9
    beyond = (after.states == OPEN) & (X > 0)
    share = anchored_beside_the_edges(before, after, rest)[beyond] / (before.clearance - rest * after.clearance)[beyond]
    assert share[:8] == pytest.approx(1 - np.arange(8) / 8) and not np.any(share[8:])


def test_beside_a_flat_that_touches_at_once_open_points_stay():
    """No edge has passed the last point in contact: it has no r, 0/0, by which those further out would go."""
    before, after = touching(0.5), touching(0.5)
    before.states[:] = OPEN
    after.clearance[:] *= 0.9
    assert not np.any(anchored_beside_the_edges(before, after))


def test_points_known_to_stick_that_slide_on_are_anchored_where_they_touch():
    known = np.where(np.abs(X) <= 0.6, 7.0, np.nan)
    before, after, ratios = touching(0.5), touching(0.7, stick=0.55), approach(0.2, 0.2)
    iteration = AnchorIteration(X, before, ratios, dict.fromkeys((-1, 1), np.nan), known.copy())
    anchors = iteration.renewed(after, iteration.touching(), settled=np.inf)
    slides = after.states != CLOSED
    assert np.array_equal(anchors[slides], ratios.anchors(before, after)[slides])
    assert np.all(anchors[np.abs(X) < 0.55] == 7.0)


@pytest.mark.parametrize("r, holds", [(0.2, False), (-0.2, True)])
def test_anchors_of_points_that_slide_count_where_they_would_hold_them(r, holds):
    """All that enter slide. With anchors that let them slide on nothing changes; others are to be tried.

    Those of open points do not count. The state that asks for the least change is kept.
    """
    before, after, ratio = touching(0.5), touching(0.7, stick=0.5), np.where(X > 0, -r, r)
    ahead = after.states == OPEN
    after.s[ahead] = (ratio * (before.clearance - after.clearance))[ahead]
    nowhere = np.full(len(X), np.nan)
    iteration = AnchorIteration(X, before, approach(r, -r), dict.fromkeys((-1, 1), np.nan), nowhere)
    old = np.where(ahead, 9.0, 0.0)
    new = iteration.renewed(after, old, settled=1e-9)
    assert (new is not None) == holds
    if holds:
        assert iteration.unsettled == pytest.approx(1.0) and iteration.is_best
        worse = touching(0.7, stick=0.5, s=after.s)
        iteration.renewed(worse, -new, settled=1e-9)
        assert iteration.unsettled == pytest.approx(2.0) and not iteration.is_best and iteration.after is worse
        iteration.go_back()
        assert iteration.unsettled == pytest.approx(1.0) and iteration.after is after


def test_a_side_that_does_not_grow_keeps_its_ratio():
    found = approach(0.2, -0.3)
    found.measure(touching(0.7), touching(0.5))
    assert values(found) == (0.2, -0.3)


@pytest.mark.parametrize("share", [0.5, 1.4])
def test_what_is_seen_of_a_wrong_ratio_does_not_matter_to_the_secant_method(share):
    ratio = Ratio(0.0)
    for _ in range(3):
        ratio.improve(ratio.value + share * (0.7 - ratio.value))
    assert ratio.value == pytest.approx(0.7)


def test_first_contact_starts_in_the_middle_under_a_power():
    before = Surface(np.full(len(X), OPEN), np.zeros(len(X)), np.abs(X) ** 3)
    anchors = approach(0.5, -0.5).anchors(before, touching(0.7))
    assert anchors == pytest.approx(-0.5 * X * np.abs(X) ** 2, abs=1e-12)


def test_anchors_that_change_by_the_same_share_again_and_again_are_met_at_once():
    """Each solve leaves 0.9 of the distance from ``met``: 65 of them would leave 1e-3."""
    met, start = np.array([1.0, -2.0, 0.5]), np.zeros(3)

    def asked(tried):
        return met + 0.9 * (tried - met)

    second = asked(start)
    assert accelerated(second, asked(second), start, second) == pytest.approx(met, rel=1e-12)


def test_anchors_that_change_more_and_more_are_not_accelerated():
    old, new = np.array([1.0, 1.0]), np.array([3.0, 2.0])
    assert accelerated(old, new, np.zeros(2), np.ones(2)) is new
