"""Make the paper's figures with finite-element points on them:

    python -m simulations.studies.figures [4 5 ... 11 | all]
"""

import math
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from ..command.command import comm, on_root, run, say
from ..output.files import write_text
from ..output.style import save, style
from ..scene import SceneError
from .commandline import make_folders, study_parser
from .paper import comparisons, distributions, energies
from .paper.elements import Deviation, Runs

FIGURES: dict[int, Callable] = {
    4: partial(distributions.draw, number=4, y0_over_a0=0.1, quantity="traction"),
    5: partial(distributions.draw, number=5, y0_over_a0=10.0, quantity="traction"),
    6: partial(distributions.draw, number=6, y0_over_a0=0.1, quantity="density"),
    7: partial(distributions.draw, number=7, y0_over_a0=10.0, quantity="density"),
    8: energies.figure8,
    9: energies.figure9,
    10: comparisons.figure10,
    11: comparisons.figure11,
}
WHAT = {
    4: "traction, y0 = 0.1 a0",
    5: "traction, y0 = 10 a0",
    6: "energy density, y0 = 0.1 a0",
    7: "energy density, y0 = 10 a0",
    8: "energy per cycle for various y0",
    9: "energy per cycle for various k",
    10: "slip for the paper's pairs of k and ν",
    11: "traction at states A–E for the paper's pairs",
}


def main(arguments: list[str]):
    """Draw the figures asked for and say how far the computed points are from the curves."""
    numbers, folder, page = on_root(lambda: read(arguments))
    runs, found = Runs(comm), {}
    for number in numbers:
        say(f"Figure {number}: {WHAT[number]}")
        with style():
            figure, found[number] = FIGURES[number](runs)
            on_root(partial(save, figure, folder, f"figure{number}"))
    if comm.rank == 0:
        say("\n" + "\n".join(lines(found)))
        pictures = ", ".join(f"figure{n}.pdf, figure{n}.png" for n in numbers)
        if page is not None:
            write_text(page, text_of(found, folder, page))
        say(f"\nwritten to {folder}: {pictures}" + (f"; {page}" if page else ""))


def read(arguments: list[str]) -> tuple[list[int], Path, Path | None]:
    """Numbers of figures, folder and page of a command line; SceneError where it is wrong."""
    parser = study_parser("figures", __doc__, "results/figures", "pictures and deviations")
    parser.add_argument("figures", nargs="*", default=["all"], metavar="4 ... 11 | all")
    given = parser.parse_args(arguments)
    known = {str(number): number for number in FIGURES}
    for name in given.figures:
        if name != "all" and name not in known:
            raise SceneError(f"figure {name!r} is not one of {', '.join(known)} and all")
    numbers = list(FIGURES) if "all" in given.figures else sorted({known[name] for name in given.figures})
    make_folders(given)
    return numbers, given.output, given.page


def largest(deviations: list[Deviation]) -> str:
    """The largest deviation of each kind, in words."""
    words = []
    for kind in ("error", "difference"):
        of_kind = [d for d in deviations if d.kind == kind]
        if of_kind:
            worst = max(of_kind, key=lambda d: d.largest)
            l2 = "" if math.isnan(worst.l2) else f", L2 {worst.l2:.1e}"
            words.append(f"{kind} {worst.largest:.1e}{l2} ({worst.curve})")
    return "; ".join(words)


def lines(found: dict[int, list[Deviation]]) -> list[str]:
    """One line a figure, as a Markdown table: figure, command, picture, largest deviation."""
    head = ["| figure | command | picture | largest deviation of the points from the curves |", "|---|---|---|---|"]
    rows = [f"| {n}: {WHAT[n]} | `{COMMAND} {n}` | figure{n}.png | {largest(d)} |" for n, d in found.items()]
    return head + rows


def text_of(found: dict[int, list[Deviation]], folder: Path, page: Path) -> str:
    """The page: for every figure its picture and the deviation of every curve."""
    pictures = Path(os.path.relpath(folder, page.parent))
    text = INTRODUCTION
    for number, deviations in found.items():
        text += f"\n## Figure {number}: {WHAT[number]}\n\n    {COMMAND} {number}\n\n"
        text += f"![Figure {number}]({pictures.as_posix()}/figure{number}.png)\n\n"
        text += "| panel | curve | quantity | | largest, over the curve's maximum | L2 over the contact |\n"
        text += "|---|---|---|---|---|---|\n"
        for d in deviations:
            l2 = "" if math.isnan(d.l2) else f"{d.l2:.1e}"
            text += f"| {d.panel} | {d.curve} | {d.quantity} | {d.kind} | {d.largest:.1e} | {l2} |\n"
    return text


COMMAND = "./docker/run python -m simulations.studies.figures"
INTRODUCTION = f"""\
# The paper's figures

Figures 4–11 of Heß, Giesa, Riechert, Wilhayn, Appl. Sci. 2026, 16(1), 473, made by

    {COMMAND} all --output docs/figures --page docs/figures.md

Lines are the closed forms, points the finite elements. Where both have the same physics (coupling off, or the Holl
ratio ν = 1/(2+k)) their distance is an *error*; where the finite elements have the coupling that the closed forms
neglect it is a *difference*. Distances are taken at all nodes; some 40 of them are drawn, and always the one that is
farthest from the curve (in Figure 11 the farthest of a panel has a ring). Next to the edge of the contact the pressure
ends like distance^((1+k)/2), infinitely steep: there the largest error sits, and it is that of a single node.
"""

if __name__ == "__main__":
    run(main)
