"""The energy that friction takes on a straight way of the loads follows from the balance of energy."""

import numpy as np
import pytest

from analytic import GradedHalfPlane, HalfPlaneContact, PowerProfile
from analytic.straight_way import StraightWay

SOLID, PROFILE = GradedHalfPlane(1.0, 0.2, 0.0, 1.0), PowerProfile(0.5, 2.0)
LOOP = [(1.0, 0.0), (1.0, 0.45), (1.0, -0.45)]  # P, Q
FALLING = [(0.89, 0.0), (0.71, 0.1), (0.27, 0.007), (0.61, 0.13)]


def way_of(*loads) -> StraightWay:
    """Through these loads, with displacements like a square root of the way."""
    way = StraightWay(0.5, True, loads[:1], ((0.0, 0.0, 0.0),))
    for n, load in enumerate(loads[1:], 1):
        way = way.to(load, (0.0, 1.0 - np.sqrt(1.0 - n / len(loads)), 0.0), 0.01, 0.01)
    return way


def energies(points, steps, **options):
    """Work of friction by the solver at each of the ``points``, and by points alone."""
    solver = HalfPlaneContact(SOLID, PROFILE, 0.5, nodes=120, **options)
    shares = np.arange(1, steps + 1)[:, None] / steps
    loads = [points[0], *(tuple(load) for a, b in zip(points, points[1:]) for load in a + shares * np.subtract(b, a))]
    return np.array([state.dissipated_energy for state in solver.run(loads)[::steps]])


@pytest.mark.parametrize("coupling, last", [(True, 2e-4), (False, 1e-2)])
def test_few_load_steps_while_P_changes(monkeypatch, coupling, last):
    """What has left contact counts too. By points the energy is off by 2 to 11 %."""
    few, many = (energies(FALLING, steps, coupling=coupling) for steps in (8, 32))
    assert few[1:-1] == pytest.approx(many[1:-1], rel=2e-4) and few[-1] == pytest.approx(many[-1], rel=last)
    monkeypatch.setattr(StraightWay, "share", 1.0)
    by_points = energies(FALLING, 8, coupling=coupling)
    assert np.all(np.abs(by_points - many)[1:] > 10 * np.abs(few - many)[1:])


def test_constant_pressure_is_left_to_the_points(monkeypatch):
    """Without coupling they are exact."""
    found = energies(LOOP, 8, coupling=False)
    monkeypatch.setattr(StraightWay, "share", 1.0)
    assert np.array_equal(found, energies(LOOP, 8, coupling=False))


def test_a_way_that_is_not_smooth_has_no_balance():
    """What every second load step tells is another energy; few load steps tell nothing."""
    loads = [(1.0, 0.1 * n, 0.0) for n in range(7)]
    smooth = way_of(*loads)
    assert smooth.share != 1.0 and way_of(*loads[:4]).share == 1.0
    jumps = tuple((0.0, float(n % 2), 0.0) for n in range(7))
    assert StraightWay(0.5, True, smooth.loads, jumps, smooth.loss, smooth.of_points).share == 1.0


@pytest.mark.parametrize(
    "coupled, start, end",
    [
        (True, (1.0, 0.1), (1.0, 0.45)),
        (True, (1.0, -0.45), (1.0, 0.45)),  # after a turn
        (True, (1.0, 0.1), (0.9, 0.4)),
        (False, (1.0, 0.1), (0.9, 0.4)),
    ],
)
def test_displacements_end_steeply_where_the_last_point_begins_to_slide(coupled, start, end):
    """At |Q| = mu P, after a turn |ΔQ| = mu (P + P(0)). All like the root of what is left of the way, which has a known
    integral; with a dwell. Where points tell the same to a ten-thousandth they are left alone.
    """
    mu, (dP, dQ), t = 0.5, np.subtract(end, start), np.array([0, 1, 2, 3, 4, 4, 5, 6, 7, 8]) / 8
    last = (mu * start[0] - start[1] if start[1] > 0 else 2 * mu * start[0]) / (dQ - mu * dP)
    root = 1 - np.sqrt(1 - t / last)
    loads = tuple((start[0] + s * dP, start[1] + s * dQ, 1e-3 * s) for s in t)
    conjugates = tuple((0.2 * r, r, 100 * r) for r in root)
    exact = 1 - 2 / 3 * last * (1 - (1 - 1 / last) ** 1.5)
    work = 0.1 + (0.2 * dP * coupled + dQ + 0.1) * (np.trapezoid(root, t) - exact)
    half, same = (StraightWay(mu, coupled, loads, conjugates, 0.1, points) for points in (0.05, work * (1 + 1e-4)))
    assert half.work == pytest.approx(work, rel=1e-11) and same.share == 1.0


@pytest.mark.parametrize("unit", [1.0, 1e6])
def test_which_load_goes_straight_on(unit):
    def load(P, Q, strain=0.0):
        return P * unit, Q * unit, strain

    way = way_of(load(1.0, 0.0), load(0.75, 0.1))
    assert way.goes_on(load(0.5, 0.2)) and way.goes_on(load(0.75, 0.1))
    assert way.towards(load(0.5, 0.2)) is way and way.towards(load(0.9, 0.3)).goes_on(load(0.9, 0.3))
    assert not way.goes_on(load(0.5, 0.2 + 1e-6)) and not way.goes_on(load(0.5, 0.2, 1e-6))
    assert not way.goes_on(load(0.8, 0.08)) and not way.goes_on(load(0.6, 0.2))
    stretched = way_of(load(1.0, 0.0), load(1.0, 0.1, 1e-4))
    assert stretched.goes_on(load(1.0, 0.2, 2e-4)) and not stretched.goes_on(load(1.0, 0.2, 2.01e-4))
    assert not stretched.goes_on(load(1.0, 0.2, 1e-4)) and not stretched.goes_on(load(1.0, 0.1))
