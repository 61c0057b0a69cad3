"""Figures 8 and 9: energy dissipated per cycle against the amplitude of the tangential load."""

from typing import NamedTuple

import numpy as np

from ...output.style import BLUE, COLOURS, GREEN, MARKERS, ORANGE, PURPLE, RED, panels
from .elements import Deviation, Runs, convert
from .setting import DEPTHS, EXPONENTS, GRADINGS, MU, NU, contact, homogeneous_units, own_units

COMPUTED = (0.3, 0.6, 0.9)  # amplitudes of the finite-element loops
NOTE = (
    f"Lines: closed forms with ν = {NU:g} (the paper gives no ν; μ drops out), which neglect coupling. "
    "Points: finite elements with coupling off.\n"
    "Below: the same on a logarithmic scale. The homogeneous curve is the paper's equation (59).\n"
)


class Line(NamedTuple):
    """One curve of a panel."""

    k: float
    y0_over_a0: float
    label: str
    colour: str
    marker: str


def curve(k: float, y0_over_a0: float, amplitude, nu: float = NU) -> np.ndarray:
    """[X4] at amplitude = Q_A/(mu P), any shape, over mu² P a0²/(2R)."""
    normal = contact(k, y0_over_a0, nu)
    work = normal.slip_work(np.log1p(-np.asarray(amplitude, dtype=float)))
    return MU**2 * normal.solid.alpha * work / homogeneous_units(normal).energy


HOMOGENEOUS = Line(0.0, 1.0, r"$k = 0$ (homogeneous)", RED, "*")


def figure8(runs: Runs):
    """Various y0 for k = -0.5 and 0.5."""
    colours, lines = [colour for colour in COLOURS if colour != RED], {}
    for panel, k in EXPONENTS.items():
        styles = zip(DEPTHS, colours, MARKERS, strict=False)
        graded = [Line(k, y, rf"$y_0 = {y:g}\,a_0$", colour, marker) for y, colour, marker in styles]
        lines[f"({panel})  $k = {k:g}$"] = [*graded, HOMOGENEOUS]
    note = NOTE + "A power law has no length of its own: one run serves all $y_0$. The $y_0$ are our choice."
    return _draw(runs, "Figure 8. Dissipated energy for various depths of grading", note, lines)


def figure9(runs: Runs):
    """Various k for y0 = 0.01 a0 and 10 a0."""
    colours, markers = (BLUE, ORANGE, RED, GREEN, PURPLE), ("o", "s", "*", "^", "D")
    labels = [f"$k = {k:g}$" + (" (homogeneous)" if k == 0 else "") for k in GRADINGS]
    lines = {}
    for panel, y in {"a": 0.01, "b": 10.0}.items():
        curves = zip(GRADINGS, labels, colours, markers, strict=True)
        lines[rf"({panel})  $y_0 = {y:g}\,a_0$"] = [Line(k, y, *look) for k, *look in curves]
    note = NOTE + "The exponents k are our choice: the paper names none in its text."
    return _draw(runs, "Figure 9. Dissipated energy for various exponents of grading", note, lines)


def _draw(runs, title, note, lines):
    """lines: those of a panel by its title."""
    figure, axes = panels(2, title, note, rows=2, height=3.9)
    deviations = []
    share = np.linspace(0, 1 - 1e-9, 301)
    for pair, (name, curves), panel in zip(axes.T, lines.items(), "ab", strict=True):
        axis, logarithmic = pair
        for line in curves:
            normal = contact(line.k, line.y0_over_a0)
            own, units = own_units(normal), homogeneous_units(normal)
            energies = curve(line.k, line.y0_over_a0, share)
            loops = [runs.loop(line.k, NU, amplitude, coupling=False) for amplitude in COMPUTED]
            computed = convert(np.array([loop.energy for loop in loops]), own, units, "energy")
            size = 8 if line.marker == "*" else None
            for one in pair:
                one.plot(share[1:], energies[1:], color=line.colour)
                one.plot(COMPUTED, computed, line.marker, ms=size, color=line.colour, label=line.label)
            exact = curve(line.k, line.y0_over_a0, COMPUTED)
            largest = float(np.max(np.abs(computed / exact - 1)))
            words = f"k = {line.k:g}, y0 = {line.y0_over_a0:g} a0"
            deviations.append(Deviation(panel, words, "energy", "error", largest, float("nan")))
        for one in pair:
            one.set(xlabel=r"amplitude $Q_A/(\mu P)$ [–]", ylabel=r"$\Delta W\,/\,(\mu^2 P a_0^2/2R)$ [–]", xlim=(0, 1))
        axis.set(title=name, ylim=(0, None))
        logarithmic.set(yscale="log", ylim=(1e-4, 20))
        axis.legend(loc="upper left")
    return figure, deviations
