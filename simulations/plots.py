"""One picture of a run: pressure, traction and the friction loop, computed points on closed-form lines."""

import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from analytic import CylinderContact, FrettingLoop

from .history import Entry, History

COLOURS = {"A": "#0072B2", "B": "#E69F00", "C": "#009E73", "D": "#CC79A7", "E": "#D55E00"}  # colour-blind safe
DOTS = 45  # computed points shown a curve


def plot_run(
    path: Path, title: str, history: History, contact: CylinderContact, loop: FrettingLoop | None, exact: bool
):
    """PNG of the last state's pressure and, with friction, the states A ... E of the last cycle and the loop.

    exact: the closed form describes the same problem.
    """
    theory = "closed form" if exact else "closed form (no coupling)"
    panels = 1 if loop is None else 3
    with plt.rc_context({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3, "legend.fontsize": 9}):
        figure, axes = plt.subplots(1, panels, figsize=(4.7 * panels, 4.6), layout="constrained", squeeze=False)
        figure.suptitle(title, wrap=True, parse_math=False)
        _pressure(axes[0, 0], history.entries[-1], contact, theory)
        if loop is not None:
            _traction(axes[0, 1], _states(history), loop, theory)
            _loop(axes[0, 2], history, loop, theory)
        partial = path.with_name("part." + path.name)
        figure.savefig(partial, dpi=160)
        plt.close(figure)
    os.replace(partial, path)


def _states(history: History) -> dict[str, Entry]:
    named = {e.increment.state: e for e in history.entries if e.increment.state}
    return {state: named[state] for state in COLOURS if state in named}


def _pressure(axis, entry, contact, theory):
    x = np.linspace(-1.15, 1.15, 601) * contact.a
    peak = contact.peak_pressure
    axis.plot(x / contact.a, contact.pressure(x) / peak, color="0.35", label=theory)
    shown = _thinned(entry.surface.x / contact.a)
    pressure = entry.surface.pressure[shown] / peak
    axis.plot(entry.surface.x[shown] / contact.a, pressure, "o", ms=3.5, color=COLOURS["A"], label="finite elements")
    axis.set(xlabel="position x/a [–]", ylabel="pressure p/p(0) [–]", title="Pressure")
    axis.legend(loc="lower center")


def _traction(axis, states, loop, theory):
    x = np.linspace(-1.15, 1.15, 1201) * loop.a
    limit = loop.mu * loop.contact.peak_pressure
    for state, entry in states.items():
        at = {"Q": entry.increment.Q, "branch": entry.increment.branch}
        axis.plot(x / loop.a, loop.traction(x, **at) / limit, color=COLOURS[state], lw=1)
        shown = _thinned(entry.surface.x / loop.a)
        share = entry.increment.Q / loop.Q_A
        label = rf"{state}: $Q = {share:+.1f}\,Q_A$"
        points = entry.surface.traction[shown] / limit
        axis.plot(entry.surface.x[shown] / loop.a, points, "o", ms=3, color=COLOURS[state], label=label)
    axis.plot([], [], color="0.35", lw=1, label=theory)
    axis.set(xlabel="position x/a [–]", ylabel=r"traction q/(μ p(0)) [–]", title="Traction", ylim=(None, 1.55))
    axis.legend(loc="upper center", ncols=2)


def _loop(axis, history, loop, theory):
    # displacements per mu alpha a²/(2R), loads per mu P
    unit = loop.mu * loop.contact.solid.alpha * loop.a**2 / (2 * loop.contact.R)
    load = loop.mu * loop.contact.P
    moving = [e for e in history.entries if e.increment.branch != "normal"]
    start = [e for e in history.entries if e.increment.branch == "normal"][-1].surface.delta[0]
    if loop.contact.solid.k > 0:
        for branch in ("initial", "unloading", "reloading"):
            Q = np.linspace(0.0 if branch == "initial" else -loop.Q_A, loop.Q_A, 201)
            shift = np.array([loop.rigid_shift(q, branch) for q in Q])
            axis.plot(shift / unit, Q / load, color="0.35", lw=1, label=theory if branch == "initial" else None)
    delta = np.array([e.surface.delta[0] - start for e in moving])
    Q = np.array([e.increment.Q for e in moving])
    axis.plot(delta / unit, Q / load, "o", ms=4, color=COLOURS["E"], label="finite elements")
    axis.set(
        xlabel=r"rigid shift $\delta_x\,/\,(\mu\alpha a^2/2R)$ [–]",
        ylabel=r"tangential load $Q/(\mu P)$ [–]",
        title="Friction loop",
    )
    axis.legend(loc="upper left")


def _thinned(x):
    """Indices of about DOTS nodes, evenly spread over |x| < 1.1 whatever the grading."""
    wanted = np.linspace(-1.1, 1.1, DOTS)
    return np.unique(np.clip(np.searchsorted(x, wanted), 0, len(x) - 1))
