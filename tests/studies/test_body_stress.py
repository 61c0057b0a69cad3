"""The panel of the stress in the body reads what a run wrote."""

import shutil

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
from running import coarse_arguments

from simulations import fretting, indentation
from simulations.output.body_pictures import DEPTH, REACH, draw
from simulations.output.body_states import BodyState, read_states
from simulations.scene import SceneError
from simulations.studies import body_stress


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    fretting.main([*coarse_arguments(folder), "--quiet"])
    return folder


def test_states_are_those_of_the_cycle(folder):
    states = read_states(folder)
    letters = [state.label.partition(",")[0] for state in states]
    assert letters == ["pressed", "A", "B", "C", "D", "E", "A"]
    for state in states:
        assert state.von_mises.shape == (len(state.y), len(state.x))
        assert np.all(np.diff(state.x) > 0)
        assert np.all(np.diff(state.y) > 0)


def test_field_is_put_where_it_belongs(folder):
    """Pressing is symmetric; E is A turned round (at the Holl ratio), which a wrong order of cells would not keep."""
    by_label = {state.label: state.von_mises for state in read_states(folder)}
    pressed, right, left = by_label["pressed"], by_label["A, initial"], by_label["E, unloading"]
    scale = pressed.max()
    assert pressed == pytest.approx(pressed[:, ::-1], abs=1e-6 * scale)
    assert left == pytest.approx(right[:, ::-1], abs=1e-3 * scale)
    assert np.abs(right - right[:, ::-1]).max() > 0.1 * scale


def test_a_load_step_of_pressing_has_its_number(folder, tmp_path):
    """Where all states are kept there may be many before the end of the normal stage."""
    copy = shutil.copytree(folder, tmp_path / "copy")
    with h5py.File(min((copy / "fields").glob("0*.h5")), "a") as file:
        file.attrs["state"] = ""
    first = read_states(copy)[0]
    assert first.label == "increment 0, normal"
    figure, axis = plt.subplots()
    draw(axis, first, first.x.max() / 20, first.von_mises.max())
    assert axis.get_title() == "increment 0 (pressing)"
    plt.close(figure)


def test_the_picture_has_no_gap_at_its_edges():
    """The cells are wider there than the margin that once was left."""
    x, y = np.array([-4.0, -1.5, 0.0, 1.5, 4.0]), np.array([0.1, 0.5, 1.5, 3.0])
    figure, axis = plt.subplots()
    draw(axis, BodyState("A", x, y, np.ones((4, 5))), a=1.0, scale=2.0)
    assert axis.dataLim.x0 <= -REACH and axis.dataLim.x1 >= REACH and axis.dataLim.y1 >= DEPTH
    plt.close(figure)


def test_half_a_body_is_drawn_whole(tmp_path):
    """Without friction the files have one half."""
    indentation.main([*coarse_arguments(tmp_path)[2:], "--quiet"])
    (state,) = read_states(tmp_path)
    with h5py.File(next((tmp_path / "fields").glob("0*.h5"))) as file:
        half = file["von_mises"][...]
    assert state.von_mises.size == 2 * half.size and np.all(np.diff(state.x) > 0)
    assert np.array_equal(state.von_mises, state.von_mises[:, ::-1])
    assert np.array_equal(state.von_mises[:, state.x > 0].ravel(), half)


def test_words_are_as_wide_as_one_panel_at_most(tmp_path, monkeypatch):
    """Of a run without friction, whose only panel is narrower than what its title says."""
    indentation.main([*coarse_arguments(tmp_path)[2:], "--quiet", "--set", "indenter.profile=circle"])
    drawn = []
    monkeypatch.setattr(body_stress, "save", lambda figure, *_: drawn.append(figure) or [])
    body_stress.main([str(tmp_path)])
    drawn[0].draw_without_rendering()
    inside, edges = drawn[0].get_tightbbox(), drawn[0].bbox_inches
    assert inside.xmin >= edges.xmin and inside.xmax <= edges.xmax
    assert drawn[0].axes[0].title.get_window_extent().ymax < drawn[0]._suptitle.get_window_extent().ymin
    plt.close(drawn[0])


def test_panel_and_animation(folder, tmp_path):
    body_stress.main([str(folder), "--output", str(tmp_path), "--animate"])
    assert (tmp_path / "body.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "body.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "body.gif").read_bytes().startswith(b"GIF")


def test_the_pictures_of_a_run_go_with_it(tmp_path):
    quick = ["--set", "load.cycles=0", "--set", "solver.increments=1", "--quiet", "--reference", "none"]
    fretting.main([*coarse_arguments(tmp_path), *quick])
    body_stress.main([str(tmp_path), "--animate"])
    assert len(list(tmp_path.glob("body.*"))) == 3
    fretting.main([*coarse_arguments(tmp_path), *quick, "--overwrite"])
    assert not list(tmp_path.glob("body.*"))


def test_a_run_without_its_files_is_refused(folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    fields = next((copy / "fields").glob("0*.h5"))
    whole = fields.read_bytes()
    fields.write_bytes(whole[:1000])
    with pytest.raises(SceneError, match="its files are not those of a run: .*truncated file"):
        body_stress.main([str(copy)])
    fields.write_bytes(whole)
    (copy / "history.csv").unlink()
    with pytest.raises(SceneError, match="history.csv is missing"):
        body_stress.main([str(copy)])
