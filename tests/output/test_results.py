"""The main job as a user runs it, and its files opened again by other readers."""

import json
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from types import SimpleNamespace

import h5py
import meshio
import numpy as np
import pandas
import pytest
from pictured import along
from running import coarse_arguments, csv_rows, run_command, surface
from solving import CYCLING, limit_stepping, without_path

from simulations import fretting
from simulations.loading.stepping import SolveError
from simulations.output.files import write_summary, writing
from simulations.output.results import Results
from simulations.scene import language, parse
from simulations.scene.output import FIELDS


@pytest.fixture(scope="module")
def summary(default_run):
    return json.loads((default_run / "summary.json").read_text())


def test_default_loop_is_as_good_as_published(summary):
    """What README says, with a margin for other versions of the libraries."""
    assert summary["converged"] and summary["ranks"] == 2
    limits = {"pressure_l2": 1.5e-4, "traction_l2": 2e-4, "slip_l2": 5e-5, "a": 2e-5, "c": 1e-4}
    limits |= {"c_over_a": 1e-3, "peak_pressure": 1e-3, "dissipated_energy": 5e-5}
    assert set(summary["errors"]) == set(limits)
    for name, limit in limits.items():
        assert abs(summary["errors"][name]) < limit, name


def test_standard_output_ends_with_the_table(default_run):
    text = (default_run / "stdout.txt").read_text()
    assert "closed form" in text
    for word in ("energy per cycle", "L2 over the contact", "checks hold", "written to"):
        assert text.count(word) == 1, word


def test_scene_is_resolved_and_can_be_run_again(default_run):
    text = (default_run / "scene.toml").read_text()
    assert "# dolfinx 0.9" in text
    scene = parse(text)
    assert set(scene.to_keys()) <= set(language()) and "solid.y0_over_a0" not in scene.to_keys()
    assert parse(scene.to_toml()) == scene
    assert scene.solid.y0 == pytest.approx(10 * scene.a0(scene.P), rel=1e-12)


def test_history(default_run, summary):
    rows = csv_rows(default_run / "history.csv")
    assert len(rows) == summary["increments"]
    assert [row["state"] for row in rows if row["cycle"] == "1" and row["state"]] == ["B", "C", "D", "E", "A"]
    energy = [float(row["dissipated_energy[J/m]"]) for row in rows]
    assert np.all(np.diff(energy) >= 0)
    assert any(int(number) for row in rows for number in row["states_changed"].split())
    start = next(i for i, row in enumerate(rows) if row["cycle"] == "1") - 1
    assert energy[-1] - energy[start] == pytest.approx(summary["dissipated_energy"], rel=1e-9)


def test_surface(default_run, summary):
    data = surface(default_run)
    with h5py.File(default_run / "surface.h5") as file:
        units = {name: file[name].attrs.get("unit") for name in file}
    n, s = data["x"].size, summary["increments"]
    for name in ("pressure", "traction", "slip", "gap", "contact_state", "frictional_work"):
        assert data[name].shape == (s, n), name
    assert units["pressure"] == "Pa" and units["Q_carried"] == "N/m" and units["slip"] == "m"
    assert set(units) - {"branch", "state"} == {name for name, unit in units.items() if unit}
    assert np.all(np.diff(data["x"]) > 0)
    P = data["pressure"] @ data["weight"]
    Q = data["traction"] @ data["weight"]
    assert P == pytest.approx(data["P_carried"], rel=1e-14)
    assert P == pytest.approx(data["P_prescribed"], rel=1e-8)
    assert Q == pytest.approx(data["Q_prescribed"], abs=1e-8 * P.max())
    assert np.sum(data["traction"][-1] * data["slip"][-1] * data["weight"]) < 0  # slip opposes traction


def test_contact_states_go_with_the_tractions(default_run):
    """Separated exactly where there is no pressure, slip where the traction is at its limit; edges where states end."""
    history = pandas.read_csv(default_run / "history.csv")
    data = surface(default_run)
    x, states, pressure, traction, gap = (
        data[name] for name in ("x", "contact_state", "pressure", "traction", "gap")
    )
    separated, stick, slip = (states == value for value in (0, 1, 2))
    assert np.array_equal(separated, pressure <= 0)
    limit = 0.3 * pressure
    assert np.abs(np.abs(traction) - limit)[slip].max() < 2e-6 * limit.max()
    assert np.all((np.abs(traction) < limit)[stick])
    assert np.abs(gap[~separated]).max() < 1e-4 * gap.max() and gap[separated].min() > -1e-4 * gap.max()
    last = history.iloc[-1]
    touching, sticking = x[~separated[-1]], x[stick[-1]]
    facet = 1e-3 * last["a[m]"]  # the smallest, at the edges
    for found, name in ((touching[0], "contact_left"), (touching[-1], "contact_right")):
        assert last[f"{name}[m]"] == pytest.approx(found, abs=facet)
    for found, name in ((sticking[0], "stick_left"), (sticking[-1], "stick_right")):
        assert last[f"{name}[m]"] == pytest.approx(found, abs=facet)
    assert last["peak_pressure[Pa]"] == pytest.approx(pressure[-1].max(), rel=1e-11)


