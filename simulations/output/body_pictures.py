"""Pictures of the stress in the body at the recorded states of a run."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from .body_states import BodyState
from .page_words import quantity

REACH, DEPTH = 1.6, 1.6  # drawn part of the body, in contact half-widths a
WORDS = {"normal": "pressing", "initial": "first loading"}  # of branches that have others than their name
STRESS = "von Mises stress [MPa]"


def half_width(rows: list[dict]) -> float:
    """Contact half-width of the widest state [m]; rows: those of history.csv."""
    return float(np.nanmax([float(row["a[m]"]) for row in rows]))


def fill(figure, axes, states: list[BodyState], a: float, scale: float):
    """``draw`` each state on axes of its own, with one bar of colours; axes that are left over are not shown."""
    for axis, state in zip(axes.flat, states, strict=False):
        filled = draw(axis, state, a, scale)
    for axis in axes.flat[len(states) :]:
        axis.set_visible(False)
    figure.colorbar(filled, ax=axes.ravel().tolist(), label=STRESS)


def inside(state: BodyState, a: float):
    """Stress beneath the surface layers, in which a graded body may carry a spike."""
    return state.von_mises[np.ix_((state.y > 0.02 * a) & (state.y < 3 * a), np.abs(state.x) < 3 * a)]


def draw(axis, state: BodyState, a: float, scale: float):
    """Filled contours of one state over x/a and y/a; scale: stress at the end of the colours [Pa]."""
    left, right = np.searchsorted(state.x, (-REACH * a, REACH * a))
    across, down = slice(max(left - 1, 0), right + 1), slice(np.searchsorted(state.y, DEPTH * a) + 1)  # to the edges
    levels = MaxNLocator(22, steps=[1, 2, 2.5, 5, 10]).tick_values(0, scale / 1e6)
    x, y, stress = state.x[across] / a, state.y[down] / a, state.von_mises[down, across] / 1e6
    filled = axis.contourf(x, y, stress, levels, cmap="viridis", extend="max")
    letter, _, branch = state.label.partition(", ")
    axis.set(xlim=(-REACH, REACH), ylim=(DEPTH, 0), aspect="equal")
    axis.set(xlabel=f"position $x/a$ [–]  (1 = {quantity(a, 'm', 3)})", ylabel="depth $y/a$ [–]")
    axis.set_title(f"{letter} ({WORDS.get(branch, branch)})" if branch else letter)
    axis.grid(False)
    return filled
