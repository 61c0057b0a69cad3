"""The place of an edge in its facet at which the rule of the surface nodes misses nothing of a root."""

import mpmath
import numpy as np
import pytest

from simulations.fem.edge_place import best_place, missed, vanishing_place, zeta
from simulations.fem.lagrange import LOBATTO


@pytest.mark.parametrize("power", [0.05, 0.5, 0.95])
def test_the_zeta_function(power):
    t = np.array([0.01, 0.3, 1.0])
    assert zeta(power, t) == pytest.approx([float(mpmath.zeta(-power, value)) for value in t], abs=1e-8)


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("k", [-0.5, 0.0, 0.7])
def test_nothing_is_missed_at_the_best_place(degree, k):
    """The rule on 300 facets, of a function that ends like a root at the edge and smoothly at the other end."""
    place, beta, count = best_place(degree, k), (1 + k) / 2, 300
    nodes, weights = LOBATTO[degree]

    def error(t):
        x = (np.arange(count)[:, None] + np.array(nodes)).ravel()
        depth = (count - 1 + t - x) / count
        inside = np.clip(depth, 0.0, None)
        values = inside**beta * np.clip(1 - inside, 0.0, None) ** 10
        exact = float(mpmath.beta(1 + beta, 11))
        return float(np.tile(weights, count) @ values) / count - exact

    scale = count ** -(1 + beta)
    assert abs(error(place)) < 0.01 * scale
    assert error(0.5) == pytest.approx(float(missed(degree, k, 0.5)) * scale, abs=0.01 * scale)
    t, step = np.linspace(0.06, 0.94, 2001), 1e-5
    phi = missed(degree, k, t)
    steepness = np.abs(np.diff(phi)[phi[1:] * phi[:-1] < 0]) / (t[1] - t[0])  # wherever nothing is missed
    here = np.diff(missed(degree, k, place + step * np.array([-1, 1])))[0] / (2 * step)
    assert abs(here) == pytest.approx(steepness.min(), rel=1e-2)


def test_where_traction_ends_nearly_like_a_box_the_place_is_that_measured():
    """docs/accuracy.md, with degree 2: from 0.65 (k = -0.7) to 0.6 (k = -0.9)."""
    assert [best_place(2, k) for k in (-0.9, -0.8, -0.7)] == pytest.approx([0.6, 0.625, 0.65])
    assert best_place(3, -0.8) == vanishing_place(3, -0.8) and best_place(2, -0.67) == vanishing_place(2, -0.67)
