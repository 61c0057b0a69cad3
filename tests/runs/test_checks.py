"""Checks of a finished run: they hold, and each sees what is wrong; energy of every load step."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from running import coarse_arguments, run_command
from solving import coarse_simulation, metered, of_history, solved

from forms.contact import X, Y
from simulations.fem.load import Load
from simulations.fem.surface import SurfaceState, longest_zone
from simulations.loading.schedule import LoadStep
from simulations.output.table import table
from simulations.runs import checks, report_data
from simulations.runs.closed_forms import Springs
from simulations.runs.comparison import _largest, compare_all, compare_state, off, own_of_number
from simulations.runs.energy import EnergyMeter, worst_defect
from simulations.runs.mesh_free import MeshFree


@pytest.fixture(scope="module")
def loop():
    simulation = coarse_simulation(solid__nu=0.3)
    return simulation, metered(simulation)


def test_energy_balances_exactly_in_every_increment(loop):
    assert worst_defect(loop[1]) < 1e-9


def test_energy_balance_sees_a_wrong_displacement():
    simulation = coarse_simulation()
    meter = EnergyMeter(simulation.body)
    for entry in simulation.run():
        entry.surface.u[0] *= 1.001
        meter.read(entry)
    found, turnover = worst_defect(meter.steps), max(step.turnover for step in meter.steps)
    assert found > 1e-4 and worst_defect(meter.steps, 2.0 * turnover) == pytest.approx(found / 2.0)


def test_work_in_a_cycle_tends_to_what_is_dissipated():
    """Both sums over increments have an error that falls like their square."""
    defects = []
    for increments in (4, 8):
        simulation = coarse_simulation(solver__increments=increments)
        steps = metered(simulation)
        cycle = steps[-len(simulation.history.last_cycle) :]
        lost = sum(step.indenter + step.boundary - step.stored for step in cycle)
        defects.append(abs(lost / simulation.history.dissipated_energy - 1))
    assert defects[1] < 0.4 * defects[0] < 0.02


def test_checks_hold_and_see_what_is_wrong(loop):
    simulation, _ = loop
    history, height = simulation.history, simulation.scaled.indenter.height
    assert all(check.holds for check in checks.check(history, height).values())
    surface = history.entries[-1].surface
    saved = surface.pressure.copy(), surface.traction.copy()
    inside = np.flatnonzero(surface.pressure > 0)
    surface.pressure[inside[::2]] *= 1.1
    surface.traction[inside[::2]] *= 1.1
    found = checks.check(history, height)
    surface.pressure[:], surface.traction[:] = saved
    assert {name for name, check in found.items() if not check.holds} >= {
        "load balance",
        "pressure zigzags",
        "traction zigzags",
    }
    surface.traction[inside] *= -1.0
    found = checks.check(history, height)
    pressed = replace(history.entries[-1], step=replace(history.entries[-1].step, branch="normal"))
    while_pressed = checks.check(replace(history, entries=[*history.entries[:-1], pressed]), height)
    surface.traction[:] = saved[1]
    assert not found["slip against q"].holds
    last = len(history.entries)
    assert f"in load step {last}, increment {last - 1} of history.csv:" in checks.describe(found)
    assert "another number of solver.increments" in checks.describe(found)
    assert "another number of solver.normal_increments" in checks.describe(while_pressed)


@pytest.mark.parametrize("name", ["residual", "load balance", "p >= 0", "gap >= 0", "|q| <= mu p"])
def test_each_check_sees_a_little_that_is_wrong_in_one_state(loop, name):
    """Where Q = -Q_A, in the middle of the run: a little beyond its limit, and all others hold."""
    history, height = loop[0].history, loop[0].scaled.indenter.height
    entry = next(entry for entry in history.entries if entry.step.state == "E")
    surface = entry.surface
    beside, slides = np.flatnonzero(surface.pressure > 0)[-1] + 1, np.flatnonzero(surface.slides)[0]
    gap = height(surface.x[beside]) + surface.approach[beside]

    def at(field, where, change):
        values = getattr(surface, field).copy()
        values[where] += change
        return replace(entry, surface=replace(surface, **{field: values}))

    wrong = {
        "residual": replace(entry, residual=2e-6),
        "load balance": at("pressure", slice(None), 1e-7 * surface.pressure),
        "p >= 0": at("pressure", beside, -1e-12),
        "gap >= 0": at("u", (Y, beside), -gap - 2e-3 * height(entry.a)),
        "|q| <= mu p": at("traction", slides, -1e-7 * surface.limit.max()),
    }[name]
    entries = [wrong if other is entry else other for other in history.entries]
    found = checks.check(replace(history, entries=entries), height)
    assert [failing for failing, check in found.items() if not check.holds] == [name]


def test_a_state_under_a_small_load_is_measured_by_that_load():
    """Of P = 0.2 and Q = -0.01 the tractions carry 0.21 and -0.03: they are a tenth of P off, the larger of both."""
    entry = SimpleNamespace(carried=(0.21, -0.03), step=LoadStep(Load(0.2, -0.01)))
    assert checks.imbalance(entry) == pytest.approx(0.1)
    surface = SimpleNamespace(traction=np.array([0.0, -0.26, 0.1]), limit=np.array([0.0, 0.25, 0.5]))
    assert checks.excess(surface) == pytest.approx(0.02)


def test_a_point_slides_where_its_traction_is_at_its_limit_as_far_as_forces_are_known():
    """A millionth of the largest limit, 0.5 here, though the point's own is a thousand times less."""
    pressure, zero = np.array([1.0, 1e-3, 1e-3, 0.0]), np.zeros((2, 4))
    traction = np.array([-0.5, 5e-4 - 4e-7, 5e-4 - 6e-7, 0.0])
    state = SurfaceState(np.arange(4.0), np.ones(4), pressure, traction, zero, np.zeros(2), zero, mu=0.5)
    assert np.array_equal(state.slides, [-1, 1, 0, 0])


