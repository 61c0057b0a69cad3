"""The results of a run as a table for reading: each value beside the reference's and its own error."""

from ..runs import checks
from ..runs.report_data import Comparison, Findings

ROWS = {
    "a": "contact half-width a [m]",
    "peak_pressure": "peak pressure [Pa]",
    "indentation": "indentation [m]",
    "c_over_a": "stick half-width c/a [-]",
    "dissipated_energy": "dissipated energy [J/m]",
}
FIELDS = ("pressure", "traction", "slip")


def table(findings: Findings, has_cycle: bool) -> str:
    """The table, with what it was compared with and whether the checks hold."""
    names = ROWS | ({"dissipated_energy": "energy per cycle [J/m]"} if has_cycle else {})
    lines = _rows(findings, names, findings.exact, "error")
    exact = findings.exact
    unknown = f"errors are not known: {findings.why_none.removeprefix('none: ')}"
    lines.append(f"reference: {exact.words}" if exact else unknown)
    own = {name: exact.own.get(f"{name}_l2", 0.0) for name in FIELDS} if exact else {}
    if any(own.values()):
        lines.append("of the worst errors its own: " + ", ".join(f"{name} {size:.1e}" for name, size in own.items()))
    if findings.neglecting:
        lines += ["", *_rows(findings, names, findings.neglecting, "difference")]
        lines.append(f"differences from the {findings.neglecting.words}")
    failing = sum(not check.holds for check in findings.checks.values())  # which ones, the last line of the run says
    lines.append(f"{failing} of {len(findings.checks)} checks fail" if failing else checks.describe(findings.checks))
    return "\n".join(lines)


def _rows(findings: Findings, names, beside: Comparison | None, kind: str) -> list[str]:
    if beside is None:
        return [f"{'':28s}{'computed':>16s}"] + [
            f"{name:28s}{findings.quantities[key]:16.8g}" for key, name in names.items() if key in findings.quantities
        ]
    width = max(len(beside.other.name) + 2, 17)
    lines = [f"{'':28s}{'computed':>16s}{beside.other.name:>{width}s}{'relative ' + kind:>21s}"]
    for key, name in names.items():
        if key in beside.values:
            theirs, own = beside.values[key], beside.deviations[key]
            lines.append(f"{name:28s}{findings.quantities[key]:16.8g}{theirs:{width}.8g}{own:21.1e}")
        elif key in findings.quantities:
            lines.append(f"{name:28s}{findings.quantities[key]:16.8g}")
    lines.append(f"{'L2 over the contact':{44 + width - 17}s}{'last state':>17s}{'worst state':>21s}")
    for name in FIELDS:
        if f"{name}_l2" in beside.deviations:
            last, worst = (found[f"{name}_l2"] for found in (beside.deviations, beside.worst))
            lines.append(f"{name:{44 + width - 17}s}{last:17.1e}{worst:21.1e}")
    return lines
