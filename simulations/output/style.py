"""Style of all pictures in one place: fonts, colours, markers, sizes, files."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from ..scene import Scene
from .files import on_disk
from .page_words import quantity, strain_course

BLUE, ORANGE, GREEN, PURPLE, RED = "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00"  # colour-blind safe
SKY, BLACK = "#56B4E9", "#000000"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED)
MARKERS = ("o", "s", "^", "D", "v")  # colour is never the only difference
GREY = "0.35"
FONTS = {
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.prop_cycle": plt.cycler(color=COLOURS),
    "legend.fontsize": 9.5,
    "legend.frameon": False,
    "mathtext.fontset": "dejavusans",
    "axes.grid": True,
    "grid.alpha": 0.3,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    "pdf.fonttype": 42,  # text stays text
}
PIXELS_PER_INCH = 130


def in_words(scene: Scene) -> str:
    """Parameters and loads of a run, for the title of its pictures."""
    values = [_modulus(scene), f"ν = {scene.solid.nu:.4g}", f"P = {scene.P:.4g} N/m"]
    if scene.indenter.profile != "parabola":
        values.append(f"{scene.indenter.profile} profile")
    if scene.friction:
        values.append(f"μ = {scene.mu:g}")
    if scene.effects.friction_in_normal_stage:
        values.append("friction from first contact")
    if scene.is_loop:
        values.append(f"Q_A = {scene.load.amplitude:g} μP")
    if scene.is_path:
        Q = max(abs(Q) for _, Q in scene.load.points)
        most = f", |Q| ≤ {Q:.4g} N/m" if scene.friction else ""
        values.append(f"{len(scene.load.points)} points of (P, Q){most}")
    if scene.bulk_strain:
        values.append(f"bulk strain {scene.bulk_strain:.3g} {strain_course(scene)}")
    return ",  ".join(values)


def _modulus(scene):
    """E(y) in a few words."""
    solid, thickness = scene.material, getattr(scene.material, "thickness", None)
    law = f"k = {scene.k:g}".replace("-", "−")
    if hasattr(solid, "E_substrate"):
        top, deep = (quantity(E, "Pa", 4) for E in (solid.E0, solid.E_substrate))
        law = f"{solid.modulus} coating: E = {top} to {deep}"
    return law if thickness is None else f"{law} over {quantity(thickness, 'm', 4)}"


def spread(states: list, most: int = len(COLOURS)) -> list:
    """All states, or ``most`` evenly spread ones of more: the first and the last are among them."""
    places = np.linspace(0, len(states) - 1, min(len(states), most)).round().astype(int)
    return [states[i] for i in places]


def evenly(x: np.ndarray, reach: float, count: int, values: np.ndarray | float = 0.0) -> np.ndarray:
    """Indices of about ``count`` points among x (n,), evenly spread over |x| < reach whatever the grading: along the
    curve of the ``values`` there, drawn as high as it is long on either side, so that a narrow peak has its share.
    """
    near = np.flatnonzero((np.abs(x) < reach) & np.isfinite(values))
    y = np.broadcast_to(values, x.shape)[near]
    y = y * reach / (np.abs(y).max() or 1.0)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x[near]), np.diff(y)))])
    places = np.searchsorted(along, np.linspace(0.0, along[-1], count))
    return near[np.unique(np.minimum(places, len(near) - 1))]


def left_out(shown: int, states: int) -> str:
    """How many of the states are shown, in words; "" where all are."""
    return f"{shown} of {states} states shown" if shown < states else ""


def style():
    """Context in which figures have the fonts, lines and colours of this project."""
    return plt.rc_context(FONTS)


def panels(columns: int, title: str, note: str, rows: int = 1, width: float = 5.2, height: float = 4.4):
    """A figure with axes (rows, columns), a title, and a note below; both are wrapped where they hold no mathematics,
    which matplotlib would tear apart.
    """
    size = (width * columns, height * rows + 0.5)
    figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    figure.get_layout_engine().set(w_pad=0.08, h_pad=0.06)
    for axis in axes.flat:  # few enough tick labels to stay apart
        axis.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
    figure.suptitle(title, fontsize=12, wrap="$" not in title)
    figure.supxlabel(note, fontsize=9, color=GREY, wrap="$" not in note)
    return figure, axes


def save(figure, folder: Path, name: str, kinds: tuple[str, ...] = ("pdf", "png")) -> list[Path]:
    """NAME.pdf and NAME.png in ``folder``, or other ``kinds``, each whole or not at all; the figure is closed."""
    paths = [folder / f"{name}.{kind}" for kind in kinds]
    try:
        for path in paths:
            with on_disk(path) as partial:
                figure.savefig(partial, dpi=PIXELS_PER_INCH)
    finally:
        plt.close(figure)
    return paths
