"""Edges of contact and stick from nodal tractions."""

import numpy as np
import pytest

from simulations.fem.surface import SurfaceState, fitted_contact_edges, fitted_stick_edges

MU, C, SPACING = 0.5, 0.5, 0.005


def test_edges_are_read_beyond_nodes_that_carry_their_error_and_bands_of_a_node_or_two():
    """Cattaneo and Mindlin, with wrong nodes beside each edge and one that slides amid the stick zone."""
    x = np.arange(-1.2, 1.2 + SPACING / 2, SPACING)
    roots = [np.sqrt(np.clip(half_width**2 - x**2, 0.0, None)) for half_width in (1.0, C)]
    pressure, missing = roots
    for root, half_width in zip(roots, (1.0, C)):
        last = np.flatnonzero(root)[-1]
        root[last - 4 : last + 1] *= 0.9
        root[: len(x) // 2] = root[: len(x) // 2 : -1]
        assert 0 < half_width - x[last] <= 1.1 * SPACING
    missing[np.searchsorted(x, 0.3)] = 0.0
    traction, unused = MU * (pressure - missing), np.zeros((2, len(x)))
    state = SurfaceState(x, np.full(len(x), SPACING), pressure, traction, unused, np.zeros(2), unused, mu=MU)
    assert fitted_contact_edges(state, (0.5, 0.5)) == pytest.approx((-1.0, 1.0), abs=1e-6)
    assert fitted_stick_edges(state, 1, lambda s: (0.5, 0.5)) == pytest.approx((-C, C), abs=1e-6)
