"""Moduli over depth: exact means over layers, and UFL constants in place of their numbers."""

import numpy as np
import pytest
import ufl
from scipy.integrate import quad

from forms.modulus import Coating, PowerLaw, Tabulated, with_parameters

MODULI = [
    PowerLaw.of(0.0, 2.0),
    PowerLaw.of(0.4, 2.0),
    PowerLaw.of(-0.4, 2.0),
    PowerLaw.of(-0.4, 2.0, 0.5),
    Coating(3.0, 1.0, 0.5),
    Coating(3.0, 1.0, 0.5, exponential=True),
    Coating(2.0, 2.0, 0.5, exponential=True),
    Tabulated((0.0, 0.1, 0.5), (3.0, 1.0, 2.0)),
]


@pytest.mark.parametrize("modulus", MODULI[:4], ids=str)
def test_layer_means(modulus):
    """Of power laws: layers that begin on the surface, lie in the graded part, reach beyond it, and lie below."""
    top, bottom = np.array([0.0, 0.1, 0.3, 0.7]), np.array([0.1, 0.3, 0.7, 1.5])
    exact = [quad(modulus.young, *ends, points=[0.5], epsabs=1e-13, epsrel=1e-12)[0] for ends in zip(top, bottom)]
    assert modulus.layer_mean(top, bottom) == pytest.approx(exact / (bottom - top), rel=1e-9)


def test_coatings_between_surface_and_substrate():
    """Halfway the arithmetic mean of both moduli, or the geometric one."""
    y = np.array([0.0, 0.25, 0.5, 2.0])
    assert Coating(4.0, 1.0, 0.5).young(y) == pytest.approx([4.0, 2.5, 1.0, 1.0])
    assert Coating(4.0, 1.0, 0.5, exponential=True).young(y) == pytest.approx([4.0, 2.0, 1.0, 1.0])


def test_a_table_is_linear_between_its_points():
    table = Tabulated((0.0, 0.1, 0.5), (3.0, 1.0, 2.0))
    y = np.linspace(0.0, 0.7, 29)
    ramps = [3.0 - 20.0 * min(at, 0.1) + 2.5 * (min(max(at, 0.1), 0.5) - 0.1) for at in y]
    assert table.young(y) == pytest.approx(ramps, rel=1e-14)
    assert (table.E0, table.thickness, table.kink_depths) == (3.0, 0.5, (0.1, 0.5))


@pytest.mark.parametrize("modulus", MODULI[:3], ids=str)
def test_surface_moduli(modulus):
    """Along the surface the mean of E over the mesh depth of the cell, into the body E/(dy/ds), for k < 0 its mean."""
    depth, h = modulus.depth_map(), 0.2
    along, into = modulus.surface_moduli(h, depth)
    mean = quad(lambda s: modulus.young(depth.y(s)), 0.0, h)[0] / h
    assert along == pytest.approx(mean, rel=1e-7)
    anywhere = modulus.young(depth.y(h / 2)) / depth.stretch(h / 2)
    assert into == pytest.approx(mean if modulus.is_singular else anywhere, rel=1e-7)


@pytest.mark.parametrize("modulus", MODULI, ids=str)
def test_parameters(modulus):
    """Every finite number becomes what is made of it; what decides which terms there are stays."""
    made = with_parameters(modulus, lambda value: -value)
    for name, value in vars(modulus).items():
        replaced = name in modulus.parameters and np.all(np.isfinite(value))
        assert np.array_equal(getattr(made, name), -np.array(value) if replaced else value), name
    assert set(modulus.parameters) == set(vars(modulus)) - {"sign", "exponential"}


@pytest.mark.parametrize("y", [0.2, 1.0])
@pytest.mark.parametrize("modulus", MODULI, ids=str)
def test_plain_numbers_in_ufl_expressions(modulus, y):
    """A finite thickness that is a number, no UFL constant, ends the coating in a form too."""
    assert float(modulus.young(ufl.as_ufl(y))) == pytest.approx(modulus.young(y), rel=1e-14)
