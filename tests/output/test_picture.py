"""fretting.png: which states it shows, its units and edges, what it says of failing checks and other problems."""

from math import pi
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from pictured import along
from running import COARSE, coarse_arguments
from solving import simulated

from simulations import fretting
from simulations.output import plots
from simulations.output.page_words import quantity
from simulations.output.style import evenly
from simulations.runs.checks import ChecksFailed
from simulations.scene import make_scene
from simulations.scene.solid import modulus_at


@pytest.fixture
def drawn(monkeypatch):
    """Figures in the place of pictures, closed at the end."""
    figures = []
    monkeypatch.setattr(plots, "save", lambda figure, *_: figures.append(figure))
    yield figures
    for figure in figures:
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
def test_the_whole_picture_is_within_its_edges(changes, tmp_path, drawn):
    """And no title lies on a panel's."""
    simulation = simulated(COARSE | changes | {"title": "A long title. " * 12})
    plots.plot_run(tmp_path / "none.png", simulation, {})
    (figure,) = drawn
    figure.draw_without_rendering()
    inside, edges = figure.get_tightbbox(), figure.bbox_inches
    assert inside.xmin >= edges.xmin and inside.xmax <= edges.xmax
    assert inside.ymin >= edges.ymin and inside.ymax <= edges.ymax
    lowest = figure._suptitle.get_window_extent().ymin
    assert all(axis.title.get_window_extent().ymax < lowest for axis in figure.axes)


def test_a_title_is_no_mathematics(tmp_path, drawn):
    """Whatever its signs: what is no mathematics between two of them would end the run."""
    plots.plot_run(tmp_path / "none.png", simulated(COARSE | {"title": r"5 $\frac{1}$ or 6 $"}), {})
    drawn[0].draw_without_rendering()
    assert drawn[0]._suptitle._get_wrapped_text().replace(r"\$", "$").startswith(r"5 $\frac{1}$ or 6 $" + "\n")


def test_checks_that_fail_are_said_in_the_picture(tmp_path, drawn, monkeypatch):
    """On a line of its own below the title, above all panels."""
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


@pytest.mark.parametrize("changes, said", [({}, False), ({"solid__nu": 0.3}, True)], ids=["uncoupled", "coupled"])
def test_a_panel_with_the_line_of_another_problem_alone_says_so(changes, said, tmp_path, drawn):
    """Frictional work and loop have no line of the reference with coupling."""
    fretting.main([*coarse_arguments(tmp_path, **changes), "--quiet"])
    (figure,) = drawn
    assert [("another problem" in axis.get_xlabel()) for axis in figure.axes] == [False] * 3 + [said] * 3
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert ("closed form of another problem (no coupling)" in labels) is said


def test_the_unit_of_length_of_a_coated_contact_is_told(tmp_path, drawn):
    """It is the half-width of a contact on the modulus at that depth, and not on that of the surface."""
    simulation = simulated(COARSE | COATED)
    plots.plot_run(tmp_path / "none.png", simulation, {})
    scene = simulation.scene
    a, E = scene.half_width, modulus_at(scene.material, scene.half_width)
    assert a == pytest.approx((4 * (1 - 0.3**2) * scene.P * 0.1 / (pi * E)) ** 0.5, rel=1e-5)
    assert a > 1.05 * scene.a0(scene.P)
    assert "constant modulus $E(a)$" in drawn[0].legends[0].get_title().get_text()


def test_points_of_a_narrow_peak_and_of_nothing():
    """Nodes that are graded to the middle; the peak's sides are twice as long as the axis below it."""
    x = 1.2 * np.sinh(np.linspace(-5, 5, 4001)) / np.sinh(5)
    peak = np.maximum(1 - np.abs(x - 0.5) / 0.02, 0)
    level, steep = evenly(x, 1.0, 41), evenly(x, 1.0, 41, peak)
    assert np.diff(x[level]) == pytest.approx(0.05, abs=0.005) and np.abs(x[level]).max() < 1
    assert (peak[level] > 0).sum() == 1 and (peak[steep] > 0).sum() == pytest.approx(20, abs=1)
    inside = evenly(x, 1.0, 41, np.where(np.abs(x) < 0.3, 0.0, np.nan))  # as slip has none outside the contact
    assert len(inside) == 41 and np.abs(x[inside]).max() < 0.3
