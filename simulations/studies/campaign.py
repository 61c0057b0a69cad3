"""Stated errors beside true ones, at every state of random scenes:  python -m simulations.studies.campaign.

What a run states is its deviation from its own reference. The truth is another solution, or a much finer one, and is
known to the deviation between two resolutions of it. The scenes are a seeded draw; under mpirun the ranks share them,
and a study that was stopped goes on where it was.
"""

from argparse import Namespace
from collections.abc import Iterable

import numpy as np
from mpi4py import MPI

from ..command.command import comm, on_root, run, say
from ..loading.stepping import SolveError
from ..output import style
from ..output.files import write_table, write_text
from ..runs.closed_forms import Springs
from ..runs.comparison import NoReference, Reference, apart, compare, compare_state
from ..runs.history import all_states
from ..runs.mesh_free import NODES, MeshFree, steps_for_one
from ..runs.reference import of_same_physics
from ..runs.simulation import Simulation
from ..runs.step_free import StepFree
from ..scene import SceneError, make_scene
from .commandline import asked_for, make_folders, study_parser
from .engine import FAILED, Item, run_on
from .store import Store

KINDS = ("uncoupled loop", "coupled loop", "path of P and Q", "nested loops", "friction from first contact")
KEPT = "scenes.jsonl"  # what is solved
SEED = 20261122  # of the draw
ORDERS = 8, 12  # of the basis of the solver without load steps, which as a reference has 10
RESOLUTIONS = (1.125, 1.5), (1.5, 2.0)  # nodes and load steps, over those of this solver as a reference
FEWER = 0.95  # of the nodes, for a second try: nodes elsewhere may end changes between contact and gap
KNOWN = 1 / 3  # of the larger of both errors: a truth that is known less well judges nothing
SHORT = 0.5  # of the true error: what is stated must not be smaller
ENERGY = "dissipated_energy"
NAMES = {"pressure_l2": "p", "traction_l2": "q", "slip_l2": "slip", ENERGY: "energy"}
P, MESH = 1e6, {"mesh.facet": 0.05, "mesh.growth": 1.4, "mesh.layer_growth": 1.4}


def drawn(count: int, kinds: Iterable[str] = KINDS) -> dict[str, dict]:
    """Keys of the first ``count`` scenes of the draw by name, those of these kinds. The kinds follow in turn."""
    random, scenes = np.random.default_rng(SEED), {}
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        values = _scene(kind, random)
        if kind in kinds:
            scenes[f"{number + 1} {kind}"] = values
    return scenes


def _scene(kind: str, random: np.random.Generator) -> dict:
    def between(low, high):
        return round(float(random.uniform(low, high)), 3)

    k, mu = between(-0.7, 0.95), float(f"{np.exp(random.uniform(np.log(0.01), 0.0)):.3g}")
    edge = 4e-3 if k > -0.3 else 1e-3
    scene = {"solid.E0": 210e9, "solid.k": k, "solid.nu": between(-0.5, 0.5), "solid.y0_over_a0": 10.0}
    scene |= {"indenter.R": 0.1, "load.mu": mu, "mesh.edge_facet": edge, "mesh.first_layer": edge, **MESH}
    scene["effects.coupling"] = kind != KINDS[0] and (kind in (KINDS[1], KINDS[4]) or bool(random.random() < 0.5))
    scene["solver.increments"] = 1 if kind in KINDS[2:4] else int(random.integers(2, 4))
    if kind == "path of P and Q":
        loads = [(between(0.2, 1.0), 0.0 if i == 0 else between(-0.9, 0.9)) for i in range(4)]
    elif kind == "nested loops":
        shares = [0.0, between(0.6, 0.95)]
        for _ in range(4):  # each turn lies between the two before it, the last leaves both inner loops
            shares.append(round(shares[-1] + between(0.3, 0.9) * (shares[-2] - shares[-1]), 3))
        loads = [(1.0, share) for share in [*shares, shares[1]]]
    else:
        cycles = 0 if kind == "friction from first contact" else 1
        scene |= {"load.P": P, "load.amplitude": between(0.2, 0.95), "load.cycles": cycles}
        if kind == "friction from first contact":
            scene |= {"effects.friction_in_normal_stage": True, "solver.normal_increments": int(random.integers(3, 6))}
        return scene
    return scene | {"load.points": [[P * load, float(f"{P * load * share * mu:.6g}")] for load, share in loads]}


