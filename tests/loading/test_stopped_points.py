"""Anchors of points that stop sliding within a load step: on the curve that the edge of stick has drawn."""

import numpy as np
import pytest
from surfaces import X, touching

from forms.contact import BACKWARD, CLOSED, FORWARD, OPEN
from simulations.loading.contact_points import Surface
from simulations.loading.stopped_points import CUT, StickCurves, anchors_of_stopped

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
