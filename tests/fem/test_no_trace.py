"""An effect that is off leaves nothing in the compiled forms: their fields and constants, counted and named."""

import numpy as np
import pytest
from solving import coarse_simulation

from simulations.indentation import DEFAULT_SCENE as INDENTATION

FRICTION = {"anchor", "imposed"}


def fields(terms):
    """Names of the fields that the contact terms read, as they are written and as they are compiled."""
    found = terms.forces.coefficients()
    assert terms.forces_form.ufcx_form.num_coefficients == len(found)
    return {field.name for field in found}


def constants(form):
    """Number of the constants that a compiled form reads."""
    return form.ufcx_form.num_constants


def test_friction():
    stepping = coarse_simulation().stepping
    with_friction = stepping.frictional
    without = coarse_simulation(INDENTATION).stepping.normal
    assert FRICTION <= fields(with_friction.terms)
    assert not FRICTION & fields(without.terms) and not FRICTION & fields(stepping.normal.terms)
    assert constants(without.terms.forces_form) < constants(with_friction.terms.forces_form)
    assert len(without.terms.resultant_forms) == 1 and len(with_friction.terms.resultant_forms) == 2


def test_coupling():
    """Uncoupled, the tangential forms hold a pressure instead of computing one."""
    coupled = coarse_simulation().stepping.frictional
    uncoupled = coarse_simulation(effects__coupling="false", solid__nu=0.3).stepping.frictional
    assert "pressure" in fields(uncoupled.terms) and "pressure" not in fields(coupled.terms)
    assert len(uncoupled.terms.resultant_forms) == 1 and len(coupled.terms.resultant_forms) == 2


@pytest.mark.parametrize("k, count", [(0.0, 2), (0.3, 3)])
def test_grading(k, count):
    """nu and E; and k where there is a grading."""
    assert constants(coarse_simulation(solid__k=k, solid__nu=0.3).body.stiffness_form) == count


def test_correction_of_a_singular_modulus():
    def read_by_stiffness(k):
        return coarse_simulation(solid__k=k, solid__nu=0.3).body.stiffness_form.ufcx_form.num_coefficients

    assert read_by_stiffness(0.3) == 0
    assert read_by_stiffness(-0.3) == 1


def test_incompressibility():
    plain, mixed = coarse_simulation(solid__k=0.0, solid__nu=0.3), coarse_simulation(solid__k=0.0, solid__nu=0.5)
    assert plain.body.pi is None and plain.body.unknowns == 2 * plain.body.dofs.shape[0]
    assert mixed.body.pi is not None and mixed.body.unknowns > 2 * mixed.body.dofs.shape[0]


def test_symmetry():
    half = coarse_simulation(INDENTATION)
    whole = coarse_simulation(INDENTATION, effects__symmetry="false")
    assert half.body.unknowns < 0.52 * whole.body.unknowns
    full = coarse_simulation(INDENTATION, solver__method='"full"')
    mirrored, expected, by_full = (next(simulation.run()).surface for simulation in (half, whole, full))
    assert mirrored.x == pytest.approx(expected.x, abs=1e-12)
    assert mirrored.weight == pytest.approx(expected.weight, rel=1e-9)
    assert mirrored.u == pytest.approx(expected.u, abs=1e-9 * np.abs(expected.u).max())
    assert by_full.pressure == pytest.approx(expected.pressure, abs=1e-8 * expected.pressure.max())
