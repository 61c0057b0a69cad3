"""The contact solver where coupling and friction are strong, loads vary together, and sets of nodes would cycle."""

import numpy as np
import pytest

from analytic import GradedHalfPlane, PowerProfile
from analytic.checks import ContactNotConverged
from analytic.half_plane.interpolation import linear
from analytic.half_plane.linear import ContactSets, Data, LinearProblems, _Base
from analytic.half_plane.operator import SurfaceOperator
from analytic.half_plane.solver import PASSES, HalfPlaneContact
from analytic.half_plane.surface_kernel import PowerLawKernel

PROFILE, P = PowerProfile(0.5, 2.0), 1.0


def press():
    return [(load, 0.0) for load in np.linspace(P / 5, P, 5)]


def loop(mu, amplitude=0.9, steps=4):
    """Up to the amplitude and round once."""
    up, down = np.arange(1, steps + 1), np.arange(steps - 1, -steps - 1, -1)
    turns = np.concatenate([up, down, np.arange(1 - steps, steps + 1)])
    return [(P, amplitude * mu * P * t / steps) for t in turns]


def breathing(mu):
    """Two cycles of P and Q together, in phase."""
    return [(P + 0.5 * np.sin(t), 0.45 * mu * P * np.sin(t)) for t in np.linspace(0, 4 * np.pi, 17)[1:]]


def unloading():
    """Pressed, almost released, and pressed again."""
    return press() + [(load, 0.0) for load in (*np.linspace(P, 0.1, 7)[1:], *np.linspace(0.1, P, 5)[1:])]


CASES = {  # each stopped without an answer as long as only active sets were tried, or edges had to come to rest
    "k = -0.9": (-0.9, 0.0, 2.0, False, [(P, 0.0), *loop(2.0)]),
    "k = -0.7, large friction": (-0.7, 0.0, 2.0, False, [(P, 0.0), *loop(2.0)]),
    "k = -0.7 from first contact": (-0.7, 0.0, 0.6, True, press() + loop(0.6)),
    "k = -0.5 from first contact": (-0.5, 0.3, 0.1, True, press() + loop(0.1)),
    "k = -0.5 incompressible": (-0.5, 0.5, 0.1, True, press() + loop(0.1)),
    "k = 0.5 from first contact": (0.5, 0.0, 2.0, True, press() + loop(2.0)),
    "k = 0.9 large amplitude": (0.9, 0.3, 0.3, False, [(P, 0.0), *loop(0.3, 0.999)]),
    "k = 0.9 incompressible": (0.9, 0.5, 2.0, True, press() + loop(2.0)),
    "k = -0.3 breathing": (-0.3, 0.0, 0.3, True, press() + breathing(0.3)),
    "k = 0.9 breathing": (0.9, 0.0, 1.5, True, press() + breathing(1.5)),
    "k = 0 released": (0.0, 0.4, 0.3, True, unloading()),
    "k = -0.7 released": (-0.7, 0.0, 0.3, True, unloading()),
}


@pytest.mark.parametrize("case", CASES)
def test_conditions_hold_to_the_end(case):
    """Every load is answered, and the answer fulfils equilibrium, Signorini's and Coulomb's conditions at each node."""
    k, nu, mu, from_first_contact, loads = CASES[case]
    solver = HalfPlaneContact(
        GradedHalfPlane(1.0, nu, k, 1.0), PROFILE, mu, friction_in_normal_stage=from_first_contact, nodes=100
    )
    states = solver.run(loads)
    assert len(states) == len(loads)
    energy = 0.0
    for state, (load, tangential) in zip(states, loads, strict=True):
        peak = state.pressure.max()
        assert state.weight @ state.pressure == pytest.approx(load, rel=1e-9)
        assert state.pressure.min() >= -1e-9 * peak
        assert state.gap.min() >= -1e-9
        assert np.all(np.abs(state.traction) <= mu * state.pressure + 1e-9 * peak)
        assert state.weight_q @ state.traction == pytest.approx(tangential, abs=1e-9 * mu * load)
        assert state.dissipated_energy >= energy - 1e-6 * mu * P
        energy = state.dissipated_energy


