"""Draw the stress in the body through the cycle of a finished run:  python -m simulations.studies.body_stress DIR."""

from argparse import Namespace
from math import ceil
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

from ..command.command import comm, on_root, run, say
from ..output.body_pictures import STRESS, draw, fill, half_width, inside
from ..output.body_states import BodyState, read_states
from ..output.checkpoint import read_scene
from ..output.files import on_disk, rows_of
from ..output.folder import refuse_changed
from ..output.style import in_words, panels, save, style
from ..scene import SceneError, shown
from .commandline import make_folders, study_parser


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
        rows = ceil(len(shown) / columns)
        note = "von Mises stress of plane strain, means over cells, from the fields of the run; depth downwards."
        title = f"Stress in the body through the cycle\n{in_words(given.scene)}"
        figure, axes = panels(columns, title, note, rows, width=4.2, height=2.6)
        fill(figure, axes, shown, a, scale)
        paths = save(figure, given.output, "body")
        if given.animate:
            paths.append(animate(states, a, scale, given.output / "body.gif"))
    say(f"written to {given.output}: {', '.join(path.name for path in paths)}")


def animate(states: list[BodyState], a: float, scale: float, path: Path) -> Path:
    """GIF of the states in turn, half a second each."""
    figure, axis = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    figure.colorbar(draw(axis, states[0], a, scale), ax=axis, label=STRESS)

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
    try:
        given.states = read_states(given.folder)
        if not (given.folder / "history.csv").is_file():
            raise SceneError(f"{given.folder} is not the folder of a run that ended: history.csv is missing")
        given.a = half_width(rows_of(given.folder / "history.csv"))
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise SceneError(f"{shown(given.folder)}: its files are not those of a run: {error!r}") from None
    refuse_changed(given.folder)
    given.scene = read_scene(given.folder)
    given.output = given.output or given.folder
    return make_folders(given)


if __name__ == "__main__":
    run(main)
