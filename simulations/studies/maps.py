"""Map the energy that fretting dissipates over grading, load and profile:  python -m simulations.studies.maps."""

import itertools
import os
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..command.command import comm, on_root, run, say
from ..output.files import write_text
from ..output.style import save, style
from ..scene import SceneError
from .commandline import make_folders, study_parser
from .engine import FAILED, Item, run_on
from .mapping import pictures
from .mapping.answers import best_profile, table
from .mapping.points import Energies, Point, by_simulation, by_theory
from .store import Store

EXPONENTS = tuple(round(0.1 * i, 1) for i in range(-6, 9))
AMPLITUDES = (0.2, 0.4, 0.6, 0.8, 0.95)
PROFILES = (1.5, 2.0, 4.0)
FINE = tuple(float(k) for k in np.round(np.linspace(-0.8, 0.9, 69), 3))  # of the theory's maps
RANGES = {"k": (-1, 1), "amplitudes": (0, 1), "profiles": (1, 20), "nu": (-1, 0.5), "mu": (0, 10)}  # open intervals
INTRODUCTION = """\
ν = {nu:g}, μ = {mu:g}. Made by `./docker/run python -m simulations.studies.maps`; `--help` names the options. The ends
of the range of k that was searched are where most of the extremes lie: there the table says which way to go, not how
far. Finite elements confirm the simulated energies: at k = −0.5, ν = μ = 0.3, parabola, Q_A = 0.6 μP they find 0.637
of the theory's in the first cycle, as mesh-free loops do. All ratios are to a homogeneous
half-plane of modulus E0 under the same load. A power law has no length of its own: each loop serves every y0.

"""
NOTE = (
    "Ratio to the homogeneous contact of the same profile and load. Purple: less, orange: more.\n"
    "Thick lines: equal to it, on the straight one because $k = 0$ is the homogeneous contact itself. "
)


def main(arguments: list[str]):
    """Draw the theory's maps at once, simulate what is missing of the others, draw them, and print what they say."""
    given = on_root(lambda: read(arguments))
    on_root(lambda: theory_pictures(given))
    if given.theory_only:
        return
    grid = itertools.product(given.profiles, given.amplitudes, given.k)
    points = [Point(k, amplitude, m, given.nu, given.mu) for m, amplitude, k in grid]
    items = [Item(f"k = {p.k:g}, Q_A = {p.amplitude:g} μP, |x|^{p.m:g}", vars(p)) for p in points]
    rows = run_on(comm, items, _loop, Store(given.output / "loops.jsonl"), say)
    if rows is None:
        return
    found = {point: Energies(**row) for point, row in zip(points, rows, strict=True) if FAILED not in row}
    drawn = ["map_theory", *simulated_pictures(given, found)]
    text = answers(given, found)
    write_text(given.page, page(given, text, drawn))
    say(f"\n{text}\nwritten to {given.output}: {', '.join(f'{name}.png' for name in drawn)}; {given.page}")


def _loop(values: dict) -> dict:
    return vars(by_simulation(Point(**values)))


def theory_pictures(given: Namespace):
    """Maps from the closed forms."""
    shown = [(2.0, 0.2), (2.0, 0.6), (2.0, 0.95)]
    found = theory(Point(k, amplitude, m, given.nu, given.mu) for m, amplitude in shown for k in FINE)
    note = NOTE + f"Closed forms, ν = {given.nu:g}; coupling neglected, so that μ drops out."
    with style():
        title = "Dissipated energy over grading and load: theory"
        save(pictures.over_depth(found, shown, title, note), given.output, "map_theory")
    say(f"theory: {len(found)} points, map_theory.png")


def theory(points: Iterable[Point]) -> dict[Point, Energies]:
    """The closed forms at points."""
    return {point: by_theory(point) for point in points}


