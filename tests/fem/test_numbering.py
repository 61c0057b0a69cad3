"""Numbers of nodes and cells, the same on any number of ranks."""

import pytest
from dolfinx import fem
from solving import coarse_simulation


@pytest.mark.parametrize("degree", [1, 2])
def test_a_field_of_surface_points_has_a_row_a_column_of_cells(degree):
    numbering = coarse_simulation(mesh__degree=degree).numbering
    whole = numbering.gather_field(fem.Function(numbering.body.point_space))
    assert whole.shape == (len(numbering.vertices[0]) - 1, degree + 1, degree + 1)