def solve(values: dict) -> dict:
    """One scene: ``states``, a list of rows of ``judged``, with the names of reference and truth.

    Where one of the three fails, ``missing`` names it and ``why`` says why: without a truth the run may be right.
    """
    missing = "run"
    try:
        simulation = Simulation(MPI.COMM_SELF, make_scene(values, base=None)).run_to_end()
        missing = "reference"
        reference = of_same_physics(simulation)
        missing = "truth"
        coarse, fine = truths(simulation, reference)
    except (SceneError, SolveError, NoReference) as reason:
        return {"missing": missing, "why": str(reason)}
    return {"reference": reference.name, "truth": fine.name, "states": judged(simulation, reference, coarse, fine)}


def truths(simulation: Simulation, reference: Reference) -> tuple[Reference, Reference]:
    """The truth at two resolutions, the finer one last; the springs, which are exact, are their own."""
    if isinstance(reference, Springs):
        return reference, reference
    if simulation.scene.is_loop:
        try:
            coarse, fine = (StepFree(simulation, order) for order in ORDERS)
            return coarse, fine
        except NoReference:  # the other solver may
            pass
    nodes, steps = NODES[0], steps_for_one(simulation)
    if isinstance(reference, MeshFree) and not reference.since_turn:  # it may have taken more load steps
        nodes, steps = reference.nodes, reference.finer
    coarse, fine = (_mesh_free(simulation, round(n * nodes), round(more * steps)) for n, more in RESOLUTIONS)
    return coarse, fine


def _mesh_free(simulation, nodes, steps):
    return MeshFree(simulation, nodes=(nodes, round(FEWER * nodes)), finer=steps)


def judged(simulation: Simulation, reference: Reference, coarse: Reference, fine: Reference) -> list[dict]:
    """Rows of state and quantity: error ``stated``, ``true`` error, and how far apart both truths are (``doubt``)."""
    rows, history = [], simulation.history

    def keep(entry, name, *errors):
        if np.isfinite(errors).all():
            load = {"P": entry.step.P, "Q_over_muP": entry.step.Q / simulation.mu / entry.step.P}
            found = dict(zip(("stated", "true", "doubt"), map(abs, errors), strict=True))
            rows.append({"state": entry.number, **load, "quantity": NAMES[name], **found})

    for entry in all_states(history):
        stated, true = compare_state(entry, reference), compare_state(entry, fine)
        doubt = apart(entry, coarse, fine)
        for name in stated:
            keep(entry, name, stated[name], true[name], doubt[name])
    if energy := fine.dissipated_energy():
        stated, other = compare(history, reference).get(ENERGY, np.nan), coarse.dissipated_energy() or 0.0
        keep(history.entries[-1], ENERGY, stated, history.dissipated_energy / energy - 1, other / energy - 1)
    return rows


def verdict(row: dict) -> str:
    """What a row says of what is stated."""
    if row["doubt"] > KNOWN * max(row["stated"], row["true"]):
        return "truth not known"
    return "too small" if row["stated"] < SHORT * row["true"] else "holds"


def flat(scenes: dict[str, dict], found: list[dict]) -> list[dict]:
    """Rows of the CSV file: one a state (P over the largest) and quantity, and one a scene that has none."""
    rows = []
    for (name, values), row in zip(scenes.items(), found, strict=True):
        number, _, kind = name.partition(" ")
        head = {"scene": number, "kind": kind, "coupling": values["effects.coupling"]}
        head |= {key.partition(".")[2]: values[key] for key in ("solid.k", "solid.nu", "load.mu")}
        for state in row.get("states", ()):
            load = {"P": f"{state['P']:.3g}", "Q_over_muP": f"{state['Q_over_muP']:.3g}"}
            errors = {error: f"{state[error]:.2e}" for error in ("stated", "true", "doubt")}
            rows.append(head | state | load | errors | {"verdict": verdict(state)})
        if "states" not in row:
            missing, why = row.get("missing", "run, reference or truth"), row.get("why", row.get(FAILED, ""))
            rows.append(head | {"verdict": f"no {missing}: {why}"})
    return rows