def simulated_pictures(given: Namespace, found: dict[Point, Energies]) -> list[str]:
    """Maps from the simulated loops; their names. A contour needs two values of each axis: where fewer were asked for,
    or too few loops converged, a profile or a whole map is left out.
    """
    middle, drawn = _middle(given.amplitudes), {}
    by_simulation = f"Mesh-free simulation with coupling, ν = {given.nu:g}, μ = {given.mu:g}."
    shown = [(m, middle) for m in given.profiles if len({p.k for p in found if (p.m, p.amplitude) == (m, middle)}) > 1]
    points = {m: [p for p in found if p.m == m] for m in given.profiles}
    whole = [m for m, of_m in points.items() if min(len({p.k for p in of_m}), len({p.amplitude for p in of_m})) > 1]
    with style():
        if shown:
            title = "Dissipated energy over grading and profile: simulation with coupling"
            drawn["map_profiles"] = pictures.over_depth(found, shown, title, NOTE + by_simulation)
        if whole:
            m = 2.0 if 2.0 in whole else whole[0]
            title = f"Dissipated energy over grading and load, {pictures.shape(m)}: simulation with coupling"
            drawn["map_loads"] = pictures.over_amplitude(found, m, (0.01, 1.0, 100.0), title, NOTE + by_simulation)
            title = "What coupling does to the dissipated energy"
            note = f"Mesh-free simulation against the theory, for any $y_0$; ν = {given.nu:g}, μ = {given.mu:g}. "
            note += "Dots: simulated loops; cubic splines between them."
            both = {p: energies for p, energies in found.items() if p.m in whole}
            drawn["map_coupling"] = pictures.coupling_effect(both, theory(both), title, note)
        for name, figure in drawn.items():
            save(figure, given.output, name)
    return [*drawn]


def answers(given: Namespace, found: dict[Point, Energies]) -> str:
    """Which grading loses least or most, by profile, and which profile."""
    amplitude, expected = _middle(given.amplitudes), theory(found)
    text = "# Which grading loses least energy, which most?\n\n"
    text += INTRODUCTION.format(nu=given.nu, mu=given.mu)
    for m in given.profiles:
        text += table(found, expected, m, amplitude) + "\n"
    k = min(given.k)
    by_profile = best_profile(found, amplitude, k, 10.0)
    words = ", ".join(f"|x|^{m:g}: {energy:.3g}" for m, energy in sorted(by_profile.items()))
    text += f"Profiles of equal homogeneous half-width, ΔW/(μ²Pa0²/2R) at k = {k:g}, y0 = 10 a0: {words or '–'}.\n"
    return text.replace("= -", "= −")


PICTURES = {
    "map_theory": "Theory: energy and peak density over grading and depth, for three amplitudes",
    "map_profiles": "Simulation with coupling: the same for three profiles",
    "map_loads": "Simulation with coupling: over grading and amplitude, for three depths",
    "map_coupling": "What coupling changes",
}


def page(given: Namespace, text: str, drawn: list[str]) -> str:
    """Answers and the pictures ``drawn`` as Markdown."""
    folder = Path(os.path.relpath(given.output, given.page.parent)).as_posix()
    for name in drawn:
        text += f"\n## {PICTURES[name]}\n\n![{PICTURES[name]}]({folder}/{name}.png)\n"
    return text


def _middle(amplitudes):
    return amplitudes[len(amplitudes) // 2]


def read(arguments: list[str]) -> Namespace:
    """The checked command line; SceneError where it is wrong."""
    parser = study_parser("maps", __doc__, "results/maps", "answers and maps (default: DIR/maps.md)")
    parser.add_argument("--k", type=float, nargs="+", default=EXPONENTS, help="exponents of grading; 0 is always added")
    parser.add_argument("--amplitudes", type=float, nargs="+", default=AMPLITUDES, help="Q_A/(mu P)")
    parser.add_argument("--profiles", type=float, nargs="+", default=PROFILES, metavar="M", help="f ~ |x|^M")
    parser.add_argument("--nu", type=float, default=0.3, help="Poisson's ratio")
    parser.add_argument("--mu", type=float, default=0.3, help="coefficient of friction")
    parser.add_argument("--theory-only", action="store_true", help="no simulations")
    given = parser.parse_args(arguments)
    for name, (low, high) in RANGES.items():
        values = getattr(given, name)
        for value in values if isinstance(values, (list, tuple)) else (values,):
            if not low < value < high:
                raise SceneError(f"--{name} {value:g} is not allowed: a number, {low:g} < value < {high:g}")
    given.k = sorted({*given.k, 0.0})
    given.amplitudes, given.profiles = sorted(set(given.amplitudes)), sorted(set(given.profiles))
    return make_folders(given, "maps.md")


if __name__ == "__main__":
    run(main)
