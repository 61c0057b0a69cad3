"""The page of a run: one file that needs no other, true to the files of the run, in words."""

import json
import shutil
from html.parser import HTMLParser
from math import pi
from pathlib import Path
from types import SimpleNamespace

import h5py
import matplotlib.pyplot as plt
import pytest
from mpi4py import MPI
from running import COARSE, coarse_arguments, csv_rows

from simulations import fretting, report
from simulations.output import page_figures, plots
from simulations.output.folder import FILES
from simulations.output.page_figures import DENSITY, surface
from simulations.output.page_words import CHECKS, QUANTITIES, asked, quantity
from simulations.runs.checks import ChecksFailed
from simulations.runs.simulation import Simulation
from simulations.scene import SceneError, make_scene
from simulations.scene.solid import modulus_at


class Page(HTMLParser):
    """Text and addresses of a page."""

    def __init__(self, text):
        super().__init__()
        self.text, self.sources, self.open = "", [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.sources += [value for name, value in attributes if name in ("src", "href")]
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data + " "


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    fretting.main([*coarse_arguments(folder, title='"A < B & C"'), "--quiet"])
    return folder


@pytest.fixture
def folder(run, tmp_path):
    return shutil.copytree(run, tmp_path / "copy")


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text())


def test_page(folder):
    report.main([str(folder)])
    page, summary = Page((folder / "report.html").read_text()), summary_of(folder)
    assert page.open == [] and "A < B & C" in page.text
    assert len(page.sources) == 4 and all(source.startswith("data:image/png;base64,") for source in page.sources)
    for name in ("a", "peak_pressure", "dissipated_energy", "c_over_a"):
        assert quantity(summary[name], QUANTITIES[name][1]) in page.text, name
        assert f"{summary['errors'][name]:+.1e}" in page.text, name
    for name in ("pressure_l2", "traction_l2", "slip_l2"):
        for deviations in (summary["errors"], summary["errors_worst_state"]):
            assert f"{deviations[name]:.1e}" in page.text, name
        assert name not in page.text, "a key instead of words"
    for name in (*summary["effects"], *summary["versions"], *(CHECKS[name] for name in summary["checks"])):
        assert name in page.text, name
    assert len(summary["checks"]) == page.text.count(" holds ")
    assert f"{quantity(summary['a'], 'm')} {quantity(make_scene().contact.a, 'm')} " in page.text


def without_pictures(folder):
    for name in ("surface.h5", "fretting.png"):
        (folder / name).unlink()
    shutil.rmtree(folder / "fields")


def test_a_check_that_fails_is_said(folder):
    summary = summary_of(folder)
    summary["checks"]["gap >= 0"] = {"value": 0.02, "limit": 1e-3, "cause": "a coarse mesh", "holds": False}
    (folder / "summary.json").write_text(json.dumps(summary | {"checks_hold": False}))
    without_pictures(folder)
    text = Page(report.page(folder)).text
    assert "checks of the result fail" in text and "2.0e-02 1.0e-03 fails" in text
    assert text.count(f"{CHECKS['gap >= 0']}: a coarse mesh") == 1


def test_a_half_width_that_is_not_known_is_a_dash(folder):
    (folder / "summary.json").write_text(json.dumps(summary_of(folder) | {"c_over_a": None}))
    without_pictures(folder)
    assert "stick half-width over contact half-width, c/a –" in Page(report.page(folder)).text


def test_a_warning_is_said(folder):
    summary = summary_of(folder) | {"warnings": ["the stick zone < 5 facets"]}
    (folder / "summary.json").write_text(json.dumps(summary))
    without_pictures(folder)
    assert "Warning: the stick zone < 5 facets" in Page(report.page(folder)).text


def test_the_density_of_the_energy_is_drawn_where_the_run_has_it(folder):
    rows = csv_rows(folder / "history.csv")
    drawn = surface(folder, rows)
    with h5py.File(folder / "surface.h5", "a") as file:
        assert file[DENSITY].shape == file["x"].shape
        del file[DENSITY]
    assert len(surface(folder, rows)) < 0.97 * len(drawn)  # bytes of the picture


POINTS = [[1e6, 0.0]] + 5 * [[1e6, 1e5], [1e6, -1e5]]