def test_frictional_work_adds_up_to_the_dissipated_energy(default_run, summary):
    """The energy is the sum over the nodes: equal but for round-off, and for the 12 digits of the table."""
    history = pandas.read_csv(default_run / "history.csv")
    data = surface(default_run)
    weight, work, cycle = (data[name] for name in ("weight", "frictional_work", "frictional_work_of_cycle"))
    assert work @ weight == pytest.approx(history["dissipated_energy[J/m]"].to_numpy(), rel=2e-11)
    assert cycle @ weight == pytest.approx(summary["dissipated_energy"], rel=1e-12)
    assert np.diff(work, axis=0).min() > -1e-6 * cycle.max()  # friction gives nothing back


def test_frictional_work_density_is_that_of_the_closed_form(default_run):
    """w = 4 q h_x, (51): its L2 error lies between those of the slip (2e-5 ... 9e-4) and half those of the traction."""
    scene = parse((default_run / "scene.toml").read_text())
    loop = scene.contact.fretting(mu=scene.load.mu, z=1.0 - scene.load.amplitude)
    data = surface(default_run)
    x, weight, found = (data[name] for name in ("x", "weight", "frictional_work_of_cycle"))
    expected = loop.energy_density(x)
    assert weight @ (found - expected) ** 2 < 5e-4**2 * (weight @ expected**2)
    assert found.max() == pytest.approx(expected.max(), rel=2e-4)


def test_displacements_are_in_metres(default_run):
    """The last state is +Q_A: the slip is (36), the indentation (46) and the shift of the indenter (49)."""
    scene = parse((default_run / "scene.toml").read_text())
    loop = scene.contact.fretting(mu=scene.load.mu, z=1.0 - scene.load.amplitude)
    last, data = pandas.read_csv(default_run / "history.csv").iloc[-1], surface(default_run)
    expected = -loop.slip(data["x"], loop.Q_A, "reloading")
    within = np.abs(data["x"]) < loop.a
    assert data["slip"][-1][within] == pytest.approx(expected[within], abs=1e-4 * np.abs(expected).max())
    assert last["delta_y[m]"] == pytest.approx(scene.contact.indentation, rel=2e-4)
    assert last["delta_x[m]"] == pytest.approx(loop.rigid_shift(loop.Q_A, "reloading"), rel=1e-3)


def test_fields_open_in_another_reader(default_run, summary):
    with meshio.xdmf.TimeSeriesReader(default_run / "fields.xdmf") as reader:
        points, cells = reader.read_points_cells()
        states = [reader.read_data(i) for i in range(reader.num_steps)]
    assert [time for time, _, _ in states] == pytest.approx([1, 2, 2.5, 3, 3.5, 4, 6])  # normal stage, A, B, C, D, E, A
    assert cells[0].type == "quad9" and len(cells) == 1
    _, at_points, at_cells = states[1]
    assert set(at_points) | set(at_cells) == set(FIELDS)
    assert points[:, 1].max() == 0.0
    assert points[:, 1].min() == pytest.approx(-20 * 0.00104425, rel=1e-5)  # 20 a, in m
    displacement = at_points["displacement"]
    centre = np.argmin(np.abs(points[:, 0]) - points[:, 1])
    assert displacement[centre, 1] == pytest.approx(-summary["indentation"], rel=2e-3)
    von_mises = at_cells["von_mises"][0]
    assert von_mises.shape == (len(cells[0].data),)
    peak = surface(default_run)["pressure"][-1].max()
    assert 0.2 * peak < von_mises.max() < 2 * peak


@pytest.fixture(scope="module")
def runs_by_ranks(tmp_path_factory):
    folders = {ranks: tmp_path_factory.mktemp(f"ranks{ranks}") for ranks in (1, 3)}
    for ranks, folder in folders.items():
        done = run_command(*coarse_arguments(folder), ranks=ranks)
        assert done.returncode == 0, done.stderr
    return folders


def test_a_path_without_tangential_load_has_a_picture(tmp_path, capsys):
    """It has friction and no state of a loop or a path to name."""
    points = [[1e6, 0.0], [2e6, 0.0], [1e6, 0.0]]
    folder = along(tmp_path, points, solid__nu=0.3, solver__increments=1, reference__kind='"none"')
    said = capsys.readouterr().out
    assert (folder / "fretting.png").stat().st_size > 0
    assert "\nerrors are not known: reference.kind = none\n" in said and "relative" not in said
    assert "stick half-width c/a [-]" in said and "peak pressure [Pa]" in said


