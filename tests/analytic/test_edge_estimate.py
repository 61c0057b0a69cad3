"""The coarse estimate of edges, against the closed forms without coupling and finer nodes with it."""

import numpy as np
import pytest

from analytic import CylinderContact, GradedHalfPlane, HalfPlaneContact, PowerProfile, contact_edges

PROFILE, MU = PowerProfile(0.5, 2.0), 0.3
MIDDLE = 4  # of the states of a cycle with two increments a quarter: that at -Q_A


@pytest.mark.parametrize("k", [-0.5, 0.0, 0.7])
def test_without_coupling(k):
    solid = GradedHalfPlane(1.0, 0.3, k, 1.0)
    exact = CylinderContact(solid, 1.0, 1.0).fretting(MU, 0.9 * MU)
    edges = contact_edges(HalfPlaneContact(solid, PROFILE, MU, coupling=False, nodes=80), 1.0, 0.9 * MU)
    a, c = exact.contact.a, exact.c
    assert edges.contact == pytest.approx((-a, a), rel=7e-3)
    assert edges.contact_range == pytest.approx(np.array([[-a, -a], [a, a]]), rel=7e-3)
    for stick in (edges.stick, edges.stick_states[MIDDLE]):
        assert stick == pytest.approx((-c, c), abs=2e-3 * a)


@pytest.mark.parametrize(("k", "nu", "mu"), [(-0.5, 0.3, 0.6), (0.0, 0.3, 0.3), (0.3, 0.3, 0.3), (0.7, 0.0, 0.6)])
def test_with_coupling(k, nu, mu):
    """The documented accuracy; the contact moves aside with Q, by up to a sixth of its half-width."""
    solid = GradedHalfPlane(1.0, nu, k, 1.0)
    edges = contact_edges(HalfPlaneContact(solid, PROFILE, mu, nodes=80), 1.0, 0.9 * mu)
    fine = contact_edges(HalfPlaneContact(solid, PROFILE, mu, nodes=200), 1.0, 0.9 * mu, steps=4)
    a = (fine.contact[1] - fine.contact[0]) / 2
    assert edges.contact == pytest.approx(fine.contact, abs=7e-3 * a)
    assert edges.contact_range == pytest.approx(fine.contact_range, abs=7e-3 * a)
    assert edges.stick == pytest.approx(fine.stick, abs=2e-3 * a)
    assert edges.stick_states[MIDDLE] == pytest.approx(fine.stick_states[2 * MIDDLE], abs=2e-3 * a)
    assert sum(edges.contact) < -0.02 * a < 0.02 * a < sum(edges.contact_states[MIDDLE])
