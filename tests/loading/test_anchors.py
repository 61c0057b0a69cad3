"""Where points that come to stick within an increment did so, from the contact states before and after."""

import numpy as np
import pytest

from forms.contact import BACKWARD, CLOSED, FORWARD, OPEN
from simulations.loading.anchors import stops

X = np.linspace(-1.05, 1.05, 43)  # spaced by 0.05


def states(stick: float, contact: float) -> np.ndarray:
    """Pressed symmetrically: stick in the middle, sliding outwards around it, open beyond."""
    found = np.full(len(X), CLOSED)
    found[X > stick], found[X < -stick] = BACKWARD, FORWARD
    found[np.abs(X) > contact] = OPEN
    return found


def test_they_lie_on_the_curve_that_the_edge_has_drawn():
    """A quadratic curve is known from where points stuck already, and from the point at the edge."""
    before, after = states(0.5, 0.6), states(0.72, 0.82)
    rest = X * np.abs(X)
    wrong = np.where((before != CLOSED) & (after == CLOSED), rest + 1.0, rest)
    places, positions = stops(X, before, after, wrong)
    assert np.array_equal(places, (before != CLOSED) & (after == CLOSED))
    assert positions[places] == pytest.approx(rest[places], abs=1e-12)
    assert np.array_equal(positions[~places], wrong[~places])


def test_first_contact_starts_in_the_middle():
    places, positions = stops(X, np.full(len(X), OPEN), states(0.32, 0.42), 2.0 * X * np.abs(X))
    assert np.array_equal(places, np.abs(X) <= 0.32)
    assert positions == pytest.approx(2.0 * X * np.abs(X))


def test_points_that_stop_as_the_load_turns_back_stay():
    """All slid to the right around the stick; now those further out slide to the left."""
    before, after = np.full(len(X), FORWARD), np.full(len(X), CLOSED)
    before[np.abs(X) < 0.32] = CLOSED
    after[np.abs(X) > 0.62] = BACKWARD
    assert not np.any(stops(X, before, after, np.sin(X))[0])


def test_points_that_touch_and_stick_are_new_though_their_neighbours_turned_back():
    before, after = np.full(len(X), CLOSED), np.full(len(X), CLOSED)
    before[X > 0.32], before[X > 0.62], after[X > 0.82] = FORWARD, OPEN, OPEN
    places, positions = stops(X, before, after, X)
    assert np.array_equal(places, (X > 0.62) & (X < 0.82))
    assert positions == pytest.approx(X)


def test_nothing_new():
    for pair in ((0.5, 0.6), (0.3, 0.6)):
        assert not np.any(stops(X, states(0.5, 0.6), states(*pair), X)[0])