@pytest.mark.parametrize("amplitude", [0.01, 0.5, 0.999])
@pytest.mark.parametrize(("k", "nu"), [(-0.7, 0.0), (0.0, 0.2), (0.9, 0.5)])
def test_any_amplitude(k, nu, amplitude):
    """The second of two loops with coupling dissipates, and nearly as much as with finer nodes (slip: amplitude^2)."""
    energies = []
    for nodes in (120, 240):
        solver = HalfPlaneContact(GradedHalfPlane(1.0, nu, k, 1.0), PROFILE, 0.3, nodes=nodes)
        states = solver.run([(P, 0.0), *loop(0.3, amplitude, 2), *loop(0.3, amplitude, 2)[2:]])
        energies.append(states[-1].dissipated_energy - states[-9].dissipated_energy)
    assert energies[0] > 0
    # at 0.01 the zones of slip are 0.5 % of the contact wide
    assert energies[0] == pytest.approx(energies[1], rel=0.04 if amplitude < 0.1 else 0.02)


def test_path_is_taken_in_halves_if_a_step_fails(monkeypatch):
    """A step that fails is halved, and the states returned are those asked for."""
    steps, advance = [], HalfPlaneContact._advance

    def reluctant(self, memory, load, normal_stage):
        _, Q, _ = load
        if memory.state is not None and abs(Q - memory.state.Q) > 0.1:
            raise ContactNotConverged("a long step")
        steps.append(Q)
        return advance(self, memory, load, normal_stage)

    monkeypatch.setattr(HalfPlaneContact, "_advance", reluctant)
    solver = HalfPlaneContact(GradedHalfPlane(1.0, 0.3, 0.3, 1.0), PROFILE, 0.6, nodes=60)
    states = solver.run([(P, 0.0), (P, 0.3)])
    assert [state.Q for state in states] == [0.0, 0.3]
    assert steps == pytest.approx([0.0, 0.075, 0.15, 0.225, 0.3])
    with pytest.raises(ContactNotConverged, match="a long step"):
        HalfPlaneContact(GradedHalfPlane(1.0, 0.3, 0.3, 1.0), PROFILE, 20.0, nodes=60).run([(P, 0.0), (P, 15.0)])


def test_edges_that_go_round_are_not_followed_for_ever(monkeypatch):
    """A sliver of slip at an edge of stick comes and goes from pass to pass; without notice all passes are made."""
    passes, solved, advance = [], HalfPlaneContact._solved, HalfPlaneContact._advance

    def counted(self, *arguments):
        passes[-1] += 1
        return solved(self, *arguments)

    def begun(self, *arguments):
        passes.append(0)
        return advance(self, *arguments)

    monkeypatch.setattr(HalfPlaneContact, "_solved", counted)
    monkeypatch.setattr(HalfPlaneContact, "_advance", begun)
    solver = HalfPlaneContact(GradedHalfPlane(1.0, -0.309, -0.472, 1.0), PROFILE, 0.256, nodes=200)
    solver.run([(P, 0.0), *loop(0.256, 0.219)])
    assert max(passes) <= PASSES


def test_replaced_equations_are_those_of_the_sets(monkeypatch):
    """Problems in which few nodes change their status: solved from one factor, or each from its own."""
    solid, friction = GradedHalfPlane(1.0, 0.2, 0.3, 1.0), 0.4
    x = np.linspace(-1.2, 1.2, 81)
    operator = SurfaceOperator.on(PowerLawKernel(solid), x, linear(x), linear(x))
    data = [Data(x**2 / 2, np.sin(3 * x) * scale, 1.0, 0.1) for scale in (0.0, 0.1)]
    factors, begin = [], _Base.__init__
    monkeypatch.setattr(_Base, "__init__", lambda self, *all: (factors.append(self), begin(self, *all))[1])
    few = LinearProblems(operator, friction)
    closed, slipping = np.abs(x) < 1.0, np.where(np.abs(x) < 0.5, 0.0, 1.0)
    draw = np.random.default_rng(1)
    for _ in range(12):
        node = draw.integers(len(x))
        closed[node], slipping[node] = draw.random() < 0.8, draw.integers(-1, 2)
        sets = ContactSets(closed.copy(), np.where(closed, slipping, 0.0))
        for found, expected in zip(few.solve(sets, *data), LinearProblems(operator, friction).solve(sets, *data)):
            size = np.abs(expected.pressure).max()
            assert found.pressure == pytest.approx(expected.pressure, abs=1e-11 * size)
            assert found.traction == pytest.approx(expected.traction, abs=1e-11 * size)
            assert (found.delta_x, found.delta_y) == pytest.approx((expected.delta_x, expected.delta_y), rel=1e-11)
            assert not found.pressure[~closed].any() and not found.traction[~closed].any()
    assert len(factors) == 12 + 1
