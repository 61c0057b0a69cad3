"""Anchors of points that enter contact, or stop sliding, within a load step: from the states before and after."""

from types import SimpleNamespace

import numpy as np
import pytest

from analytic import GradedHalfPlane
from analytic.stuck_edge import StuckEdge
from forms.contact import BACKWARD, CLOSED, FORWARD, OPEN
from simulations.loading.anchors import AnchorIteration, EnteringPoints
from simulations.loading.approach import Approach, Ratio
from simulations.loading.contact_points import Surface, edge_by_clearance, edge_of_contact
from simulations.loading.stopped_points import CUT, StickCurves, accelerated, anchors_of_stopped

X = np.linspace(-1.5, 1.5, 121)


def touching(half_width, s=0.0, stick=None) -> Surface:
    """A contact with a clearance that grows like the 3/2-th power beyond it; sliding outwards beyond ``stick``."""
    states = np.where(np.abs(X) <= half_width, CLOSED, OPEN)
    if stick is not None:
        states[(X > stick) & (states == CLOSED)], states[(X < -stick) & (states == CLOSED)] = BACKWARD, FORWARD
    return Surface(states, np.zeros(len(X)) + s, np.maximum(np.abs(X) - half_width, 0.0) ** 1.5)


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


STOPPED, ISLAND = (np.abs(X) > 0.4) & (np.abs(X) <= 0.6), np.argmin(np.abs(np.abs(X) - 0.5))
LATER = {  # a curve, and what else the surface after the load step has, which does not matter: where, and what
    "points that stop are anchored elsewhere": (X * np.abs(X), "s", STOPPED, 9.0),
    # the curve goes on with the slope that it had: a parabola through three points would not do
    "points behind have slid on": (X**3, "s", np.abs(X) < 0.37, X**3 + 0.1),
    # else what stops would stay where it is, and q would have a spike
    "points stick at the edge of contact": (X * np.abs(X), "states", np.abs(np.abs(X) - 0.9875) < 0.02, CLOSED),
    # because of where it was anchored: left there, it and all further inside would never be anchored
    "a point slides on to the right": (X * np.abs(X), "states", X == X[ISLAND], FORWARD),
    "a point slides on to the left": (X * np.abs(X), "states", X == X[ISLAND], BACKWARD),
}


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("curve, field, where, value", LATER.values(), ids=LATER)
def test_points_that_stop_lie_on_the_curve_that_the_edge_of_stick_has_drawn(curve, field, where, value, side):
    """It is known from where points stuck already, and from the point at the edge."""
    before, after = touching(0.8, s=curve, stick=0.4), touching(1.0, s=curve, stick=0.6)
    getattr(after, field)[where] = np.broadcast_to(value, X.shape)[where]
    points, anchors, start = anchors_of_stopped(X, before, after, side, curve, 0.0)
    assert start == 0.0
    assert np.array_equal(np.sort(points), np.flatnonzero(STOPPED & (side * X > 0)))
    assert anchors == pytest.approx(curve[points], abs=1e-12)


@pytest.mark.parametrize("side", [-1, 1])
def test_a_curve_is_not_continued_to_where_the_edge_of_stick_had_not_begun_to_draw(side):
    """It has drawn for 0.1 only, and goes on for 0.2: further inside points stuck on another curve."""
    curve = np.where(np.abs(X) > 0.29, X**3 - X, 9.0)
    before, after = touching(0.8, s=curve, stick=0.4), touching(1.0, s=curve, stick=0.6)
    points, anchors, start = anchors_of_stopped(X, before, after, side, curve, 0.3 * side)
    assert start == 0.3 * side and np.array_equal(np.sort(points), np.flatnonzero(STOPPED & (side * X > 0)))
    assert anchors == pytest.approx((X**3 - X)[points], abs=1e-12)


def test_a_curve_once_drawn_stays_though_points_stick_up_to_the_edge():
    """What sticks because of it does not drop it: else the solves would go to and fro."""
    curve = X * np.abs(X)
    touch = np.where(STOPPED, 7.0, curve)
    curves = StickCurves(X, touching(0.8, s=curve, stick=0.4), {-1: 0.0, 1: 0.0})
    drawn = curves.draw(touching(1.0, s=curve, stick=0.6), touch)
    assert drawn[STOPPED] == pytest.approx(curve[STOPPED], abs=1e-12)
    assert np.array_equal(curves.draw(touching(1.0, s=curve), touch), drawn)


def test_which_points_stop_is_told_by_the_states_that_are_kept():
    """Where they are anchored by the surface as it is."""
    curve = X * np.abs(X)
    curves = StickCurves(X, touching(0.8, s=curve, stick=0.4), {-1: 0.0, 1: 0.0})
    curves.keep(touching(1.0, stick=0.6).states)
    band = (np.abs(X) > 0.4) & (np.abs(X) <= 0.7)
    drawn = curves.draw(touching(1.0, s=curve, stick=0.7), np.where(band, 7.0, curve))
    assert drawn == pytest.approx(np.where(band & ~STOPPED, 7.0, curve), abs=1e-12)


