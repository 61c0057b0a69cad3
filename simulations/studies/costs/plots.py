"""Figures of the study of cost: work and precision, rates, where the error comes from, and the Pareto front."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullFormatter

from ...output.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, SKY, save, style

UNCOUPLED = {  # colour, marker and name
    "default": (BLUE, "o", "k = 0.3, Holl ratio"),
    "k=-0.5": (RED, "s", "k = −0.5"),
    "k=0": (GREEN, "^", "k = 0"),
    "k=0.7": (PURPLE, "D", "k = 0.7"),
    "peer": (SKY, "v", "k = 0, ν = 0.495, coupled"),
    "GetFEM": (BLACK, "X", "GetFEM, the same loop"),
}
WITH_COUPLING = {
    "coupled k=-0.5": (RED, "s", "k = −0.5, ν = 0.3"),
    "coupled k=-0.25": (PURPLE, "<", "k = −0.25, ν = 0.3"),
    "coupled k=0": (GREEN, "^", "k = 0, ν = 0.3"),
    "coupled k=0.3": (BLUE, "o", "k = 0.3, ν = 0.3"),
    "coupled k=0.7": (ORANGE, "D", "k = 0.7, ν = 0.3"),
    "peer": (SKY, "v", "k = 0, ν = 0.495"),
    "GetFEM": (BLACK, "X", "GetFEM, k = 0, ν = 0.495"),
}
QUANTITIES = {"pressure": "p", "traction": "q", "slip": "slip", "c": "c", "dissipated_energy": "ΔW"}
SOURCES = {  # of the error: keys of the settings that each comes from
    "along the surface": ("mesh.facet", "mesh.growth", "mesh.edge_facet"),
    "into the depth": ("mesh.first_layer", "mesh.layer_growth"),
    "truncation": ("mesh.extent",),
    "increments": ("solver.increments",),
    "algebra": ("tolerance",),
}
FLOOR = 1e-9


def draw(rows: list[dict], folder: Path) -> list[Path]:
    """Write every figure that the rows suffice for, as PNG and SVG; the files written."""
    rows = [row for row in rows if not row.get("failure")]
    written = []
    for figure in (work_precision, rates, sources, pareto, coupled):
        with style():
            drawn = figure(rows)
            written += [] if drawn is None else save(drawn, folder, figure.__name__, ("png", "svg"))
    return written


def work_precision(rows):
    """Error against seconds for each quantity, fineness by fineness."""
    lines = _lines(rows, UNCOUPLED)
    if not lines:
        return None
    figure, axes = plt.subplots(1, len(QUANTITIES), figsize=(13, 3.6), sharey=True, layout="constrained")
    for axis, (quantity, name) in zip(axes, QUANTITIES.items()):
        _against_seconds(axis, lines, UNCOUPLED, quantity)
        axis.set(title=name, xlabel="CPU time [s]")
    axes[0].set_ylabel("relative error [-]")
    handles, labels = max((axis.get_legend_handles_labels() for axis in axes), key=lambda pair: len(pair[0]))
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def coupled(rows):
    """Loops with coupling, every state: worst q and the energy of the cycle against seconds, load steps included."""
    lines = _lines([row for row in rows if row.get("traction_of_states", "") != ""], WITH_COUPLING)
    if not lines:
        return None
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.2), sharey=True, layout="constrained")
    for axis, quantity in zip(axes, ("traction_of_states", "dissipated_energy")):
        _against_seconds(axis, lines, WITH_COUPLING, quantity)
        axis.set(xlabel="CPU time of the whole loop [s]")
    axes[0].set(title="q, worst state of the cycle", ylabel="relative error [-]")
    axes[1].set(title="energy of the cycle")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return figure


def rates(rows):
    """Pressure error against the facet at degrees 1 to 3; lines: the rates of the theory for a smooth pressure."""
    found = [row for row in rows if row["study"] == "degree"]
    if not found:
        return None
    problems = [problem for problem in UNCOUPLED if any(row["problem"] == problem for row in found)]
    figure, axes = _row_of_panels(problems, 3.3 * len(problems), 3.6)
    for axis, problem in zip(axes, problems):
        for degree, marker, colour in ((1, "o", BLUE), (2, "s", RED), (3, "^", GREEN)):
            mine = [row for row in found if row["problem"] == problem and row["level"].startswith(str(degree))]
            points = sorted((float(row["level"].partition(":")[2]), row["pressure"]) for row in mine)
            if len(points) > 1:
                h, error = map(np.array, zip(*points))
                axis.loglog(h, error, marker=marker, color=colour, label=f"degree {degree}")
                rate, place = np.polyfit(np.log(h), np.log(error), 1)[0], (h[0], error[0])
                axis.annotate(f"{rate:.1f}", place, textcoords="offset points", xytext=(-4, -12), color=colour)
                axis.loglog(h, error[-1] * (h / h[-1]) ** degree, ":", color=colour, linewidth=1)
        axis.set(title=UNCOUPLED[problem][-1], xlabel="facet / a [-]")
        axis.xaxis.set_minor_formatter(NullFormatter())
    axes[0].set_ylabel("relative error of p (L2) [-]")
    axes[0].plot([], [], "k:", label="order = degree")
    axes[0].legend(fontsize=8)
    return figure


def sources(rows):
    """By how much the largest change of each setting towards the finer changes p, q, slip, c and ΔW of the default
    mesh.
    """
    found = {(row["problem"], row["level"]): row for row in rows if row["study"] == "one at a time"}
    problems = [problem for problem in UNCOUPLED if (problem, "centre") in found]
    if not problems:
        return None
    figure, axes = _row_of_panels(problems, max(3.3 * len(problems), 7.0), 3.8)
    colours = (BLUE, SKY, GREEN, RED, BLACK)
    for axis, problem in zip(axes, problems):
        centre = found[problem, "centre"]
        for number, (source, keys) in enumerate(SOURCES.items()):
            finer = [row for key in keys for row in _finest(found, problem, key)]
            heights = [max([abs(row[q] - centre[q]) for row in finer] + [FLOOR]) for q in QUANTITIES]
            axis.bar(np.arange(len(heights)) + 0.16 * (number - 2), heights, 0.16, color=colours[number], label=source)
        own = [centre[q] for q in QUANTITIES]
        axis.plot(np.arange(len(own)), own, "k_", markersize=26, label="error itself")
        axis.set(title=UNCOUPLED[problem][-1], yscale="log", ylim=(FLOOR, 1e-1))
        axis.set_xticks(np.arange(len(QUANTITIES)), QUANTITIES.values())
        axis.grid(False, axis="x")
    axes[0].set_ylabel("change of the relative error [-]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8)
    return figure


def pareto(rows):
    """Largest error against seconds: every case of one rank, and those that nothing beats in both."""
    studies = ("fineness", "degree", "one at a time", "method", "peer")
    rows = [row for row in rows if row["study"] in studies]
    problems = [p for p in UNCOUPLED if any(row["problem"] == p for row in rows) and p != "GetFEM"]
    if not problems:
        return None
    figure, axis = plt.subplots(figsize=(6.4, 5.0), layout="constrained")
    for problem in problems:
        mine = [row for row in rows if row["problem"] == problem and row["ranks"] == 1]
        points = sorted((row["cpu_s"], row["largest"]) for row in mine)
        if points:
            colour, marker, label = UNCOUPLED[problem]
            axis.loglog(*zip(*points), marker, color=colour, alpha=0.3, markersize=4)
            best = np.minimum.accumulate([np.inf, *(error for _, error in points)])
            front = [point for point, before in zip(points, best) if point[1] < before]
            axis.loglog(*zip(*front), marker + "-", color=colour, label=label)
    peer = [(row["cpu_s"], row["largest"]) for row in rows if row["problem"] == "GetFEM"]
    if peer:
        colour, marker, label = UNCOUPLED["GetFEM"]
        axis.loglog(*zip(*sorted(peer)), marker + "--", color=colour, label=label)
    axis.set(xlabel="CPU time of the whole loop [s]", ylabel="largest of the errors of p, q, slip, a, c, ΔW [-]")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    return figure


def _against_seconds(axis, lines, problems, quantity):
    """A quantity of the ``_lines`` of these problems, where it is known."""
    for problem, line in lines.items():
        points = [(row["cpu_s"], max(row[quantity], FLOOR)) for row in line if row.get(quantity, "") != ""]
        if points:
            colour, marker, label = problems[problem]
            axis.loglog(*zip(*points), marker + "-", color=colour, label=label)


def _lines(rows, problems):
    """Rows of the study of fineness and of the peer by problem, in the order of their seconds."""
    found = sorted((row for row in rows if row["study"] in ("fineness", "peer")), key=lambda row: row["cpu_s"])
    lines = {problem: [row for row in found if row["problem"] == problem] for problem in problems}
    return {problem: line for problem, line in lines.items() if line}


def _finest(found, problem, key):
    """A list of the row of ``key``'s level that is furthest on the accurate side of the default, empty without one."""
    levels = [level for one, level in found if one == problem and level.startswith(key + "=")]
    levels.sort(key=lambda level: float(level.partition("=")[2]), reverse=key in ("mesh.extent", "solver.increments"))
    return [found[problem, level] for level in levels[:1]]


def _row_of_panels(problems, width, height):
    """A figure, and an axis for each problem."""
    size = (width, height)
    figure, axes = plt.subplots(1, len(problems), figsize=size, sharey=True, layout="constrained", squeeze=False)
    return figure, axes[0]
