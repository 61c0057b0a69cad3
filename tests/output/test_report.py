"""The page of a run: one file that needs no other, true to the files of the run, in words."""

import json
import shutil
from html.parser import HTMLParser
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import pytest
from pictured import along
from running import coarse_arguments, csv_rows

from simulations import fretting, report
from simulations.output import page_figures
from simulations.output.folder import FILES
from simulations.output.page_figures import DENSITY, surface
from simulations.output.page_words import CHECKS, QUANTITIES, asked, quantity
from simulations.scene import SceneError, make_scene


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


def text_with(folder, changes) -> str:
    """The page of a run whose summary has these changes, without pictures, which take longest."""
    (folder / "summary.json").write_text(json.dumps(summary_of(folder) | changes))
    for name in ("surface.h5", "fretting.png"):
        (folder / name).unlink()
    shutil.rmtree(folder / "fields")
    return Page(report.page(folder)).text


def test_a_check_that_fails_is_said(folder):
    failing = {"gap >= 0": {"value": 0.02, "limit": 1e-3, "cause": "a coarse mesh", "holds": False}}
    text = text_with(folder, {"checks": summary_of(folder)["checks"] | failing, "checks_hold": False})
    assert "checks of the result fail" in text and "2.0e-02 1.0e-03 fails" in text
    assert text.count(f"{CHECKS['gap >= 0']}: a coarse mesh") == 1


def test_a_half_width_that_is_not_known_is_a_dash(folder):
    assert "stick half-width over contact half-width, c/a –" in text_with(folder, {"c_over_a": None})


def test_a_warning_is_said(folder):
    words = "the stick zone < 5 facets"
    assert f"Warning: {words}" in text_with(folder, {"warnings": [words]})


def test_the_density_of_the_energy_is_drawn_where_the_run_has_it(folder):
    rows = csv_rows(folder / "history.csv")
    drawn = surface(folder, rows)
    with h5py.File(folder / "surface.h5", "a") as file:
        assert file[DENSITY].shape == file["x"].shape
        del file[DENSITY]
    assert len(surface(folder, rows)) < 0.97 * len(drawn)  # bytes of the picture


POINTS = [[1e6, 0.0]] + 5 * [[1e6, 1e5], [1e6, -1e5]]


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
    assert text_with(folder, {"title": ""}).startswith("copy ")
    monkeypatch.chdir(folder)
    assert "<h1>copy</h1>" in report.page(Path("."))


def test_page_of_a_run_that_stopped(folder):
    missing = ("a", "errors", "reference", "checks")
    kept = {name: value for name, value in summary_of(folder).items() if name not in missing}
    (folder / "summary.json").write_text(json.dumps(kept))
    text = text_with(folder, {"converged": False, "failure": "no <equilibrium>"})
    assert "no <equilibrium>" in text and "nothing was checked" in text


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


@pytest.mark.parametrize("name", ["history.csv", "summary.json", "surface.h5", "fields/mesh.h5", "a state"])
@pytest.mark.parametrize("left", [0, 0.5])
def test_a_file_that_is_cut_short_is_named(folder, name, left):
    cut = folder / name if name != "a state" else next((folder / "fields").glob("0*.h5"))
    whole = cut.read_bytes()
    cut.write_bytes(whole[: int(left * len(whole))].rstrip(b"\n"))
    with pytest.raises(SceneError) as error:
        report.main([str(folder)])
    assert ": its files are not those of a run: " in str(error.value) and "\n" not in str(error.value)
    assert f"{cut.name}: " in str(error.value)
    assert not (folder / "report.html").exists()


def test_an_index_that_is_no_text_is_no_error_of_the_program(folder):
    """The page does not need it."""
    (folder / "fields.xdmf").write_bytes(b"\xff\xfe")
    report.main([str(folder)])


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
