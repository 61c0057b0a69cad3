"""One picture of a run: pressure, traction, slip, frictional work and the friction loop, points on reference lines."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from ..runs.closed_forms import Springs
from ..runs.comparison import Reference
from ..runs.history import Entry, History
from ..runs.simulation import Simulation
from .page_words import quantity
from .style import COLOURS, GREY, MARKERS, evenly, in_words, left_out, save, spread, style

STYLES = ("-", "--")
WIDTH = 6.0  # inches at least, as the longest line of the legend needs
DOTS = 45  # computed points shown a curve
DRAWN, DRAWN_LOOP = 461, 61  # points of a reference's curve, one a pixel; closed forms of most profiles are slow
NAMED, RED = 3, "#aa0000"  # failing checks that the picture names, and their colour
REACH = 1.15  # drawn part of the surface, over the widest contact
CONSTANT = 0.999  # of the largest normal load: a smaller one is another load
WORST = {"marker": "o", "ms": 9, "mfc": "none", "mec": "k", "mew": 1.0, "ls": "none"}  # a ring around the worst node


def plot_run(path: Path, simulation: Simulation, lines: dict[str, Reference], failing: Sequence[str] = ()):
    """PNG of the last state's pressure and, with friction, of traction and slip of the named states of the last cycle,
    of the frictional work w, and of the loop.

    lines: what the computed points are laid on, by label; the node farthest from the first is always among the points.
    failing: checks that fail, which the picture says in red.
    In all panels P is the largest normal load, and a the contact half-width that scales lengths, whatever the state.
    """
    history = simulation.history
    columns, rows = (3, 2) if history.friction else (1, 1)
    with style():
        size = (max(4.7 * columns, WIDTH), 3.8 * rows + 1.5)
        figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
        for axis in axes.flat:  # few enough tick labels to stay apart
            axis.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
        space = "\n " if failing else ""  # for the red line
        title = simulation.scene.title.replace("$", r"\$")  # no mathematics, for which wrapping would take it
        words = f"{title}\n{in_words(simulation.scene)}{space}"
        heading = figure.suptitle(words, wrap=True, fontsize=11)
        _pressure(axes[0, 0], simulation, lines)
        if history.friction:
            _traction(axes[0, 1], simulation, lines)
            _slip(axes[0, 2], simulation, lines)
            _work(axes[1, 0], simulation, lines)
            _loop(axes[1, 1], axes[1, 2], simulation, lines)
        _legend(figure, simulation, lines)
        if failing:
            _say_failing(figure, heading, failing)
        save(figure, path.parent, path.stem, ("png",))


def _say_failing(figure, heading, failing):
    """A red line in the last line of the heading, which is empty; it names as many checks as fit."""
    figure.draw_without_rendering()  # only then the heading has its place
    lowest = heading.get_window_extent().ymin / figure.bbox.height
    rest = f" and {len(failing) - NAMED} more" if len(failing) > NAMED else ""
    words = f"checks that fail: {', '.join(failing[:NAMED])}{rest}"
    figure.text(0.5, lowest, words, color=RED, ha="center", va="bottom", fontsize=11, parse_math=False)


def _named(history: History) -> list[Entry]:
    """The last state of each name, in the order in which the names first come."""
    return [*{e.step.state: e for e in history.entries if e.step.state}.values()]


def _states(history: History) -> list[Entry]:
    """The states that are shown, the last named one among them."""
    return spread(_named(history))


def _in_si(value, unit):
    """What 1 on a scaled axis is."""
    return f"1 = {quantity(value, unit, 3)}"


def _position(simulation):
    return f"position x/a [–]  ({_in_si(simulation.scaled.scales.length, 'm')})"


def _widest(history):
    """Where contact ends farthest from the middle, over all states."""
    return np.nanmax(np.abs([entry.contact for entry in history.entries]))


def _slip_unit(simulation):
    """mu alpha f(a), dimensionless: the slip (36) of a contact that slides all over."""
    scaled = simulation.scaled
    return simulation.mu * scaled.solid.alpha * float(scaled.indenter.height(1.0))


def _curves(axis, entry, widest, values, lines, colour, marker="o"):
    """Nodal ``values`` as points on reference ``lines`` (functions of x, None for one that is not known): a share of
    the nodes, and the one that is farthest from the first line; ``widest``: edge of the widest contact.
    """
    surface = entry.surface
    x = np.linspace(-REACH, REACH, DRAWN) * widest
    for line, dashes in zip(lines, STYLES):
        if line:
            axis.plot(x, line(x), dashes, color=colour, lw=1)
    shown = evenly(surface.x / widest, 1.1, DOTS, values)
    axis.plot(surface.x[shown], values[shown], marker, ms=3, color=colour)
    if lines and lines[0]:
        deviation = np.abs(values - lines[0](surface.x))
        inside = (np.abs(surface.x) < REACH * widest) & np.isfinite(deviation)
        worst = int(np.argmax(np.where(inside, deviation, -1.0)))
        axis.plot(surface.x[worst], values[worst], marker, ms=3, color=colour)
        axis.plot(surface.x[worst], values[worst], **WORST)
    axis.set_xlim(-1.1 * REACH * widest, 1.1 * REACH * widest)


def _pressure(axis, simulation, lines):
    entry = simulation.history.entries[-1]
    references = [lambda x, line=line: line.pressure(entry, x) for line in lines.values()]
    _curves(axis, entry, _widest(simulation.history), entry.surface.pressure, references, COLOURS[0])
    unit = _in_si(simulation.scaled.scales.stress, "Pa")
    axis.set(xlabel=_position(simulation), ylabel=f"pressure p a/P [–]  ({unit})", title="Pressure, last state")


def _traction(axis, simulation, lines):
    history, mu = simulation.history, simulation.mu
    for entry, colour, marker in zip(_states(history), COLOURS, MARKERS):
        references = [lambda x, line=line, e=entry: line.traction(e, x) / mu for line in lines.values()]
        _curves(axis, entry, _widest(history), entry.surface.traction / mu, references, colour, marker)
    unit = _in_si(mu * simulation.scaled.scales.stress, "Pa")
    axis.set(xlabel=_position(simulation), ylabel=f"traction q a/(μP) [–]  ({unit})")
    axis.set_title("Traction on the half-plane")


def _slip(axis, simulation, lines):
    history, unit = simulation.history, _slip_unit(simulation)
    for entry, colour, marker in zip(_states(history), COLOURS, MARKERS):

        def inside(x, values, entry=entry):  # of the contact: outside there is no slip
            return np.where((x >= entry.contact[0]) & (x <= entry.contact[1]), values / unit, np.nan)

        references = [lambda x, line=line, e=entry, f=inside: f(x, line.slip(e, x)) for line in lines.values()]
        _curves(axis, entry, _widest(history), inside(entry.surface.x, entry.slip), references, colour, marker)
    size = _in_si(unit * simulation.scaled.scales.displacement, "m")
    axis.set(xlabel=_position(simulation), title="Slip since tangential loading began")
    axis.set_ylabel(f"slip $(u_x - \\delta_x)/(\\mu\\alpha f(a))$ [–]  ({size})")


def _work(axis, simulation, lines):
    history, scales, mu = simulation.history, simulation.scaled.scales, simulation.mu
    unit, entry = mu * _slip_unit(simulation), history.entries[-1]

    def closed(x):
        return simulation.loop.energy_density(x) / unit

    is_known = simulation.loop and history.has_cycle  # and only the closed forms have it
    references = [closed if is_known and isinstance(line, Springs) else None for line in lines.values()]
    _curves(axis, entry, _widest(history), history.work / unit, references, COLOURS[2])
    size = _in_si(unit * scales.energy / scales.length, "J/m²")
    note = _note(lines, [label for label, known in zip(lines, references) if known])
    when = "last cycle" if history.has_cycle else "all load steps"
    energy = history.dissipated_energy * scales.energy
    axis.set(xlabel=_position(simulation) + note, title=f"Frictional work, {when}: ΔW = {energy:.4g} J/m")
    axis.set_ylabel(f"density $w\\,a/(\\mu P\\,\\mu\\alpha f(a))$ [–]  ({size})")


def _note(lines, drawn):
    """Below a panel in which only the second line, that of another problem, is drawn: else the run would look off."""
    return "\ndashed: another problem (see legend)" if drawn and drawn[0] != next(iter(lines)) else ""


def _loop(axis, beside, simulation, lines):
    """The friction loop, and how far each point is from the chord between its ends: the hysteresis."""
    history, mu, unit = simulation.history, simulation.mu, _slip_unit(simulation)
    start = [e for e in history.entries if e.step.branch == "normal"][-1]
    states = [start, *(e for e in history.entries if e.step.branch != "normal")]
    shift = np.array([e.surface.delta[0] - start.surface.delta[0] for e in states]) / unit
    Q = np.array([e.step.Q for e in states]) / mu
    low, high = np.argmin(Q), len(Q) - 1 - np.argmax(Q[::-1])
    slope = (shift[high] - shift[low]) / (Q[high] - Q[low]) if Q[high] > Q[low] else 0.0

    drawn = []
    if simulation.loop and simulation.scene.k > 0:  # elsewhere no closed form has a shift
        for (label, line), dashes in zip(lines.items(), STYLES):
            if isinstance(line, Springs):
                _closed_loop(axis, beside, simulation.loop, unit, dashes, history.has_cycle)
                drawn.append(label)
    axis.plot(shift, Q, "o-", ms=4, lw=0.5, color=COLOURS[4])
    beside.plot(shift - shift[low] - slope * (Q - Q[low]), Q, "o-", ms=4, lw=0.5, color=COLOURS[4])
    size = _in_si(unit * simulation.scaled.scales.displacement, "m")
    load = _in_si(mu * simulation.scaled.scales.line_load, "N/m")
    name, note = "$\\delta_x/(\\mu\\alpha f(a))$", _note(lines, drawn)
    for panel, words, title in ((axis, f"rigid shift {name}", ""), (beside, f"{name} − chord", " less its chord")):
        panel.set(xlabel=f"{words} [–]  ({size}){note}", ylabel=f"tangential load Q/(μP) [–]  ({load})")
        panel.set_title(f"Friction loop{title}")


def _closed_loop(axis, beside, loop, unit, dashes, is_cycle):
    branches = ("initial", "unloading", "reloading") if is_cycle else ("initial",)
    end = float(loop.rigid_shift(loop.Q_A, "initial")) / unit
    for branch in branches:
        Q = np.linspace(0.0 if branch == "initial" else -loop.Q_A, loop.Q_A, DRAWN_LOOP)
        shift = np.array([loop.rigid_shift(q, branch) for q in Q]) / unit
        axis.plot(shift, Q / loop.mu, dashes, color=GREY, lw=1)
        beside.plot(shift - end * Q / loop.Q_A, Q / loop.mu, dashes, color=GREY, lw=1)


def _legend(figure, simulation, lines):
    """One for all panels, below them."""
    history, mu, handles = simulation.history, simulation.mu, []
    varies = min(entry.step.P for entry in _states(history) or history.entries[-1:]) < CONSTANT
    if history.friction:
        for entry, colour, marker in zip(_states(history), COLOURS, MARKERS):
            step = entry.step
            normal = rf"${step.P:.2f}\,P$, " if varies else ""
            label = rf"{step.state}: {normal}$Q = {step.Q / mu:+.2f}\,\mu P$"
            handles.append(plt.Line2D([], [], marker=marker, ms=4, ls="none", color=colour, label=label))
    handles += [plt.Line2D([], [], marker="o", ms=4, ls="none", color=GREY, label="finite elements")]
    handles += [plt.Line2D([], [], ls=s, color=GREY, lw=1, label=label) for label, s in zip(lines, STYLES)]
    if lines:
        handles += [plt.Line2D([], [], **WORST, label="node farthest from the solid line")]
    is_graded = simulation.scene.is_power_law
    of = "under it, without friction" if is_graded else "on a constant modulus $E(a)$, under it"
    note = f"$P$: the largest normal load;  $a$: contact half-width {of}" if varies or not is_graded else ""
    if history.friction:
        shown = left_out(len(_states(history)), len(_named(history)))
        symbols = r"$f(a)$: height of the indenter at $x = a$;  $\alpha$: equation (37)"
        note = ";  ".join(filter(None, (note, symbols, shown)))
    columns = 5 if history.friction else 2
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, title=note, title_fontsize=9, fontsize=9)