def test_same_answer_on_three_ranks(runs_by_ranks):
    """To 1e-7 of the largest value: Newton ends at a force residual of 1e-9 P, which the smallest facets magnify. Two
    ranks are in test_folder.py, the full method in tests/mpi.
    """
    one, other = (surface(runs_by_ranks[ranks]) for ranks in (1, 3))
    for name in ("x", "weight", "pressure", "traction", "slip", "gap", "P_carried", "Q_carried"):
        assert other[name] == pytest.approx(one[name], abs=1e-7 * np.abs(one[name]).max()), name


def test_newton_sees_the_whole_tangent_on_three_ranks(runs_by_ranks):
    """A tangent that misses entries across ranks still converges to the right state, but in more iterations."""
    one, other = (json.loads((runs_by_ranks[n] / "summary.json").read_text())["newton_iterations"] for n in (1, 3))
    assert abs(other - one) <= 3


def test_numbers_that_do_not_exist_are_null(tmp_path):
    """JSON has neither nan nor infinities: other readers would refuse the file."""
    summary = {"a": np.inf, "b": {"c": -float("inf"), "d": np.float64("nan")}, "e": np.int64(1)}
    write_summary(tmp_path / "summary.json", summary)
    found = json.loads((tmp_path / "summary.json").read_text(), parse_constant=pytest.fail)
    assert found == {"a": None, "b": {"c": None, "d": None}, "e": 1}


@pytest.mark.parametrize("rank", [0, 1])
def test_rank_0_alone_writes_tables_and_what_there_is_of_a_run_that_failed(rank):
    """Others would write the same files at the same time."""
    written = []
    results = SimpleNamespace(
        comm=SimpleNamespace(rank=rank),
        simulation=SimpleNamespace(history=SimpleNamespace(entries=[None]), watch=lambda phase: nullcontext()),
        _fields=SimpleNamespace(wants=lambda number: False),
        _checkpoint=None,
        _everywhere=lambda write: None,
        _write_tables=lambda: written.append("tables"),
        _write_failed=written.append,
        _written=-np.inf,
    )
    Results.record(results, None)
    Results.__exit__(results, SolveError, SolveError("no answer\nat all"), None)
    assert written == ([] if rank else ["tables", "no answer"])


def most_iterations(number):
    """Options that leave Newton's method so many, and no path beside them."""
    return "-fretting_snes_max_it", number, "-fretting_path_max_it", 0


def test_cut_increments_give_the_same_answer(runs_by_ranks, tmp_path):
    """Three iterations are too few for some increments: they are halved, and nothing else changes."""
    done = run_command(*coarse_arguments(tmp_path), *most_iterations(3))
    assert done.returncode == 0 and "cuts" in done.stdout
    one, other = (surface(folder)["traction"] for folder in (runs_by_ranks[1], tmp_path))
    assert other[-1] == pytest.approx(one[-1], abs=1e-4 * one.max())


@pytest.mark.parametrize(
    "options, why, where",
    [
        (most_iterations(0), "too many iterations", "1 of 11, normal"),
        ((*most_iterations(1), "-fretting_snes_convergence_test", "skip"), "PETSc ended it", "2 of 11, initial"),
    ],
)
def test_failed_solve_says_why(tmp_path, options, why, where):
    done = run_command(*coarse_arguments(tmp_path), *options, ranks=2)
    assert done.returncode == 3
    lines = [line for line in done.stderr.splitlines() if line.startswith("not converged")]
    assert len(lines) == 1 and why in lines[0]
    assert f" N/m (load step {where}; load.P = 1e+06, load.mu = 0.3, load.amplitude = 0.9)" in lines[0]
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["converged"] is False and why in summary["failure"]
    assert "a" not in summary and "errors" not in summary


def test_failed_solve_keeps_what_it_had(tmp_path, monkeypatch):
    """Without the path Newton does not end in the middle of a strongly coupled loop; the states before are kept."""
    limit_stepping(monkeypatch, halvings=0)
    without_path(monkeypatch)
    with pytest.raises(SolveError, match="too many iterations"):
        fretting.main(coarse_arguments(tmp_path, **CYCLING))
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["converged"] is False and summary["increments"] >= 2
    assert "dissipated_energy" not in summary and "differences" not in summary
    data = surface(tmp_path)
    assert data["pressure"].shape[0] == len(data["load_parameter"]) == summary["increments"]
    assert data["pressure"][-1] @ data["weight"] == pytest.approx(data["P_prescribed"][-1], rel=1e-8)
    with ThreadPoolExecutor(1) as other:  # which can write now
        assert other.submit(writing.acquire, blocking=False).result()
        other.submit(writing.release).result()
