"""Draw the stress in the body through the cycle of a finished run:  python -m simulations.studies.body_stress DIR."""

import csv
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.ticker import MaxNLocator

from ..command.command import comm, on_root, run, say
from ..output.body_states import BodyState, read_states
from ..output.checkpoint import read_scene
from ..output.files import on_disk
from ..output.folder import refuse_changed
from ..output.page_words import quantity
from ..output.style import in_words, panels, save, style
from ..scene import SceneError
from .commandline import make_folders, study_parser

REACH, DEPTH = 1.6, 1.6  # drawn part of the body, in contact half-widths a
WORDS = {"initial": "first loading", "unloading": "unloading", "reloading": "reloading", "path": "path"}


def main(arguments: list[str]):
    """One panel a recorded state; with --animate a GIF as well."""
    given = on_root(lambda: read(arguments))
    if comm.rank != 0:
        return
    states, a = given.states, given.a
    scale = max(float(state.von_mises[np.ix_(state.y < 3 * a, np.abs(state.x) < 3 * a)].max()) for state in states)
    # a graded surface may carry a spike of stress in one thin layer: let it saturate rather than hide the rest
    scale = min(scale, 1.05 * max(float(inside(state, a).max()) for state in states))
    with style():
        shown = [state for state in states if state.label != "A, reloading"] or states  # A is there already
        columns = min(3, len(shown))
        rows = -(-len(shown) // columns)
        note = "von Mises stress of plane strain, means over cells, from the fields of the run; depth downwards."
        title = f"Stress in the body through the cycle\n{in_words(given.scene)}"
        figure, axes = panels(columns, title, note, rows, width=4.2, height=2.6)
        for axis, state in zip(axes.flat, shown, strict=False):
            filled = draw(axis, state, a, scale)
        for axis in axes.flat[len(shown) :]:
            axis.set_visible(False)
        figure.colorbar(filled, ax=axes.ravel().tolist(), label="von Mises stress [MPa]")
        paths = save(figure, given.output, "body")
        if given.animate:
            paths.append(animate(states, a, scale, given.output / "body.gif"))
    say(f"written to {given.output}: {', '.join(path.name for path in paths)}")


def inside(state: BodyState, a: float):
    """Stress beneath the surface layers, in which a graded body may carry a spike."""
    return state.von_mises[np.ix_((state.y > 0.02 * a) & (state.y < 3 * a), np.abs(state.x) < 3 * a)]


def draw(axis, state: BodyState, a: float, scale: float):
    """Filled contours of one state over x/a and y/a; scale: stress at the end of the colours [Pa]."""
    shown_x, shown_y = np.abs(state.x) < 1.1 * REACH * a, state.y < 1.2 * DEPTH * a
    levels = MaxNLocator(22, steps=[1, 2, 2.5, 5, 10]).tick_values(0, scale / 1e6)
    stress = state.von_mises[np.ix_(shown_y, shown_x)] / 1e6
    filled = axis.contourf(state.x[shown_x] / a, state.y[shown_y] / a, stress, levels, cmap="viridis", extend="max")
    letter, _, branch = state.label.partition(", ")
    axis.set(xlim=(-REACH, REACH), ylim=(DEPTH, 0), aspect="equal")
    axis.set(xlabel=f"position $x/a$ [–]  (1 = {quantity(a, 'm', 3)})", ylabel="depth $y/a$ [–]")
    axis.set_title(f"{letter} ({WORDS[branch]})" if branch else letter)
    axis.grid(False)
    return filled


def animate(states: list[BodyState], a: float, scale: float, path: Path) -> Path:
    """GIF of the states in turn, half a second each."""
    figure, axis = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    figure.colorbar(draw(axis, states[0], a, scale), ax=axis, label="von Mises stress [MPa]")

    def show(i):
        axis.clear()
        draw(axis, states[i], a, scale)

    with on_disk(path) as partial:
        FuncAnimation(figure, show, frames=len(states)).save(partial, writer=PillowWriter(fps=2))
    plt.close(figure)
    return path


def read(arguments: list[str]) -> Namespace:
    """The checked command line with the run's states and half-width; SceneError where it is wrong."""
    parser = study_parser("body_stress", __doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder for the picture (default: that of the run)")
    parser.add_argument("--animate", action="store_true", help="write body.gif, too")
    given = parser.parse_args(arguments)
    given.states = read_states(given.folder)
    if not (given.folder / "history.csv").is_file():
        raise SceneError(f"{given.folder} is not the folder of a run that ended: history.csv is missing")
    with open(given.folder / "history.csv", newline="", encoding="utf-8") as file:
        given.a = half_width(csv.DictReader(file))
    refuse_changed(given.folder)
    given.scene = read_scene(given.folder)
    given.output = given.output or given.folder
    make_folders(given)
    return given


def half_width(rows: Iterable[dict]) -> float:
    """Contact half-width of the widest state [m]; rows: those of history.csv."""
    return float(np.nanmax([float(row["a[m]"]) for row in rows]))


if __name__ == "__main__":
    run(main)
