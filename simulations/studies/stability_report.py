"""Table and picture of the hard cases."""

from collections import Counter
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..output import style
from ..scene.text import table_row

GREEN, REFUSED, FAILING, FAILED = "green", "refused", "checks fail", "no answer"
UNJUDGED, WRONG = "not judged", "wrong"
OUTCOMES = {  # how a case may end: its colour and marker, and what it means
    GREEN: (style.GREEN, "o", "converged, all checks hold"),
    REFUSED: (style.ORANGE, "s", "refused before the solve"),
    FAILING: (style.PURPLE, "v", "converged, but checks fail, and the run says so"),
    FAILED: (style.BLUE, "^", "without an answer"),
    UNJUDGED: (style.GREY, "D", "off a reference that is known worse than the limit"),
    WRONG: (style.RED, "X", "off the reference though all checks hold"),
}
HELPS = "may help"  # ends the causes of checks that fail and have an action
ACTIONS = {  # of what fails after the solve, where no cause tells it; the first that fits
    "slip against q": "solver.theta = 0 or a larger solver.gamma0",
    "zigzags": "effects.elastic_slip or another number of solver.increments",
    "energy balance": "a larger mesh.first_layer or solver.gamma0 = 10, for less round-off",
    "residual": "a larger mesh.first_layer or solver.gamma0 = 10, for less round-off",
    "load balance": "a larger mesh.first_layer or solver.gamma0 = 10, for less round-off",
    "": "a finer mesh: mesh.facet, mesh.edge_facet, mesh.first_layer",
}


def by_study(rows: list[dict]) -> dict[str, list[dict]]:
    """Rows by the name of their study."""
    studies: dict[str, list[dict]] = {}
    for row in rows:
        studies.setdefault(row["name"].partition(":")[0], []).append(row)
    return studies


def summary(rows: list[dict]) -> str:
    """One line: how many ended how."""
    count = Counter(row["outcome"] for row in rows)
    compared = sum(any(name.startswith("error ") for name in row) for row in rows)
    ends = ", ".join(f"{count[o]} {meaning} ({count[o] / len(rows):.1%})" for o, (*_, meaning) in OUTCOMES.items())
    return f"{len(rows)} cases: {ends}; {compared} of them beside a reference"


def table(rows: list[dict]) -> str:
    """Markdown: a row a study, then every case that is not green."""
    heads = ("study", "cases", *OUTCOMES, "iterations an increment", "cuts", "p", "q", "energy")
    lines = [summary(rows), "", f"| {' | '.join(heads)} |", "|---|" + "---:|" * (len(heads) - 1)]
    for name, cases in by_study(rows).items():
        count = Counter(case["outcome"] for case in cases)
        solved = [case for case in cases if "iterations" in case]
        mean = sum(c["iterations"] for c in solved) / max(sum(c["increments"] for c in solved), 1)
        worst = [_largest(solved, f"error {error}") for error in ("pressure_l2", "traction_l2", "dissipated_energy")]
        cuts = sum(case["cuts"] for case in solved)
        numbers = [len(cases), *(count[outcome] for outcome in OUTCOMES), f"{mean:.1f}", cuts, *worst]
        lines.append(f"| {name} | " + " | ".join(map(str, numbers)) + " |")
    lines += ["", "| not green | how it ended | why | friction beside the critical one | what a user can do |"]
    lines.append("|---|---|---|---|---|")
    for row in rows:
        if row["outcome"] != GREEN:
            lines.append(table_row((row["name"], row["outcome"], row["why"], row.get("friction", ""), action(row))))
    return "\n".join(lines) + "\n"


def action(row: dict) -> str:
    """What a user can do about a case that is not green."""
    why = row["why"]
    if row["outcome"] == FAILED:
        return (
            "effects.elastic_slip, a coarser mesh.edge_facet or more solver.increments; "
            "with solver.theta ≠ 0 a larger solver.gamma0"
        )
    if row["outcome"] == REFUSED:
        return "the value that the reason names"
    if row["outcome"] in (UNJUDGED, WRONG):
        return why.rpartition("; ")[2]
    if why.endswith(HELPS):
        return why.rpartition(": ")[2].removesuffix(HELPS).strip()
    return next(what for name, what in ACTIONS.items() if name in why)


def _largest(cases, name):
    values = [abs(case[name]) for case in cases if name in case and case["outcome"] == GREEN]
    return f"{max(values):.1e}" if values else "–"


@style.style()
def picture(path: Path, rows: list[dict]):
    """PNG: a row of dots a study, one a case, by how it ended; and the iterations that a load step took."""
    studies = by_study(rows)
    height = 0.28 * len(studies) + 1.6
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11, height), sharey=True, layout="constrained", width_ratios=(3, 2)
    )
    for place, cases in enumerate(studies.values()):
        for number, case in enumerate(cases):
            colour, marker, _ = OUTCOMES[case["outcome"]]
            left.plot(number + 1, place, marker, color=colour, ms=6)
            if "iterations" in case:
                mean = case["iterations"] / case["increments"]
                right.plot(mean, place, marker, color=colour, ms=5, alpha=0.6)
    for outcome, (colour, marker, meaning) in OUTCOMES.items():
        count = sum(row["outcome"] == outcome for row in rows)
        left.plot(np.nan, np.nan, marker, color=colour, label=f"{meaning}: {count}")
    left.set_yticks(range(len(studies)), studies)
    left.invert_yaxis()
    left.set(xlabel="case of the study [–]", title="How each case ended")
    right.set(xlabel="Newton iterations per increment [–]", title="What it took", xscale="log")
    left.grid(False)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=9)
    style.save(figure, path.parent, path.stem, ("png",))
