"""The page of a run: one file that needs no other, true to summary.json."""

import json
from html.parser import HTMLParser

import pytest
from running import coarse_arguments

from simulations import fretting, report
from simulations.scene import SceneError


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
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    fretting.main([*coarse_arguments(folder, title='"A < B & C"'), "--quiet"])
    return folder


def test_page(folder):
    report.main([str(folder)])
    page = Page((folder / "report.html").read_text())
    summary = json.loads((folder / "summary.json").read_text())
    assert page.open == [] and "A < B & C" in page.text
    assert len(page.sources) == 2 and all(source.startswith("data:image/png;base64,") for source in page.sources)
    for value in (summary["a"], summary["dissipated_energy"], summary["errors"]["pressure_l2"]):
        assert f"{value:.6g}" in page.text
    for name in (*summary["effects"], *summary["versions"], "solid", "Newton iterations"):
        assert name in page.text


def test_page_of_a_run_that_stopped(folder):
    summary = json.loads((folder / "summary.json").read_text())
    kept = {name: value for name, value in summary.items() if name not in ("a", "errors", "reference")}
    (folder / "summary.json").write_text(json.dumps(kept | {"converged": False, "failure": "no <equilibrium>"}))
    report.main([str(folder)])
    assert "no <equilibrium>" in Page((folder / "report.html").read_text()).text
    (folder / "summary.json").write_text(json.dumps(summary))


@pytest.mark.parametrize("content", ["", "{}", "[]", '{"title": 3}'])
def test_folders_without_a_run_are_refused(tmp_path, content):
    with pytest.raises(SceneError, match="scene.toml is missing"):
        report.main([str(tmp_path)])
    for name in ("scene.toml", "history.csv", "summary.json"):
        (tmp_path / name).write_text(content)
    with pytest.raises(SceneError) as error:
        report.main([str(tmp_path)])
    assert "\n" not in str(error.value) and not (tmp_path / "report.html").exists()
