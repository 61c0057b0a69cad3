"""Accuracy by one number: cell sizes from one family, whose errors were measured (``accuracy.csv``, by
``simulations.studies.cost``).

The family has one parameter, the fineness t: facets under the indenter are 0.025 t half-widths, all else follows. Its
errors are the largest of those of p, q and slip (L2 over the contact, of every state of a cycle), and of a, c and the
energy of the cycle at its end. Under a single load without friction those of the end count, which are smaller. Coupled
loops have lines of their own, as their edges turn at more places.
"""

import csv
from dataclasses import dataclass
from functools import cache
from math import isfinite
from pathlib import Path

from .errors import SceneError, rounded
from .solid import is_decoupled
from .tables import AnyLoad, AnySolid, Fretting, Indentation

TABLE = Path(__file__).with_name("accuracy.csv")
FINEST_EDGE = 6e-5  # a, for k < 0: slip on thinner layers has ten times the error
RESOLVED = 8  # edge facets in the slip zone, from which on its traction is about as good as that of a wider one
LARGEST = 0.5  # of an accuracy that may be asked for
WITHOUT_REFERENCE = 0.5  # of an accuracy: estimates, which are not to be less than the error, are about twice it
MARGIN = 1.5  # loads and gradings between those measured; a and c are read between nodes, where errors change sign


@dataclass(frozen=True)
class Measured:
    """One line of the table, with coupling or without, at grading ``k`` and fineness: the largest error of all states
    (nan: not measured) and of the last one, and CPU seconds of a loop of 31 load steps.
    """

    coupled: bool
    k: float
    fineness: float
    error: float
    last: float
    seconds: float


@dataclass(frozen=True)
class Choice:
    """Cell sizes for an accuracy, and what is expected of them: the largest error and the CPU seconds of a loop."""

    fineness: float
    mesh: dict[str, float]
    error: float
    seconds: float


def family(fineness: float, k: float, coupled: bool = False) -> dict[str, float]:
    """Keys of the scene at a fineness t. For k <= 0 layers and edge facets are refined alike: the edge is sharp
    both ways. For k < 0 what lies outside the domain counts: at k = -0.5, t = 1 p is off by 1.2e-4 on 20 a, by 4.6e-5
    on 60 a; with coupling it is wider anyway.
    """
    t = fineness
    edge = min(1e-3 * t**2, 0.02)
    if k < 0:
        edge = max(edge / 4.0, FINEST_EDGE)
    sizes = {
        "facet": min(0.025 * t, 0.2),
        "edge_facet": edge,
        "growth": min(1.3**t, 2.0),
        "first_layer": edge if k <= 0 else 1e-3 * t,
        "layer_growth": 2.0 if t > 2.5 else 1.6 if t > 0.8 or k < 0 else 1.4,
        "extent": 60.0 if k < 0 and not coupled else 20.0 if t > 0.6 else 30.0,
    }
    return {"mesh.degree": 3} | {f"mesh.{name}": float(f"{value:.4g}") for name, value in sizes.items()}


def of_scene(load: AnyLoad, material: AnySolid, coupling: bool) -> tuple[float, float | None, bool]:
    """A scene as the table knows it: k, Q_A/(mu P), which is 0.9 for paths and None for a single load without
    friction, and whether it is a loop with coupling. coupling: whether it is on; at the Holl ratio it vanishes.
    """
    k = getattr(material, "k", 0.0)
    if isinstance(load, Fretting):
        return k, load.amplitude, coupling and not is_decoupled(material)
    return k, None if isinstance(load, Indentation) else 0.9, False


def share_for(reference: str) -> float:
    """Of an accuracy, what the error of the mesh may be: less where ``reference.kind`` has it estimated."""
    return WITHOUT_REFERENCE if reference == "none" else 1.0


@cache
def table(path: Path = TABLE) -> tuple[Measured, ...]:
    """The measured lines."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return tuple(
        Measured(row.pop("coupled") == "1", **{name: float(value or "nan") for name, value in row.items()})
        for row in rows
    )


def choose(
    accuracy: float, k: float, amplitude: float | None = 0.9, coupled: bool = False, share: float = 1.0
) -> Choice:
    """The coarsest mesh whose error, with a margin, is this share of ``accuracy``; SceneError with the best there is
    where none is. amplitude: None under a single load without friction; coupled: whether this is a loop with coupling.
    """
    levels = expected(k, amplitude, coupled)
    enough = [choice for choice in levels if choice.error <= share * accuracy]
    if enough:
        return max(enough, key=lambda choice: choice.fineness)
    if not levels:
        low, high = (extreme(m.k for m in table() if m.coupled == coupled) for extreme in (min, max))
        reason = f"k = {k:g} lies outside {low:g} ... {high:g}, where errors were measured"
        raise SceneError(f"solver.accuracy = {accuracy:g} is not allowed: {reason}")
    best = min(levels, key=lambda choice: choice.error)
    promised = rounded(best.error / share, 2, up=True)
    what = f"{promised:.1e} (about {best.seconds:.0f} s)" if promised < LARGEST else f"{LARGEST:g} or more"
    raise SceneError(f"solver.accuracy = {accuracy:g} is not allowed: the best measured for k = {k:g} is {what}")


def expected(k: float, amplitude: float | None = 0.9, coupled: bool = False) -> list[Choice]:
    """What every fineness reaches at ``k``, the finest first: the worse of the two gradings measured next to it,
    with the margin.
    """
    measured = [m for m in table() if m.coupled == coupled]
    gradings = sorted({m.k for m in measured})
    if not gradings or not gradings[0] <= k <= gradings[-1]:
        return []
    below, above = max(g for g in gradings if g <= k), min(g for g in gradings if g >= k)
    if k < 0 <= above:  # another family: its lines say nothing here
        above = max(g for g in gradings if g < 0)
    column = "last" if amplitude is None else "error"
    choices: list[Choice] = []
    worst = 0.0
    for t in sorted({m.fineness for m in measured}):
        lines = [m for m in measured if m.fineness == t and m.k in (below, above) and isfinite(getattr(m, column))]
        if {m.k for m in lines} == {below, above}:
            worst = max(worst, *(getattr(m, column) for m in lines))  # a coarser mesh that happens to be better is luck
            mesh = family(t, k, coupled)
            error = MARGIN * beyond_measured(amplitude, k, mesh["mesh.edge_facet"]) * worst
            choices.append(Choice(t, mesh, error, max(m.seconds for m in lines)))
    return choices


def beyond_measured(amplitude: float | None, k: float, edge_facet: float) -> float:
    """Factor of errors for amplitudes beyond those measured, 0.5 and 0.9.

    Below, q is smaller, and so is what its errors are relative to: measured at 0.1, 0.2 and 0.3 they are within the
    power 1.5 where the slip zone has RESOLVED facets, within the third where it has about 6. The energy, which falls
    like the third, is known so much better than q that it does not count.
    """
    if amplitude is None:
        return 1.0
    slip = 1.0 - (1.0 - amplitude) ** (1.0 / (2.0 + k))  # over a, (48)
    power = 1.5 if slip >= RESOLVED * edge_facet else 3.0
    return max(1.0, (0.5 / amplitude) ** power, 0.1 / (1.0 - amplitude))
