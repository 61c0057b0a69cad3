"""Figures of a page about a run, drawn from the files of its folder: surface, friction loop, body, convergence."""

import io
from math import ceil
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

from .body_pictures import fill, half_width, inside
from .body_states import BodyState
from .files import reading
from .page_words import prefixed, quantity
from .style import BLACK, BLUE, COLOURS, GREY, left_out, spread, style

WIDTH = 10.5  # inches, which the page shows as wide as itself
DENSITY = "frictional_work_of_cycle"  # of surface.h5 [J/m^2]
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))


def surface(folder: Path, rows: list[dict]) -> bytes | None:
    """Pressure, traction, slip, density of the dissipated energy and the loop in SI units; None without surface.h5.

    rows: those of history.csv.
    """
    if not (folder / "surface.h5").is_file():
        return None
    with reading(folder / "surface.h5") as path, h5py.File(path) as file:
        data = {name: file[name][()] for name in file if name not in ("state", "branch")}
        states = file["state"].asstr()[()]
    named = {name: i for i, name in enumerate(states) if name}  # the last state of each name
    shown = dict(spread([*named.items()])) or {"last state": len(states) - 1}
    pressed = np.flatnonzero(data["pressure"].max(axis=0) > 0)
    reach = 1.12 * np.abs(data["x"][pressed]).max()
    panels = [("pressure", "pressure p", "Pa")]
    panels += [("traction", "traction q", "Pa"), ("slip", "slip", "m")] * ("traction" in data)
    columns, extra = 3, 2 * ("traction" in data) + (DENSITY in data)
    with style():
        lines = ceil((len(panels) + extra) / columns)
        size = (WIDTH, 3.1 * lines + 0.3)
        figure, axes = plt.subplots(lines, columns, figsize=size, layout="constrained", squeeze=False)
        free = list(axes.flat)
        for name, words, unit in panels:
            _states(free.pop(0), data, name, words, unit, shown, reach)
        if DENSITY in data:
            full = [row["cycle"] for row in rows if row["state"] == "A"]
            _density(free.pop(0), data, reach, has_cycle=max(map(int, full), default=0) > 0)
        if "traction" in data:
            _loop(free.pop(0), free.pop(0), rows, shown)
        for axis in free:
            axis.set_visible(False)
        varies = np.ptp(data["P_prescribed"][list(shown.values())]) > 0
        labels = [_label(state, data, place, varies) for state, place in shown.items()]
        title = left_out(len(shown), len(named))
        beside = columns if varies else len(labels)
        figure.legend(axes[0, 0].lines, labels, loc="outside lower center", ncols=beside, title=title)
        return png(figure)


def body(states: list[BodyState], rows: list[dict]) -> bytes:
    """Von Mises stress below the contact at the states; rows: those of history.csv."""
    a = half_width(rows)
    with style():
        lines = ceil(len(states) / 3)
        size = (WIDTH, 2.1 * lines + 0.4)
        figure, axes = plt.subplots(lines, 3, figsize=size, layout="constrained", squeeze=False)
        fill(figure, axes, states, a, scale=max(inside(state, a).max() for state in states))
        return png(figure)


def convergence(rows: list[dict]) -> bytes:
    """Newton iterations and the force residual of every load step; rows: those of history.csv."""
    numbers = [int(row["increment"]) for row in rows]
    with style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(WIDTH, 2.6), layout="constrained")
        left.bar(numbers, [int(row["iterations"]) for row in rows], color=BLUE)
        left.set(xlabel="load step", ylabel="Newton iterations")
        right.semilogy(numbers, [max(float(row["residual"]), 1e-17) for row in rows], "o", color=BLUE)
        right.set(xlabel="load step", ylabel="force residual over P [–]")
        return png(figure)


def _label(state, data, place, varies):
    """A state by its name and its loads; varies: P is not the same in all of them."""
    P = f"P = {quantity(data['P_prescribed'][place], 'N/m', 4)}"
    if "Q_prescribed" not in data:
        return P
    Q = f"Q = {quantity(data['Q_prescribed'][place], 'N/m', 4)}"
    return f"{state}: {P + ', ' if varies else ''}{Q}"


def _states(axis, data, name, words, unit, shown, reach):
    """One field over x at the states shown. Lines, as a node is where they bend."""
    length, metres = prefixed(reach, "m")
    fields = data[name][list(shown.values())]
    if name == "slip":  # outside the contact it is no slip
        fields = np.where(data["pressure"][list(shown.values())] > 0, fields, np.nan)
    size, label = prefixed(np.nanmax(np.abs(fields[:, np.abs(data["x"]) < reach])), unit)
    for i, field in enumerate(fields):
        axis.plot(data["x"] / length, field / size, linestyle=DASHES[i], color=COLOURS[i])
    axis.set(xlim=(-reach / length, reach / length), xlabel=f"position x [{metres}]", ylabel=f"{words} [{label}]")


def _density(axis, data, reach, has_cycle):
    """Frictional work of the last cycle; where there is none, of all load steps."""
    length, metres = prefixed(reach, "m")
    density = data[DENSITY]
    size, label = prefixed(np.abs(density).max(), "J/m²")
    axis.plot(data["x"] / length, density / size, color=BLACK)
    axis.set(xlim=(-reach / length, reach / length), xlabel=f"position x [{metres}]")
    axis.set(ylabel=f"energy of {'the cycle' if has_cycle else 'all load steps'} w [{label}]")


def _loop(axis, narrow, rows, shown):
    """Tangential load over the indenter's shift, and over the shift less its mean line, which opens a thin loop."""
    first = max(sum(row["branch"] == "normal" for row in rows) - 1, 0)
    Q, shift = (np.array([float(row[name]) for row in rows[first:]]) for name in ("Q_prescribed[N/m]", "delta_x[m]"))
    shift = shift - shift[0]
    load, newton = prefixed(np.abs(Q).max(), "N/m")
    size, metres = prefixed(np.abs(shift).max(), "m")
    slope = Q @ shift / (Q @ Q) if Q.any() else 0.0
    rest = shift - slope * Q
    small, small_metres = prefixed(np.abs(rest).max(), "m")
    for panel, values, unit in ((axis, shift, size), (narrow, rest, small)):
        panel.plot(values / unit, Q / load, "-", color=GREY, lw=1)
        for i, place in enumerate(shown.values()):
            if place >= first:
                panel.plot(values[place - first] / unit, Q[place - first] / load, "o", color=COLOURS[i])
    axis.set(xlabel=f"shift δ_x of the indenter [{metres}]", ylabel=f"tangential load Q [{newton}]")
    narrow.set(xlabel=f"δ_x less its mean line [{small_metres}]", ylabel=f"tangential load Q [{newton}]")


def png(figure) -> bytes:
    """The figure as PNG; it is closed."""
    image = io.BytesIO()
    figure.savefig(image, dpi=150)
    plt.close(figure)
    return image.getvalue()
