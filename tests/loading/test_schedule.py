"""The load schedule: load steps that end where they are asked to."""

import pytest

from simulations.fem.load import Load
from simulations.loading.schedule import LoadStep, load_parameter, pressed_first, rocking, visiting


@pytest.mark.parametrize("quarter, states", [(1, "CEA"), (2, "BCDEA"), (3, "BCDEA"), (10, "BCDEA")])
def test_states_of_a_cycle_are_those_of_figure_11(quarter, states):
    """At their loads, or with an odd number of load steps a quarter B and D at the next; one step has neither."""
    wanted = {"B": 0.5, "C": 0.0, "D": -0.5, "E": -1.0, "A": 1.0}
    found = {step.state: step.Q / 0.2 for step in rocking(1.0, 0.2, 1, quarter) if step.state and step.cycle}
    assert "".join(found) == states
    for state, Q in found.items():
        assert Q == pytest.approx(wanted[state], abs=0.2 if quarter == 3 and state in "BD" else 1e-12)


@pytest.mark.parametrize("P", [0.1, 0.3, 0.9])
def test_a_path_meets_its_points_to_the_last_digit(P):
    """Else P would change by round-off where it stays, and edges of contact would be looked for."""
    points = [Load(P, 0.01), Load(P, 0.02), Load(1.0, 0.03)]
    steps = visiting(Load(0.7), points, 3)
    assert [step.load for step in steps[2::3]] == points
    assert all(step.P == P for step in steps[2:6])


def test_a_dwell_to_round_off_ends_no_pressing():
    steps = [LoadStep(Load(P)) for P in (0.5, 1.0, 1.0 - 1e-13, 0.9)]
    assert pressed_first(steps) == 3


def test_a_step_goes_the_way_in_which_q_changes_and_a_dwell_goes_on():
    points = [Load(1.0, 0.3), Load(1.0, 0.1), Load(1.0, 0.1), Load(1.0, -0.2), Load(1.0, -0.1)]
    assert [step.direction for step in visiting(Load(1.0), points, 1)] == [1, -1, -1, -1, 1]


@pytest.mark.parametrize("side", [1, -1])
def test_the_load_parameter_is_the_length_of_the_way_in_the_largest_loads(side):
    """Whichever way Q acts: P to 1, Q to its largest size 0.2, half as far beyond zero, and P to a half."""
    loads = (0.5, 0.0), (1.0, 0.0), (1.0, 0.2), (1.0, -0.1), (0.5, -0.1)
    found = load_parameter([LoadStep(Load(P, side * Q)) for P, Q in loads])
    assert found == pytest.approx([0.5, 1.0, 2.0, 3.5, 4.0])


def test_part_of_the_way_to_a_load_and_loads_that_are_equal():
    """As far as a load of this P is known, however small it is."""
    assert Load(1.0, 0.1).towards(Load(0.5, 0.3, 2e-4), 0.25) == pytest.approx((0.875, 0.15, 5e-5))
    for P in (1.0, 1e-6):
        assert Load(P).is_near(Load(P, 1e-10 * P)) and not Load(P).is_near(Load(P, 1e-8 * P))
