"""One picture of a run: pressure, traction and the friction loop, computed points on closed-form lines."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..runs.history import Entry, History
from ..runs.reference import Reference
from ..runs.simulation import Simulation
from ..runs.springs import Springs
from .files import on_disk
from .style import COLOURS

STYLES = ("-", "--")
DOTS = 45  # computed points shown a curve
MOST_STATES = 5


def plot_run(path: Path, title: str, simulation: Simulation, lines: dict[str, Reference]):
    """PNG of the last state's pressure and, with friction, the named states of the last cycle and the loop.

    lines: what the computed points are laid on, by label.
    """
    history = simulation.history
    panels = 3 if history.friction else 1
    with plt.rc_context({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3, "legend.fontsize": 9}):
        figure, axes = plt.subplots(1, panels, figsize=(4.7 * panels, 4.6), layout="constrained", squeeze=False)
        figure.suptitle(title, wrap=True, parse_math=False)
        _pressure(axes[0, 0], history.entries[-1], lines)
        if history.friction:
            _traction(axes[0, 1], history, simulation.mu, lines)
            _loop(axes[0, 2], simulation, lines)
        try:
            with on_disk(path) as partial:
                figure.savefig(partial, dpi=160)
        finally:
            plt.close(figure)


def _states(history: History) -> list[Entry]:
    """The last states by name, in the order in which they come."""
    named = {e.increment.state: e for e in history.entries if e.increment.state}
    return sorted(named.values(), key=lambda entry: entry.increment.state)[:MOST_STATES]


def _pressure(axis, entry, lines):
    x = np.linspace(-1.15, 1.15, 601) * entry.a
    for (label, line), style in zip(lines.items(), STYLES):
        axis.plot(x, line.pressure(entry, x), style, color="0.35", label=label)
    shown = _thinned(entry.surface.x / entry.a)
    axis.plot(
        entry.surface.x[shown], entry.surface.pressure[shown], "o", ms=3.5, color=COLOURS[0], label="finite elements"
    )
    axis.set(xlabel="position x/a [–]", ylabel="pressure p a/P [–]", title="Pressure")
    axis.legend(loc="lower center")


def _traction(axis, history, mu, lines):
    for entry, colour in zip(_states(history), COLOURS):
        x, surface, increment = np.linspace(-1.15, 1.15, 1201) * entry.a, entry.surface, entry.increment
        for line, style in zip(lines.values(), STYLES):
            axis.plot(x, line.traction(entry, x) / mu, style, color=colour, lw=1)
        shown = _thinned(surface.x / entry.a)
        label = rf"{increment.state}: $Q = {increment.Q / (mu * increment.P):+.2f}\,\mu P$"
        axis.plot(surface.x[shown], surface.traction[shown] / mu, "o", ms=3, color=colour, label=label)
    for label, style in zip(lines, STYLES):
        axis.plot([], [], style, color="0.35", lw=1, label=label)
    low, high = axis.get_ylim()
    top = high + 0.45 * (high - low)  # room for the legend
    axis.set(xlabel="position x/a [–]", ylabel="traction q a/(μ P) [–]", title="Traction", ylim=(low, top))
    axis.legend(loc="upper center", ncols=2)


def _loop(axis, simulation, lines):
    history, mu, scaled = simulation.history, simulation.mu, simulation.scaled
    unit = mu * scaled.solid.alpha * float(scaled.indenter.height(1.0))
    for (label, line), style in zip(lines.items(), STYLES):
        if isinstance(line, Springs) and simulation.loop and simulation.scene.k > 0:
            _closed_loop(axis, simulation.loop, unit, style, label)
    moving = [e for e in history.entries if e.increment.branch != "normal"]
    start = [e for e in history.entries if e.increment.branch == "normal"][-1].surface.delta[0]
    delta = np.array([e.surface.delta[0] - start for e in moving])
    Q = np.array([e.increment.Q for e in moving])
    axis.plot(delta / unit, Q / mu, "o", ms=4, color=COLOURS[4], label="finite elements")
    axis.set(
        xlabel=r"rigid shift $\delta_x\,/\,(\mu\alpha f(a))$ [–]",
        ylabel=r"tangential load $Q/(\mu P)$ [–]",
        title="Friction loop",
    )
    axis.legend(loc="upper left")


def _closed_loop(axis, loop, unit, style, label):
    for branch in ("initial", "unloading", "reloading"):
        Q = np.linspace(0.0 if branch == "initial" else -loop.Q_A, loop.Q_A, 201)
        shift = np.array([loop.rigid_shift(q, branch) for q in Q])
        axis.plot(shift / unit, Q / loop.mu, style, color="0.35", lw=1, label=label if branch == "initial" else None)


def _thinned(x):
    """Indices of about DOTS nodes, evenly spread over |x| < 1.1 whatever the grading."""
    wanted = np.linspace(-1.1, 1.1, DOTS)
    return np.unique(np.clip(np.searchsorted(x, wanted), 0, len(x) - 1))