def test_energy_balances_where_half_of_the_body_is_meshed():
    """The work of the indenter is that of both halves."""
    text = "solid.E0 = 2e11\nsolid.k = 0.3\nsolid.nu = 0.3\nsolid.y0 = 0.01\nindenter.R = 0.1\n"
    simulation = coarse_simulation(text + "load.points = [[5e5, 0], [1e6, 0]]\n", solver__increments=1)
    steps = metered(simulation)
    assert simulation.body.is_half and worst_defect(steps) < 1e-9
    assert steps[0].indenter > 10 * worst_defect(steps) * steps[0].turnover


def test_a_contact_without_a_width_and_a_negative_energy_fail(loop):
    history, height = loop[0].history, loop[0].scaled.indenter.height
    lost = replace(history.entries[-1], contact=(np.nan, np.nan), dissipated=-1.0)
    found = checks.check(replace(history, entries=[*history.entries[:-1], lost]), height)
    assert [name for name, check in found.items() if not check.holds] == ["contact has a width", "energy >= 0"]
    assert "too few nodes" in checks.describe(found)
    entry = next(entry for entry in history.entries if not entry.step.state)  # on the way a few nodes may do
    entries = [replace(other, contact=(np.nan, np.nan)) if other is entry else other for other in history.entries]
    assert checks.hold(checks.check(replace(history, entries=entries), height))


def test_the_way_of_a_point_that_was_open_is_no_slip(loop):
    """It has moved before it touched, whichever way."""
    before, after = (entry.surface for entry in loop[0].history.entries[-2:])
    slides = np.argmax(np.abs(after.slides * after.traction))
    u, pressure = before.u.copy(), before.pressure.copy()
    u[X, slides] = after.u[X, slides] - after.slides[slides]  # along with q since then
    assert checks.wrong_slip(replace(before, u=u), after) > 10 * checks.WRONG_SLIP
    pressure[slides] = 0.0
    assert checks.wrong_slip(replace(before, u=u, pressure=pressure), after) < checks.WRONG_SLIP