def test_all_of_a_flat_touches_at_once():
    """No point of it was passed by an edge before another: none stops on a curve."""
    flat = np.maximum(np.abs(X) - 0.5, 0.0) ** 1.5
    before = Surface(np.full(len(X), OPEN), np.zeros(len(X)), flat)
    for side in (-1, 1):
        assert not len(anchors_of_stopped(X, before, touching(0.4, s=X, stick=0.3), side, 0 * X, np.nan).points)


def test_points_that_stop_as_the_load_turns_back_stay():
    """All slid to the right around the stick; now those further out slide to the left."""
    before, after = touching(0.8), touching(0.8, stick=0.6)
    before.states[(np.abs(X) > 0.3) & (np.abs(X) <= 0.8)] = FORWARD
    after.states[after.states == FORWARD] = BACKWARD
    for side in (-1, 1):
        assert len(anchors_of_stopped(X, before, after, side, before.s, np.nan)[0]) == 0


def test_points_that_stop_as_the_load_turns_back_stay_though_the_outermost_slide_on():
    """Those that enter contact just then slide: the edge of stick has gone much further than that of contact."""
    before, after = touching(0.8, stick=0.3), touching(0.85, stick=0.8)
    for side in (-1, 1):
        assert len(anchors_of_stopped(X, before, after, side, before.s, np.nan)[0]) == 0


@pytest.mark.parametrize("stick", [0.3, 0.77])
def test_as_the_load_turns_back_the_edge_of_stick_begins_to_draw_where_that_of_contact_was(stick):
    """A cubic curve through points inside of the facet that the edge had cut, and through those that slide now.

    So it does where a point or two at the old edge slid already.
    """
    curve = X**3 - X
    before, after = touching(0.8, s=curve, stick=stick), touching(1.0, s=curve, stick=0.9)
    after.s[(np.abs(X) > 0.75) & (np.abs(X) <= 0.9)] = 9.0  # where they are anchored now does not matter
    for side in (-1, 1):
        points, anchors, start = anchors_of_stopped(X, before, after, side, curve, np.nan)
        inside = np.sort(side * X[points])[:CUT]
        assert np.all(inside <= 0.8) and np.sort(side * X[points])[CUT] > 0.8
        assert side * start == pytest.approx(inside[0], abs=1.01 * (X[1] - X[0]))
        assert anchors == pytest.approx(curve[points], abs=1e-12)


def test_where_the_edge_of_stick_begins_to_draw_points_go_on_from_where_they_were():
    """Further inside points stuck at zero before friction began: no curve goes through them and the edge."""
    was = np.where(np.abs(X) > 0.41, np.sqrt(np.abs(np.abs(X) - 0.41)), 0.0)
    before, after = touching(0.8, s=was, stick=0.41), touching(1.0, s=was + 0.3, stick=0.61)
    for side in (-1, 1):
        points, anchors, start = anchors_of_stopped(X, before, after, side, was, np.nan)
        inner, outer = side * start, np.abs(X)[np.abs(X) > 0.61].min()
        assert inner == pytest.approx(0.41, abs=X[1] - X[0])
        assert anchors == pytest.approx(was[points] + 0.3 * (np.abs(X[points]) - inner) / (outer - inner))


def test_points_that_stop_between_those_that_slide_out_and_back_lie_on_a_smooth_curve():
    """All slid outwards beyond 0.3; now those up to 0.6 slide back, and those beyond 0.8 slide outwards still.

    Those that the band of stick has passed stopped before they slid back: else some would stick where they were.
    """
    curve = X**3 - X
    before, after = touching(0.75, s=curve, stick=0.3), touching(1.0, s=curve, stick=0.8)
    back = (np.abs(X) > 0.3) & (np.abs(X) < 0.6)
    after.states[back] = np.where(X[back] > 0, FORWARD, BACKWARD)
    stop = (np.abs(X) >= 0.6) & (np.abs(X) <= 0.8)
    after.s[back | stop] = 9.0  # where they have slid to since or are anchored now does not matter
    band = np.abs(X[stop]).min()
    share = np.maximum(1.0 - (band - np.abs(X)) / 0.25, 0.0)  # the edge of contact has come 0.25 far
    passed = back & (share > 1e-9)
    touch = np.where(stop, curve - 0.1, curve)
    for side in (-1, 1):
        points, anchors, start = anchors_of_stopped(X, before, after, side, touch, 0.25 * side)
        assert np.array_equal(np.sort(points), np.flatnonzero((passed | stop) & (side * X > 0)))
        assert anchors == pytest.approx(np.where(stop, curve, touch + 0.1 * share)[points], abs=1e-12)
        assert start == 0.25 * side


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
