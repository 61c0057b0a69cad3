"""Every effect on and off on one mesh density: what it costs and changes:  python -m simulations.studies.ablation.

Writes ablation.csv and ablation.md. Seconds are processor seconds of one rank after compilation, the least of several
runs; they are comparable within one table only.
"""

import time
from argparse import Namespace
from dataclasses import dataclass
from itertools import islice

import numpy as np
from mpi4py import MPI

from ..command.command import comm, on_root, run, say
from ..output.files import write_table, write_text
from ..runs.comparison import relative_l2
from ..runs.simulation import Simulation
from ..scene import DEFAULT_SCENE, SceneError, parse
from .commandline import make_folders, study_parser

REPEATS = 3
LOOP = ("solid.k=0.3", "solid.nu=0.3")
UNCOUPLED = ("effects.coupling=false",)
PRESSED = ("effects.friction=false",)


@dataclass(frozen=True)
class Case:
    """An effect with the overrides of the default scene that switch it on and off, and how far both are run."""

    effect: str
    on: tuple[str, ...]
    off: tuple[str, ...]
    increments: int | None = None


CASES = (
    Case("grading, k = 0.3", (*UNCOUPLED, *LOOP), ("effects.grading=false", *UNCOUPLED, *LOOP)),
    Case(
        "friction, normal stage (off: half of the body)",
        ("effects.friction_in_normal_stage=true", "solver.normal_increments=1", *LOOP),
        (*PRESSED, *LOOP),
        1,
    ),
    Case("both halves, no friction", ("effects.symmetry=false", *PRESSED, *LOOP), (*PRESSED, *LOOP)),
    Case("coupling", LOOP, (*UNCOUPLED, *LOOP)),
    Case("coupling at the Holl ratio", (), UNCOUPLED),
    Case("friction in normal stage", ("effects.friction_in_normal_stage=true", *LOOP), LOOP),
    Case(
        "mixed form, ν = 0.46",
        ("solid.nu=0.46", "effects.incompressibility=true"),
        ("solid.nu=0.46", "effects.incompressibility=false"),
    ),
    Case("cycle (off: stop at +Q_A)", LOOP, ("load.cycles=0", *LOOP)),
    Case("circle (off: parabola)", ("indenter.profile=circle",), ()),
    Case(
        "coating 2 a0 thick (off: power law)",
        ('solid.modulus="power-law coating"', "solid.thickness_over_a0=2", "solid.nu=0.3"),
        LOOP,
    ),
)
COLUMNS = ("effect", "switch", "unknowns", "increments", "seconds", "seconds_per_increment", "energy")
HEAD = """\
# What each effect costs and changes

`./docker/run python -m simulations.studies.ablation` on the default mesh density, facets a/40. Seconds of
processor time are per load step, with mesh, assembly and condensation shared out, without compilation; *ratio* is on
over off. *Change* compares the last states at the same places in metres: (off − on)/on of p and q in L2 over the
surface, and of the dissipated energy, that of the last cycle or, without a full cycle, of the whole run. It is a
difference of two problems; where both are the same problem (both halves, coupling at the Holl ratio, mixed form) it is
what mesh and method leave.

| effect | unknowns on / off | s per load step on / off | ratio | change in p | in q | in energy |
|---|---|---|---|---|---|---|
"""


def solve(overrides: tuple[str, ...], increments: int | None, repeats: int):
    """The finished simulation (of the first ``increments``, None: all) and its least processor seconds."""
    least = np.inf
    for _ in range(repeats):
        start = time.process_time()
        simulation = Simulation(MPI.COMM_SELF, scene_with(overrides))
        for _ in islice(simulation.run(), increments):
            pass
        least = min(least, time.process_time() - start)
    return simulation, least


def scene_with(overrides):
    """The default scene changed; without friction it has no tangential load."""
    text = DEFAULT_SCENE
    if "effects.friction=false" in overrides:
        text = "".join(line for line in text.splitlines(True) if not line.startswith(("mu", "amplitude", "cycles")))
    return parse(text, overrides)


def change(on: Simulation, off: Simulation) -> dict[str, float]:
    """Relative L2 of p and q, and of the energy, from ``on`` to ``off``; nan where one has none."""
    mine, theirs = on.history.entries[-1].surface, off.history.entries[-1].surface
    units, others = on.scaled.scales, off.scaled.scales
    x = mine.x * units.length
    found = {}
    for name in ("pressure", "traction"):
        values = getattr(mine, name) * units.stress
        other = np.interp(x, theirs.x * others.length, getattr(theirs, name) * others.stress)
        found[name] = relative_l2(mine.weight, other, values)
    energy = on.history.dissipated_energy * units.energy
    found["energy"] = off.history.dissipated_energy * others.energy / energy - 1 if energy > 0 else np.nan
    return found


def study(repeats: int) -> tuple[list[dict], str]:
    """Rows of the CSV and lines of the table, case by case."""
    rows, lines = [], ""
    for case in CASES:
        runs = {}
        for switch, overrides in (("on", case.on), ("off", case.off)):
            simulation, seconds = runs[switch] = solve(overrides, case.increments, repeats)
            n = len(simulation.history.entries)
            energy = simulation.history.dissipated_energy * simulation.scaled.scales.energy
            values = (case.effect, switch, simulation.body.unknowns, n, seconds, seconds / n, energy)
            rows.append(dict(zip(COLUMNS, values)))
        on, off = rows[-2:]
        delta = change(runs["on"][0], runs["off"][0])
        ratio = on["seconds_per_increment"] / off["seconds_per_increment"]
        lines += f"| {case.effect} | {on['unknowns']} / {off['unknowns']} "
        lines += f"| {on['seconds_per_increment']:.2f} / {off['seconds_per_increment']:.2f} | {ratio:.2f} "
        lines += "".join(f"| {'–' if np.isnan(value) else f'{value:.1e}'} " for value in delta.values()) + "|\n"
        say(lines.splitlines()[-1])
    return rows, lines


def main(arguments: list[str]):
    """Run the study and write its two files; more ranks than one have nothing to do."""
    given = on_root(lambda: read(arguments))
    if comm.rank > 0:
        return
    for case in CASES:  # compile
        for overrides in (case.on, case.off):
            Simulation(MPI.COMM_SELF, scene_with(overrides))
    rows, lines = study(given.repeats)
    write_table(given.output / "ablation.csv", rows)
    write_text(given.page, HEAD + lines)
    say(f"written: {given.output / 'ablation.csv'}, {given.page}")


def read(arguments: list[str]) -> Namespace:
    """The checked command line; SceneError where it is wrong."""
    parser = study_parser("ablation", __doc__, "results/ablation", "the table (default: DIR/ablation.md)")
    parser.add_argument("--repeats", type=int, default=REPEATS, help="runs of which the quickest counts")
    given = parser.parse_args(arguments)
    if given.repeats < 1:
        raise SceneError(f"--repeats {given.repeats} is not allowed: an integer ≥ 1")
    return make_folders(given, "ablation.md")


if __name__ == "__main__":
    run(main)
