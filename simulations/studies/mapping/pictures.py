"""The maps as filled contours: where a quantity is that of the homogeneous contact there are thick lines."""

import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter
from scipy.interpolate import make_interp_spline

from ...output.style import BLACK, GREY, panels
from .answers import ratios
from .points import Energies, Point

DEPTHS = np.geomspace(1e-2, 1e2, 81)  # y0/a0
LEVELS = 2.0 ** np.arange(-5, 6)  # of ratios
CHANGES = np.array([-80, -70, -60, -50, -40, -30, -20, -10, -5, -2, -1, 0])  # of the energy by coupling [%]
FINE = len(DEPTHS)  # points a side between which contours are straight
NAMES = {"energy": r"energy per cycle $\Delta W$", "density": r"peak density $\max\,w$"}
SHAPES = {1.5: "$f\\sim|x|^{1.5}$", 2.0: "$f\\sim x^2$", 4.0: "$f\\sim x^4$"}


def shape(m: float) -> str:
    """The profile, set as mathematics."""
    return SHAPES.get(m, rf"$f\sim|x|^{{{m:g}}}$")


def over_depth(found: dict[Point, Energies], shown: list[tuple[float, float]], title: str, note: str):
    """Energy (top) and peak density (bottom) over k and y0/a0; shown: (m, amplitude) by column."""
    names = [rf"{shape(m)}, $Q_A = {amplitude:g}\,\mu P$" for m, amplitude in shown]
    columns = [[(m, amplitude, y) for y in DEPTHS] for m, amplitude in shown]
    words = {"yscale": "log", "ylabel": "depth $y_0/a_0$ [–]"}
    return _ratios_over(found, dict(zip(names, columns)), DEPTHS, title, note, **words)


def over_amplitude(found: dict[Point, Energies], m: float, depths: tuple[float, ...], title: str, note: str):
    """Energy (top) and peak density (bottom) over k and Q_A/(mu P), a column a depth."""
    amplitudes = sorted({p.amplitude for p in found if p.m == m})
    columns = {rf"$y_0 = {depth:g}\,a_0$": [(m, amplitude, depth) for amplitude in amplitudes] for depth in depths}
    return _ratios_over(found, columns, amplitudes, title, note, ylabel=r"amplitude $Q_A/(\mu P)$ [–]")


def _ratios_over(found, columns, y, title, note, **axis_words):
    """Over k and y (n,); columns: (m, amplitude, depth) (n,) by their name."""
    figure, axes = panels(len(columns), title, note, rows=2, width=4.3, height=3.7)
    for pair, (name, places) in zip(axes.T, columns.items(), strict=True):
        k = sorted({p.k for p in found if any((p.m, p.amplitude) == place[:2] for place in places)})
        for axis, quantity in zip(pair, NAMES, strict=True):
            rows = [ratios(found, quantity, *place) for place in places]
            # a hole in the map where a loop did not converge
            filled = _fill(axis, k, y, np.array([[row.get(one, np.nan) for one in k] for row in rows]))
            axis.set(xlabel="exponent $k$ [–]", title=name, **axis_words)
    as_ratio = FuncFormatter(lambda power, _: f"{2.0**power:g}" if power >= 0 else f"1/{2.0**-power:g}")
    for row, words in zip(axes, NAMES.values(), strict=True):
        bar = figure.colorbar(filled, ax=row.tolist(), label=f"{words} / homogeneous [–]", format=as_ratio)
        bar.set_ticks(np.log2(LEVELS))
    return figure


def coupling_effect(found: dict[Point, Energies], theory: dict[Point, Energies], title: str, note: str):
    """Simulated energy over that of the theory, over k and Q_A/(mu P), a column a profile."""
    profiles = sorted({p.m for p in found})
    figure, axes = panels(len(profiles), title, note, width=4.3, height=3.9)
    for axis, m in zip(axes[0], profiles, strict=True):
        of_m = {(p.k, p.amplitude): 100 * (e.energy / theory[p].energy - 1) for p, e in found.items() if p.m == m}
        k, amplitudes = sorted({key[0] for key in of_m}), sorted({key[1] for key in of_m})
        table = np.array([[of_m.get((x, y), np.nan) for x in k] for y in amplitudes])
        fine = _finer(k, amplitudes, table)
        filled = axis.contourf(*fine, CHANGES, cmap="viridis", norm=BoundaryNorm(CHANGES, 256), extend="both")
        lines = axis.contour(*fine, CHANGES, colors="white", linewidths=0.8, linestyles="solid")
        middles = [path.vertices[len(path) // 2] for path in lines.get_paths() if len(path) > FINE // 2]  # not cut off
        words = {"fmt": lambda v: f"{v:g} %".replace("-", "−"), "fontsize": 9, "colors": BLACK}
        for label in axis.clabel(lines, manual=middles, **words):
            label.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
        axis.plot(*np.array(list(of_m)).T, ".", ms=2.5, color="white")
        axis.set(xlabel="exponent $k$ [–]", ylabel=r"amplitude $Q_A/(\mu P)$ [–]", title=shape(m))
        axis.grid(False)
    figure.colorbar(filled, ax=axes[0].tolist(), ticks=CHANGES, label=r"change of $\Delta W$ by coupling [%]")
    return figure


def _finer(x, y, table):
    """x, y and table (y, x), by cubic splines at FINE places a side; as it is where the table has holes."""
    if np.isnan(table).any():
        return np.array(x), np.array(y), np.ma.masked_invalid(table)
    places = []
    for axis, points in ((1, x), (0, y)):
        places.append(np.linspace(points[0], points[-1], FINE) if len(points) < FINE else np.array(points))
        table = make_interp_spline(points, table, k=min(3, len(points) - 1), axis=axis)(places[-1])
    return *places, table


def _fill(axis, k, y, table):
    """Filled contours of ratios (y, k) that are 1 at k = 0, where a thick line stands; another one where else they are.

    The latter crosses k = 0: it is the zero of log(ratio)/k, which has a value there.
    """
    k, y, powers = _finer(k, y, np.log2(table))
    filled = axis.contourf(k, y, powers, np.log2(LEVELS), cmap="PuOr_r", extend="both")
    axis.contour(k, y, powers, np.log2(LEVELS[LEVELS != 1]), colors=GREY, linewidths=0.6, linestyles="solid")
    graded = np.abs(k) > 1e-9
    axis.contour(k[graded], y, powers[:, graded] / k[graded], [0.0], colors=BLACK, linewidths=2.2)
    axis.axvline(0, color=BLACK, lw=2.2)
    axis.grid(False)
    return filled