def table(scenes: dict[str, dict], found: list[dict]) -> str:
    """Markdown: a row a kind of scene and quantity."""
    lines = ["| scenes | judged | quantity | values | known | stated < true/2 | smallest stated/true | largest true |"]
    lines.append("|---|---|---|---:|---:|---:|---:|---:|")
    for kind in KINDS:
        mine = [row for name, row in zip(scenes, found, strict=True) if name.partition(" ")[2] == kind]
        ran = [row for row in mine if "states" in row]
        for quantity in NAMES.values():
            states = [state for row in ran for state in row["states"] if state["quantity"] == quantity]
            known = [state for state in states if verdict(state) != "truth not known"]
            if not states:
                continue
            short = sum(verdict(state) == "too small" for state in known)
            ratio = min((state["stated"] / max(state["true"], 1e-300) for state in known), default=np.nan)
            largest = max((state["true"] for state in known), default=np.nan)
            numbers = f"{len(states)} | {len(known)} | {short} | {ratio:.2f} | {largest:.1e}"
            lines.append(f"| {kind} | {len(ran)} of {len(mine)} | {quantity} | {numbers} |")
    return "\n".join(lines) + "\n"


def draw(folder, found: list[dict]):
    """Stated errors over true ones, where the truth is known."""
    known = [s for row in found for s in row.get("states", ()) if verdict(s) != "truth not known"]
    note = "every state of every scene where the truth is known to a third of the larger of both errors"
    with style.style():
        figure, axes = style.panels(1, "Stated and true errors of random scenes", note, width=6.4, height=5.4)
        axis = axes[0, 0]
        for quantity, colour, marker in zip(NAMES.values(), style.COLOURS, style.MARKERS):
            points = np.array([(s["stated"], s["true"]) for s in known if s["quantity"] == quantity])
            if len(points):
                axis.loglog(*points.T, marker, color=colour, ms=4, alpha=0.5, ls="", label=quantity)
        ends = np.array(axis.get_xlim())
        axis.loglog(ends, ends, color=style.BLACK, lw=1, label="true = stated")
        axis.loglog(ends, ends / SHORT, color=style.BLACK, lw=1, ls="--", label="true = 2 · stated")
        axis.set(xlabel="stated error [–]", ylabel="true error [–]")
        axis.legend()
        style.save(figure, folder, "campaign")


def main(arguments: list[str]):
    """Solve what is not yet solved, then write table and figure of all."""
    given, items = on_root(lambda: read(arguments))
    found = run_on(comm, items, solve, Store(given.output / KEPT), say)
    if found is None:
        return
    scenes = {item.name: item.values for item in items}
    write_table(given.output / "campaign.csv", flat(scenes, found))
    write_text(given.page, table(scenes, found))
    draw(given.output, found)
    say(f"written to {given.output}: campaign.csv, campaign.png; {given.page}")


def read(arguments: list[str]) -> tuple[Namespace, list[Item]]:
    """The checked command line and its scenes; SceneError where it is wrong."""
    parser = study_parser("campaign", __doc__, "results/campaign", "the table (default: DIR/campaign.md)")
    parser.add_argument("--drawn", type=int, default=200, metavar="N", help="scenes of the draw (200)")
    parser.add_argument("--only", nargs="+", default=KINDS, choices=KINDS, metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--stored", action="store_true", help="table and figure of what is solved already")
    given = parser.parse_args(arguments)
    if given.drawn < 1:
        raise SceneError(f"--drawn {given.drawn} is not allowed: an integer ≥ 1")
    items = [Item(name, values) for name, values in drawn(given.drawn, given.only).items()]
    items = asked_for(given, items, KEPT)
    make_folders(given, "campaign.md")
    return given, items


if __name__ == "__main__":
    run(main)