def test_zigzags_are_those_of_nodes_enough_and_over_what_friction_allows():
    """A few nodes are no field, and a small traction has zigzags that are nothing beside the largest one possible."""
    few, many = (np.tile([1.0, 2.0], count // 2) for count in (checks.FEW - 2, checks.FEW))
    assert checks.zigzags(few) == 0.0 and checks.zigzags(many) > 1.0
    surface = SimpleNamespace(traction=1e-3 * many, pressure=np.linspace(0.0, 1.0, checks.FEW), mu=0.5)
    assert checks.traction_zigzags(surface) == pytest.approx(2e-3 * checks.zigzags(many))


@pytest.mark.parametrize("name", ["pressure", "traction", "u"])
def test_a_number_that_is_none_is_seen_in_every_load_step(loop, name):
    """The built-in ``max`` passes over a nan that is not the first."""
    simulation, energies = loop
    history = simulation.history
    values = getattr(history.entries[-2].surface, name)
    saved, steps = values.copy(), [*energies]
    values[..., values.shape[-1] // 2] = np.nan
    steps[-2] = replace(steps[-2], **{"gap" if name == "pressure" else "friction": np.nan})
    try:
        found = checks.check(history, simulation.scaled.indenter.height)
        energy = worst_defect(steps)
    finally:
        values[:] = saved
    failing = {"slip against q"}
    if name != "u":
        failing = {"load balance", f"{name} zigzags", "p >= 0" if name == "pressure" else "|q| <= mu p"}
    assert {check for check in failing if np.isnan(found[check].value)} == failing and np.isnan(energy)


def test_errors_beside_the_reference_are_checked():
    """What a run states may not be large: 20 % too much traction in one state is a check that fails."""
    simulation = solved()
    found = report_data.find(simulation)
    assert checks.hold(found.checks) and found.checks["error of traction"].value == found.exact.worst["traction_l2"]
    traction = simulation.history.last_cycle[3].surface.traction
    traction *= 1.2
    found = report_data.find(simulation)
    assert not found.checks["error of traction"].holds
    assert f"limit 1e-01); {checks.LARGE}" in checks.describe(found.checks)


def test_on_degree_1_errors_are_those_of_the_layers():
    """So the cause that a check of errors tells names them: finer facets alone leave q as it is."""
    edges = {"mesh__edge_facet": 0.01, "mesh__growth": 1.3, "mesh__first_layer": 0.02}
    degree_1 = edges | {"mesh__degree": 1, "mesh__facet": 0.05, "load__amplitude": 0.4, "effects__coupling": "false"}

    def error(**changes):
        simulation = solved(**degree_1 | changes)
        springs = Springs(simulation.contact, simulation.mu, simulation.schedule)
        return compare_all(simulation.history, springs).worst["traction_l2"]

    as_it_is = error(mesh__layer_growth=1.6)
    assert error(mesh__layer_growth=1.6, mesh__facet=0.025) > 0.9 * as_it_is
    assert error(mesh__layer_growth=1.2) < 0.3 * as_it_is
    assert "mesh.layer_growth" in checks.LARGE


def test_what_the_reference_may_have_made_itself_fails_no_check():
    errors = {"pressure_l2": 0.25, "traction_l2": np.nan, "a": -0.07, "dissipated_energy": 0.07}
    found = checks.check_errors(errors, {"pressure_l2": 0.08})
    assert set(found) == {"error of pressure", "error of a", "error of dissipated_energy"}
    assert not found["error of a"].holds and not found["error of dissipated_energy"].holds
    assert found["error of pressure"] == checks.Check(pytest.approx(0.09), 0.1)


def test_slip_is_compared_in_contact_alone(loop):
    history, last = loop[0].history, loop[0].history.entries[-1]
    (left, right), x = last.contact, last.surface.x
    other = replace(last, slip=np.where((x < left) | (x > right), 0.0, last.slip))
    reference = of_history(replace(history, entries=[*history.entries[:-1], other]))
    assert compare_state(last, reference)["slip_l2"] == 0.0


def test_a_peak_that_the_mesh_does_not_show_is_not_compared(loop):
    history, last = loop[0].history, loop[0].history.entries[-1]
    pressure = last.surface.pressure.copy()
    pressure[np.argmin(np.abs(last.surface.x))] *= 2.0
    peaked = replace(last, surface=replace(last.surface, pressure=pressure))
    reference = of_history(replace(history, entries=[*history.entries[:-1], peaked]))
    assert compare_state(last, reference)["pressure_l2"] > 0.01
    reference.without_middle = True
    assert compare_state(last, reference)["pressure_l2"] == 0.0


def test_the_references_own_error_is_that_of_its_worst_state(loop):
    """It is added to the deviation of that state, which is none here."""
    history, state = loop[0].history, loop[0].history.last_cycle[3]
    entries, reference = [*history.entries], of_history(history)
    entries[state.number] = replace(state, surface=replace(state.surface, traction=1.1 * state.surface.traction))
    reference.coarser = of_history(replace(history, entries=entries))
    last, worst, own = compare_all(history, reference)
    assert own["traction_l2"] == worst["traction_l2"] == pytest.approx(0.1) and last["traction_l2"] == 0.0


@pytest.mark.parametrize("computed, error", [(1.1, 0.12), (0.9, -0.12)])
def test_what_the_reference_is_off_by_makes_an_error_larger(computed, error):
    assert off(computed, 1.0, 0.02) == pytest.approx(error)
    assert own_of_number(0.5, 0.4) == pytest.approx(0.2) and own_of_number(0.5, np.nan) == 0.0


def test_round_off_in_the_reference_while_pressing_is_no_traction(loop):
    history, pressed = loop[0].history, loop[0].history.entries[0]
    for share, has in ((1e-10, False), (1e-6, True)):
        surface = replace(pressed.surface, traction=share * pressed.surface.pressure)
        reference = of_history(replace(history, entries=[replace(pressed, surface=surface)]))
        assert ("traction_l2" in compare_state(pressed, reference)) == has


def test_the_table_tells_what_of_the_errors_is_the_references(loop):
    found = report_data.find(loop[0])
    line = r"^of the worst errors its own: pressure (\S+), traction (\S+), slip (\S+)$"
    told = re.search(line, table(found, True), re.M)
    assert told
    for name, size in zip(("pressure", "traction", "slip"), map(float, told.groups()), strict=True):
        assert size == pytest.approx(found.exact.own[f"{name}_l2"], rel=0.06) and size > 0.0


def test_the_stick_half_width_is_judged_over_that_of_contact():
    assert "error of c" not in checks.check_errors({"c": 0.3}, {})
    narrow, wide = (checks.check_errors({"c": 0.3}, {}, stick)["error of c"] for stick in (0.1, 0.5))
    assert narrow.holds and wide == checks.Check(pytest.approx(0.15), 0.05, checks.LARGE)
    excused = checks.check_errors({"c": 0.3}, {"c": 0.08}, 0.5)["error of c"]
    assert excused.value == pytest.approx(0.15 - 2 * 0.04)


def test_a_stick_zone_that_the_run_has_lost_fails_unless_it_is_narrow():
    narrow, wide, unknown = (checks.check_errors({"c": np.nan}, {}, stick) for stick in (0.02, 0.3, np.nan))
    assert narrow["error of c"].holds and wide["error of c"] == checks.Check(0.3, 0.05, checks.LARGE)
    assert not unknown


def test_bands_of_slip_at_the_edges_do_not_widen_the_stick_zone():
    """With little friction points at the edges stick beside a band that slips: c was 0.99 a in the reference. A band of
    one node within the zone is the reference's own.
    """
    scene = {"solid__k": -0.3, "solid__nu": -0.435, "load__mu": 0.0115, "load__amplitude": 0.43}
    simulation = coarse_simulation(**scene, solver__increments=3, effects__coupling="true").run_to_end()
    last = simulation.history.entries[-1]
    reference = MeshFree(simulation, nodes=(80,))
    assert reference.stick_half_width(last) == pytest.approx(last.c, rel=0.03)
    zones = np.array([[-0.99, -0.98], [-0.84, 0.1], [0.115, 0.82]])
    state = SimpleNamespace(stick_zones=zones, contact=(-1.0, 1.0))
    reference.states[last.number] = state
    assert reference.stick_half_width(last) == pytest.approx(0.83)
    state.stick_zones = np.empty((0, 2))
    assert np.isnan(reference.stick_half_width(last))


def test_the_longest_zone_is_that_of_the_longest_way_not_of_most_pieces():
    """Three short pieces close together reach less far than the one on their left, until a wider gap joins all."""
    left, right = np.array([-1.0, 0.3, 0.45, 0.6]), np.array([0.1, 0.4, 0.55, 0.7])
    assert longest_zone(left, right, 0.06) == (0, 0)
    assert longest_zone(left, right, 0.21) == (0, 3)


def test_the_worst_state_is_the_worst_of_those_that_are_known():
    """A state without a slip has none to be off in; where no state has one the worst is not known."""
    states = [{"slip_l2": np.nan, "traction_l2": np.nan}, {"slip_l2": 0.1, "traction_l2": np.nan}]
    found = _largest([*states, {"slip_l2": 0.05, "traction_l2": np.nan}])
    assert found["slip_l2"] == 0.1 and np.isnan(found["traction_l2"])


def test_a_reference_that_is_hardly_known_excuses_little():
    found = checks.check_errors({"traction_l2": 0.71}, {"traction_l2": 0.35})
    assert found["error of traction"].value == pytest.approx(0.51) and not checks.hold(found)
    assert "own error is 35%" in found["error of traction"].cause
    both = checks.check_errors({"pressure_l2": 0.2, "traction_l2": 0.71}, {"traction_l2": 0.35})
    assert both["error of pressure"].cause == checks.LARGE and not both["error of traction"].cause


def test_steady_loop_does_not_drift():
    history = solved(solid__nu=0.3, load__cycles=5, solver__increments=1).history
    assert checks.drift(history) < 1e-9
    history.entries[-1].surface.pressure[:] *= 2.0
    assert checks.drift(history) == pytest.approx(0.5)


def test_ranks_without_contact(tmp_path):
    """A wide domain on four ranks: some hold no contact facet, and the loop is the same."""
    changes = {"mesh__extent": 1000.0, "mesh__facet": 0.2, "mesh__edge_facet": 0.05, "solver__increments": 1}
    energies = []
    for ranks in (1, 4):
        folder = tmp_path / str(ranks)
        done = run_command(*coarse_arguments(folder, **changes), ranks=ranks, timeout=300)
        assert done.returncode == 0, done.stderr
        energies.append(json.loads((folder / "summary.json").read_text())["dissipated_energy"])
    assert energies[1] == pytest.approx(energies[0], rel=1e-7)
