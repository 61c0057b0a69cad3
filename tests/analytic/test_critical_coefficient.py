"""The critical coefficient of friction of surface elements: its bounds, and what its patterns are."""

import itertools

import numpy as np
import pytest

from analytic import GradedHalfPlane, PowerLawKernel
from analytic.half_plane.critical_friction import (
    RateOperator,
    critical_friction,
    largest_unique,
    sliver_singular,
    smallest_singular,
)

SIGNS = {"+": 1.0, "-": -1.0, "0": 0.0}


def operator(k, nu, elements):
    # the units are not to matter
    return RateOperator.of(PowerLawKernel(GradedHalfPlane(2.1e11, nu, k, 1e-3)), 0.02, elements)


def signs(pattern):
    return np.array([SIGNS[c] for c in pattern])


@pytest.mark.parametrize("elements", [8, 12, 16])
@pytest.mark.parametrize(
    "k, nu, expected", [(0.0, 0.0, 1.763), (0.3, 0.0, 1.966), (0.5, 0.0, 2.38), (0.0, 0.3, 3.086), (0.3, 0.3, 4.05)]
)
def test_upper_bound_does_not_depend_on_the_number_of_elements(k, nu, expected, elements):
    mu, pattern = smallest_singular(operator(k, nu, elements))
    assert mu == pytest.approx(expected, rel=1e-2)  # 0.9 % is the most that 8, 12 and 16 elements differ by
    assert len(pattern) == elements and "0" in pattern


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.5])
def test_search_finds_the_smallest_of_all_patterns_and_the_lower_bound_is_below(k):
    rates = operator(k, 0.0, 7)
    every = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=7)))
    smallest = rates.singular(every).min()
    found = critical_friction(rates)
    assert found.upper == pytest.approx(smallest, rel=1e-9)
    assert 0.3 < found.lower < smallest


@pytest.mark.parametrize(
    "k, elements, pattern",
    [
        (-0.5, 12, "+--------+-0"),
        (-0.5, 16, "+------------+-0"),
        (0.9, 12, "0+----------"),
        (0.0, 12, "+-0+-------+"),  # which no start of the search is
    ],
)
def test_search_finds_slivers_at_the_edges_of_contact(k, elements, pattern):
    """The smallest that descents from hundreds of random patterns find."""
    rates = operator(k, 0.0, elements)
    assert smallest_singular(rates)[0] <= rates.singular(signs(pattern))[0] * (1 + 1e-9)


def test_a_sliver_beside_stick_is_nearly_the_smallest():
    rates = operator(0.0, 0.0, 12)
    mu, pattern = sliver_singular(rates, 10)
    assert mu == pytest.approx(rates.singular(signs(pattern))[0], rel=1e-12)
    assert mu == pytest.approx(smallest_singular(rates)[0], rel=1e-3)


@pytest.mark.parametrize("k, nu", [(-0.5, 0.0), (0.0, 0.0), (0.3, 0.3)])
def test_rates_have_a_second_solution_at_the_upper_bound(k, nu):
    rates = operator(k, nu, 12)
    mu, pattern = smallest_singular(rates)
    s, slips = signs(pattern), signs(pattern) != 0
    values = np.linalg.svd((rates.stiffness - mu * s[:, None] * rates.pressing)[np.ix_(slips, slips)])[1]
    assert values[-1] < 1e-10 * values[0]
    free = np.linalg.svd((rates.stiffness - 0.9 * mu * s[:, None] * rates.pressing)[np.ix_(slips, slips)])[1]
    assert free[-1] > 1e-4 * free[0]


def test_below_the_lower_bound_every_principal_minor_is_positive():
    rates = operator(0.0, 0.0, 7)
    mu = 0.999 * largest_unique(rates)
    for s in itertools.product((-1.0, 1.0), repeat=7):
        matrix = (rates.stiffness - mu * np.array(s)[:, None] * rates.pressing) / rates.stiffness[3, 3]
        for count in (1, 3, 6):
            for chosen in itertools.combinations(range(7), count):
                assert np.linalg.det(matrix[np.ix_(chosen, chosen)]) > 0


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.3])
def test_slip_in_one_direction_is_never_singular(k):
    rates = operator(k, 0.0, 10)
    np.testing.assert_allclose(rates.pressing, -rates.pressing.T, atol=1e-10 * np.abs(rates.pressing).max())
    one_way = np.array(list(itertools.product((0.0, 1.0), repeat=10)))
    assert np.all(np.isinf(rates.singular(np.vstack([one_way, -one_way]))))
    assert np.isinf(rates.singular(signs("-------+-+"))[0])  # nor is it a bound where all slip


@pytest.mark.parametrize(
    "k, pattern", [(0.0, "----++++++++-0+-"), (0.3, "+++++++-0+------"), (0.5, "++++++-0+-------")]
)
def test_patterns_are_singular_only_where_stretches_are_one_element_long(k, pattern):
    assert np.isfinite(operator(k, 0.0, 16).singular(signs(pattern))[0])
    for times in (2, 4):
        assert np.isinf(operator(k, 0.0, 16 * times).singular(np.repeat(signs(pattern), times))[0])


def test_holl_ratio_has_no_critical_coefficient():
    found = critical_friction(operator(0.3, 1 / 2.3, 8))
    assert np.isinf(found.lower) and np.isinf(found.upper) and found.pattern == ""