def along(folder, points, **changes):
    """Folder of a coarse run along ``points``."""
    scene = make_scene(dict.fromkeys(("load.P", "load.amplitude", "load.cycles")) | {"load.points": points})
    (folder / "path.toml").write_text(scene.to_toml())
    fretting.main([str(folder / "path.toml"), *coarse_arguments(folder / "run", **changes)])
    return folder / "run"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Folder of a run along ten points after the first, which is compared with nothing."""
    return along(tmp_path_factory.mktemp("path"), POINTS, solver__increments=1, reference__kind='"none"')


def test_values_of_a_reference_with_an_error_of_its_own(tmp_path, capsys):
    """As on the screen. The error has the reference's own in it: computed/(1 + error) is another number."""
    folder = along(tmp_path, [[1e6, 0.0], [1e6, 1e5], [5e5, 1e5]], solid__nu=0.3)
    screen, summary, page = capsys.readouterr().out, summary_of(folder), Page(report.page(folder))
    for name, value in summary["reference_values"].items():
        assert f" {value:.8g} " in screen, name
        assert f"{quantity(summary[name], QUANTITIES[name][1])} {quantity(value, QUANTITIES[name][1])} " in page.text
    computed, error = summary["dissipated_energy"], summary["errors"]["dissipated_energy"]
    assert abs(computed / (1 + error) / summary["reference_values"]["dissipated_energy"] - 1) > 1e-4
    for name, value in summary["differences_values"].items():
        assert quantity(value, QUANTITIES[name][1]) in page.text, name


def drawn_surface(folder, monkeypatch):
    """The figure of the surface before it becomes a picture."""
    monkeypatch.setattr(page_figures, "png", lambda figure: figure)
    return surface(folder, csv_rows(folder / "history.csv"))


@pytest.mark.parametrize(
    "of, names, said, energy",
    [
        ("path", ["1", "3", "5", "8", "10"], "5 of 10 states shown", "energy of all load steps w"),
        ("folder", ["A", "B", "C", "D", "E"], "", "energy of the cycle w"),
    ],
)
def test_states_of_the_surface(of, names, said, energy, monkeypatch, request):
    """In the order of the load steps, five at most, the first and the last among them; the figure tells of others."""
    figure = drawn_surface(request.getfixturevalue(of), monkeypatch)
    (legend,) = figure.legends
    assert [text.get_text().split(":")[0] for text in legend.get_texts()] == names
    assert legend.get_title().get_text() == said
    assert any(axis.get_ylabel().startswith(energy) for axis in figure.axes)
    plt.close(figure)


@pytest.mark.parametrize(
    "names, shown, said",
    [
        (["", *map(str, range(1, 12))], ["1", "3", "6", "9", "11"], True),
        (["", "A", "B", "C", "D", "E", "A"], ["A", "B", "C", "D", "E"], False),
        (["", "A"], ["A"], False),
    ],
    ids=["path", "loop", "one"],
)
def test_states_of_the_picture(names, shown, said):
    """Likewise in fretting.png; of a name that comes twice the last state."""
    steps = [SimpleNamespace(state=name, Q=0.1 * i, P=1.0) for i, name in enumerate(names)]
    history = SimpleNamespace(entries=[SimpleNamespace(step=step) for step in steps], friction=True)
    assert [entry.step.state for entry in plots._states(history)] == shown
    figure = plt.figure()
    scene = SimpleNamespace(is_power_law=True)
    plots._legend(figure, SimpleNamespace(history=history, mu=0.5, scene=scene), {})
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts[0].startswith(f"{shown[0]}: $Q = {2 * 0.1 * (len(names) - 1 - names[::-1].index(shown[0])):+.2f}")
    assert ("5 of 11 states shown" in legend.get_title().get_text()) is said
    plt.close(figure)


def test_one_length_and_one_load_in_the_picture(tmp_path, monkeypatch):
    """Along a path with another P: lengths over one a, loads over the largest P, and no state is cut off."""
    seen, legend = [], plots._legend
    monkeypatch.setattr(plots, "_legend", lambda *drawn: seen.append(drawn) or legend(*drawn))
    along(tmp_path, [[1e6, 0.0], [1e6, 1e5], [3e5, -5e4]], reference__kind='"none"')
    ((figure, simulation, _),) = seen
    widest, narrowest = (edge(e.contact[1] for e in simulation.history.entries) for edge in (max, min))
    assert narrowest < 0.7 * widest
    panels = [axis for axis in figure.axes if axis.get_xlabel().startswith("position")]
    length = quantity(make_scene().half_width, "m", 3)
    assert {axis.get_xlabel() for axis in panels} == {f"position x/a [–]  (1 = {length})"}
    assert len(panels) == 4 and all(widest < axis.get_xlim()[1] < 1.4 * widest for axis in panels)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    loads = rf"$1.00\,P$, $Q = {0.1 / 0.3:+.2f}\,\mu P$", rf"$0.30\,P$, $Q = {-0.05 / 0.3:+.2f}\,\mu P$"
    assert texts[:2] == [f"{state}: {load}" for state, load in enumerate(loads, 1)]
    assert "the largest normal load" in figure.legends[0].get_title().get_text()


