"""Conditions of contact and friction that the edges of a coupled state do not ensure, on states made up for each."""

from types import SimpleNamespace

import numpy as np
import pytest

from analytic import ContactNotConverged
from analytic.coupled.conditions import check

MU = 0.3


def made_up(p=lambda x: 1 - x**2, share=1.0, moved=-1e-3, stick=0.5):
    """Contact on |x| < 1 that sticks on |x| < stick, q a share of mu p, beyond stick moved along x at its edges."""
    return SimpleNamespace(
        contact=(-1.0, 1.0),
        stick=(-stick, stick),
        breaks=np.array([-stick, stick]),
        problem=SimpleNamespace(mu=MU),
        tractions=lambda x: np.stack([p(x), share * MU * p(x)]),
        displacements=lambda x: np.stack([moved * np.maximum(np.abs(x) - stick, 0), 0 * x]),
    )


AT_TURN = made_up(moved=0.0)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_state_that_fulfils_them(direction):
    """Points slip against Q, however little of it backwards."""
    check(made_up(moved=-direction * 1e-3), AT_TURN, AT_TURN, direction)
    check(made_up(moved=direction * 1e-9), AT_TURN, AT_TURN, direction)
    check(made_up(p=lambda x: 1 - x**2 - 1e-6, moved=-direction * 1e-3), AT_TURN, AT_TURN, direction)


@pytest.mark.parametrize(
    "state, reason",
    [
        (made_up(p=lambda x: 0.9 - x**2), r"the pressure is negative, its integral 5\.\de-03 P"),
        (made_up(share=1.001), "q exceeds its limit where it sticks, by 4.0e-04 P in all"),
        (made_up(moved=1e-3), r"a point slips backwards, by 5\.0e-04"),
        (made_up(stick=1.1), "points come into contact in stick"),
    ],
)
def test_what_is_broken_is_named(state, reason):
    with pytest.raises(ContactNotConverged, match=reason):
        check(state, AT_TURN, AT_TURN, 1)
