"""Figures 8 and 9: energy dissipated per cycle against the amplitude of the tangential load."""

from dataclasses import dataclass

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


@dataclass(frozen=True)
class Line:
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
    others = [colour for colour in COLOURS if colour != RED]
    lines = {
        panel: [Line(k, y, rf"$y_0 = {y:g}\,a_0$", c, m) for y, c, m in zip(DEPTHS, others, MARKERS, strict=False)]
        + [HOMOGENEOUS]
        for panel, k in EXPONENTS.items()
    }
    titles = {panel: f"({panel})  $k = {k:g}$" for panel, k in EXPONENTS.items()}
    note = NOTE + "A power law has no length of its own: one run serves all $y_0$. The $y_0$ are our choice."
    return _draw(runs, "Figure 8. Dissipated energy for various depths of grading", note, lines, titles)


def figure9(runs: Runs):
    """Various k for y0 = 0.01 a0 and 10 a0."""
    colours = (BLUE, ORANGE, RED, GREEN, PURPLE)
    marks = ("o", "s", "*", "^", "D")

    def line(k, y, colour, mark):
        return Line(k, y, f"$k = {k:g}$" + (" (homogeneous)" if k == 0 else ""), colour, mark)

    depths = {"a": 0.01, "b": 10.0}
    lines = {
        panel: [line(k, y, c, m) for k, c, m in zip(GRADINGS, colours, marks, strict=True)]
        for panel, y in depths.items()
    }
    titles = {panel: rf"({panel})  $y_0 = {y:g}\,a_0$" for panel, y in depths.items()}
    note = NOTE + "The exponents k are our choice: the paper names none in its text."
    return _draw(runs, "Figure 9. Dissipated energy for various exponents of grading", note, lines, titles)


def _draw(runs, title, note, lines, titles):
    figure, axes = panels(2, title, note, rows=2, height=3.9)
    deviations = []
    share = np.linspace(0, 1 - 1e-9, 301)
    for (axis, logarithmic), (panel, curves) in zip(axes.T, lines.items(), strict=True):
        for line in curves:
            normal = contact(line.k, line.y0_over_a0)
            own, units = own_units(normal), homogeneous_units(normal)
            energies = curve(line.k, line.y0_over_a0, share)
            for one in (axis, logarithmic):
                one.plot(share[1:], energies[1:], color=line.colour)
            loops = [runs.loop(line.k, NU, amplitude, coupling=False) for amplitude in COMPUTED]
            computed = convert(np.array([loop.energy for loop in loops]), own, units, "energy")
            size = 8 if line.marker == "*" else None
            for one in (axis, logarithmic):
                one.plot(COMPUTED, computed, line.marker, ms=size, color=line.colour, label=line.label)
            exact = curve(line.k, line.y0_over_a0, COMPUTED)
            largest = float(np.max(np.abs(computed / exact - 1)))
            name = f"k = {line.k:g}, y0 = {line.y0_over_a0:g} a0"
            deviations.append(Deviation(panel, name, "energy", "error", largest, float("nan")))
        for one in (axis, logarithmic):
            one.set(xlabel=r"amplitude $Q_A/(\mu P)$ [–]", ylabel=r"$\Delta W\,/\,(\mu^2 P a_0^2/2R)$ [–]", xlim=(0, 1))
        axis.set(title=titles[panel], ylim=(0, None))
        logarithmic.set(yscale="log", ylim=(1e-4, 20))
        axis.legend(loc="upper left")
    return figure, deviations