SMALL = {"load.amplitude": 0.2, "mesh.edge_facet": 0.005}  # its ticks of w are as wide as 0.0175
COATED = dict.fromkeys(("solid.k", "solid.y0_over_a0", "load.mu", "load.amplitude", "load.cycles")) | {
    "solid.modulus": "linear",
    "solid.E_substrate": 7e10,
    "solid.thickness": 1e-3,
    "solid.nu": 0.3,
}


@pytest.mark.parametrize("changes", [SMALL, COATED], ids=["small amplitude", "coated"])
def test_the_whole_picture_is_within_its_edges(changes, tmp_path, monkeypatch):
    """And no title lies on a panel's."""
    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, *_: drawn.append(figure))
    simulation = Simulation(MPI.COMM_SELF, make_scene(COARSE | changes)).run_to_end()
    plots.plot_run(tmp_path / "none.png", "A long title. " * 12, simulation, {})
    (figure,) = drawn
    figure.draw_without_rendering()
    inside, edges = figure.get_tightbbox(), figure.bbox_inches
    assert inside.xmin >= edges.xmin and inside.xmax <= edges.xmax
    assert inside.ymin >= edges.ymin and inside.ymax <= edges.ymax
    lowest = figure._suptitle.get_window_extent().ymin
    assert all(axis.title.get_window_extent().ymax < lowest for axis in figure.axes)
    plt.close(figure)


def test_checks_that_fail_are_said_in_the_picture(tmp_path, monkeypatch):
    """On a line of its own below the title, above all panels."""
    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, *_: drawn.append(figure))
    monkeypatch.setattr("simulations.runs.checks.PENETRATION", -1.0)
    with pytest.raises(ChecksFailed):
        fretting.main([*coarse_arguments(tmp_path), "--quiet"])
    (figure,) = drawn
    figure.draw_without_rendering()
    (line,) = (text for text in figure.texts if text is not figure._suptitle)
    assert line.get_text() == "checks that fail: gap >= 0" and line.get_color() == plots.RED
    red, heading = line.get_window_extent(), figure._suptitle.get_window_extent()
    assert heading.ymin - 1 <= red.ymin and red.height < 0.4 * heading.height
    assert all(axis.title.get_window_extent().ymax < red.ymin for axis in figure.axes)
    plt.close(figure)


@pytest.mark.parametrize("changes, said", [({}, False), ({"solid__nu": 0.3}, True)], ids=["uncoupled", "coupled"])
def test_a_panel_with_the_line_of_another_problem_alone_says_so(changes, said, tmp_path, monkeypatch):
    """Frictional work and loop have no line of the reference with coupling."""
    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, *_: drawn.append(figure))
    fretting.main([*coarse_arguments(tmp_path, **changes), "--quiet"])
    (figure,) = drawn
    assert [("another problem" in axis.get_xlabel()) for axis in figure.axes] == [False] * 3 + [said] * 3
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert ("closed form of another problem (no coupling)" in labels) is said
    plt.close(figure)


def test_page_without_a_reference(path, folder):
    """It promises no lines, says why there is no reference, and what effects that are on mean."""
    text = Page(report.page(path)).text
    assert "There is no reference, because reference.kind = none." in text
    assert "Computed points " in text and "on the lines of what" not in text
    assert "6 of 11 states shown" in text  # of the body: the end of the normal stage too
    assert "load schedule (cycles or a path)" in text.split("off:")[0]
    assert "indenter profile (other than the parabola)" in text.split("off:")[1]
    beside = Page(report.page(folder)).text
    assert "on the lines of what" in beside and "Reference: closed form" in beside and "states shown" not in beside


def test_a_page_without_a_title_has_the_name_of_the_folder(folder, monkeypatch):
    """From within it too, as ``report .``."""
    (folder / "summary.json").write_text(json.dumps(summary_of(folder) | {"title": ""}))
    without_pictures(folder)
    monkeypatch.chdir(folder)
    for path in (folder, Path(".")):
        assert "<h1>copy</h1>" in report.page(path)


def test_page_of_a_run_that_stopped(folder):
    missing = ("a", "errors", "reference", "checks")
    kept = {name: value for name, value in summary_of(folder).items() if name not in missing}
    (folder / "summary.json").write_text(json.dumps(kept | {"converged": False, "failure": "no <equilibrium>"}))
    without_pictures(folder)
    page = Page(report.page(folder))
    assert "no <equilibrium>" in page.text and "nothing was checked" in page.text


@pytest.mark.parametrize("content", ["", "{}", "[]", '{"title": 3}'])
def test_folders_without_a_run_are_refused(tmp_path, content):
    with pytest.raises(SceneError, match="scene.toml is missing"):
        report.main([str(tmp_path)])
    for name in ("scene.toml", "history.csv", "summary.json"):
        (tmp_path / name).write_text(content)
    with pytest.raises(SceneError) as error:
        report.main([str(tmp_path)])
    assert "\n" not in str(error.value) and not (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", [*FILES, "fields/mesh.h5", "a state"])
def test_a_run_that_has_lost_a_file_has_no_page(folder, name):
    """It would look whole."""
    lost = name if name != "a state" else f"fields/{next((folder / 'fields').glob('0*.h5')).name}"
    (folder / lost).unlink()
    with pytest.raises(SceneError, match=f": {lost} is missing$"):
        report.main([str(folder)])
    assert not (folder / "report.html").exists()


def test_a_run_that_stopped_before_a_state_was_kept_has_a_page(folder):
    (folder / "summary.json").write_text(json.dumps(summary_of(folder) | {"converged": False, "failure": "stopped"}))
    for name in ("fretting.png", "fields.xdmf", "fields.vtkhdf"):
        (folder / name).unlink()
    shutil.rmtree(folder / "fields")
    report.main([str(folder)])
    assert "Did not reach its end: stopped" in (folder / "report.html").read_text()


WITHOUT_POWER_LAW = {"k": None, "y0_over_a0": None}


@pytest.mark.parametrize(
    "changes, words",
    [
        ({}, ["210 GPa", "the Holl ratio", "1 MN/m", "Q_A = 0.9 μP = 270 kN/m, then once to −Q_A and back"]),
        ({"load.cycles": 3, "solid.nu": 0.3}, ["ratio 0.3.", "then 3 times"]),
        ({"load.cycles": 0}, ["stays there"]),
        ({"load.bulk_strain": -1e-4}, ["by -0.0001 (compression at +Q_A), with Q."]),
        ({"load.bulk_strain": 2e-4, "load.bulk_phase": 180}, ["by 0.0002 (tension 180° after +Q_A), 180° behind Q."]),
        ({"load.bulk_strain": 2e-4, "load.bulk_phase": -30}, ["by 0.0002 (tension 30° before +Q_A), 30° ahead of Q."]),
        ({"effects.grading": False}, ["a homogeneous half-plane of modulus 210 GPa"]),
        ({"indenter": {"profile": "formula", "formula": "x^2/R", "R": 0.1}}, ["f(x) = x^2/R in metres, R = 100 mm"]),
        ({"indenter.profile": "power", "indenter.exponent": 4.0}, ["A rigid x^4 profile (R = 100 mm)"]),
        (
            {"solid": {"modulus": "linear", "E_substrate": 2e11, "thickness": 1e-3, "nu": 0.3} | WITHOUT_POWER_LAW},
            ["from 210 GPa to 200 GPa (linear), constant below 1 mm"],
        ),
    ],
)
def test_a_scene_in_words(changes, words):
    text = " ".join(asked(make_scene(changes)))
    for expected in words:
        assert expected in text


def test_numbers_with_units():
    assert [quantity(v, "m") for v in (1.04426e-3, 0.0, -2.5e-6, 0.2)] == ["1.0443 mm", "0 m", "−2.5 µm", "200 mm"]
    assert quantity(6.4408e8, "Pa", 4) == "644.1 MPa" and quantity(0.36747, "") == "0.36747"


def test_the_unit_of_length_of_a_coated_contact_is_told(tmp_path, monkeypatch):
    """It is the half-width of a contact on the modulus at that depth, and not on that of the surface."""
    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, *_: drawn.append(figure))
    simulation = Simulation(MPI.COMM_SELF, make_scene(COARSE | COATED)).run_to_end()
    plots.plot_run(tmp_path / "none.png", "", simulation, {})
    scene = simulation.scene
    a, E = scene.half_width, modulus_at(scene.material, scene.half_width)
    assert a == pytest.approx((4 * (1 - 0.3**2) * scene.P * 0.1 / (pi * E)) ** 0.5, rel=1e-5)
    assert a > 1.05 * scene.a0(scene.P)
    assert "constant modulus $E(a)$" in drawn[0].legends[0].get_title().get_text()
