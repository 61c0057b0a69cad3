"""Data of a report in SI units: quantities of a finished run, its checks, and other solutions beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import checks, comparison, critical_friction, reference, zigzag_cause
from .checks import Check
from .simulation import Simulation


@dataclass(frozen=True)
class Comparison:
    """A run beside another solution under the same loads.

    values: the other's ``a`` [m], ``peak_pressure`` [Pa], ``c_over_a``, ``dissipated_energy`` [J/m], where it has them;
    deviations: relative, of these and of the last state's fields; worst: the largest of the fields' over all states;
    own: what of them is the other solution's error, as far as it is known.
    """

    other: comparison.Reference
    words: str
    values: dict[str, float]
    deviations: dict[str, float]
    worst: dict[str, float]
    own: dict[str, float]
    without: tuple[str, ...]  # effects that the other leaves out


@dataclass(frozen=True)
class Findings:
    """What is known of a run at its end.

    exact: what has the same physics, None for the reason ``why_none``; neglecting: closed forms that leave some of the
    run's physics out, where they exist.
    """

    quantities: dict[str, float]
    checks: dict[str, Check]
    exact: Comparison | None
    why_none: str
    neglecting: Comparison | None


def find(simulation: Simulation, tell: reference.Tell | None = None) -> Findings:
    """Solve or look up what a finished simulation is compared with, and compare. On one rank.

    tell: called with the number of load steps that the reference has done, and that of all.
    """
    scene = simulation.scene
    exact, why_none = None, ""
    with simulation.watch("reference"):
        try:
            same = reference.of_same_physics(simulation, tell)
            exact = compared(simulation, same, reference.describe(same, simulation))
        except reference.NoReference as reason:
            why_none = f"none: {reason}"
        neglecting, neglected = None, reference.neglected(simulation)
        closed = reference.closed_form(simulation) if neglected and scene.reference.kind != "none" else None
        if closed:
            words = f"closed form, which neglects the {' and the '.join(neglected)} of this run: another problem"
            neglecting = compared(simulation, closed, words, tuple(neglected))
    return Findings(quantities(simulation), checked(simulation, exact), exact, why_none, neglecting)


def compared(
    simulation: Simulation, other: comparison.Reference, words: str = "", without: tuple[str, ...] = ()
) -> Comparison:
    """A finished run beside another solution; words and without: of the ``Comparison``."""
    last, worst, own = comparison.compare_all(simulation.history, other)
    values, mine = _values(simulation, other), quantities(simulation)
    coarser = _values(simulation, other.coarser) if other.coarser else values
    for name, value in values.items():
        if name not in last:
            last[name] = comparison.off(mine[name], value, comparison.own_of_number(value, coarser[name]))
    return Comparison(other, words, values, last, worst, own, without)


def _values(simulation: Simulation, other: comparison.Reference) -> dict[str, float]:
    """The ``values`` of a ``Comparison``."""
    scales, last = simulation.scaled.scales, simulation.history.entries[-1]
    found = comparison.numbers(last, other)
    values = {"a": found["a"] * scales.length}
    if not simulation.hidden_peak:
        x = last.surface.x
        if isinstance(other, comparison.OfStates):  # for k < 0 it peaks where stick ended, between nodes of the run
            x = np.append(x, other.states[last.number].x)
        values["peak_pressure"] = float(other.pressure(last, x).max()) * scales.stress
    if "c" in found:
        values["c_over_a"] = found["c"] / found["a"]
    if "dissipated_energy" in found:
        values["dissipated_energy"] = found["dissipated_energy"] * scales.energy
    return values


def checked(simulation: Simulation, exact: Comparison | None = None) -> dict[str, Check]:
    """What a finished run is checked for, its errors beside what has the same physics, if there is one, among it."""
    height = simulation.scaled.indenter.height
    found = checks.check(simulation.history, height, lambda: zigzag_cause.cause(simulation))
    if exact is None:
        return found
    return found | checked_errors(simulation, exact.other, exact.deviations | exact.worst, exact.own)


def checked_errors(
    simulation: Simulation, other: comparison.Reference, errors: dict[str, float], own: dict[str, float]
) -> dict[str, Check]:
    """What its errors beside a reference are checked for. c only in loops: elsewhere stick may have several zones."""
    last = simulation.history.entries[-1]
    stick = other.stick_half_width(last) / last.a if simulation.scene.is_loop else 0.0
    return checks.check_errors(errors, own, stick)


def summary(simulation: Simulation, findings: Findings | None, failure: str | None = None) -> dict:
    """Everything for summary.json but the versions. findings: of a run that reached its end; else ``failure``."""
    history, watch = simulation.history, simulation.watch
    found = {
        "title": simulation.scene.title,
        "converged": findings is not None,
        "checks_hold": None if findings is None else checks.hold(findings.checks),
        "failure": failure,
        "warnings": simulation.warnings,
        "effects": {name: verdict.on for name, verdict in simulation.effects.verdicts.items()},
        "increments": len(history.entries),
        "resumed": simulation.resumed,
        "newton_iterations": sum(e.iterations for e in history.entries),
        "cuts": sum(e.cuts for e in history.entries),
        "largest_residual": max((e.residual for e in history.entries), default=None),
        "largest_unsettled": max((e.unsettled for e in history.entries), default=None),
        "dofs": simulation.body.unknowns,
        "ranks": simulation.body.mesh.comm.size,
    }
    if findings:
        found |= findings.quantities
        found["checks"] = {name: vars(check) | {"holds": check.holds} for name, check in findings.checks.items()}
        critical = critical_friction.expected(simulation.scene, simulation.effects)
        found["critical_friction"] = critical_friction.numbers(critical)
        found["reference"] = findings.exact.words if findings.exact else findings.why_none
        found["errors"] = None
        found |= _deviations("errors", findings.exact, "reference_values")
        if findings.neglecting:
            found["differences_from"] = findings.neglecting.words
            found |= _deviations("differences", findings.neglecting, "differences_values")
    return found | {"seconds": watch.seconds | {"total": watch.total}}


def quantities(simulation: Simulation) -> dict[str, float]:
    """Scalars of the last state and cycle."""
    history, scales = simulation.history, simulation.scaled.scales
    last = history.entries[-1]
    found = {
        "a": last.a * scales.length,
        "a_over_a0": last.a * scales.length / simulation.scene.a0(last.step.P * scales.line_load),
        "indentation": float(last.surface.delta[1]) * scales.displacement,
        "peak_pressure": last.peak_pressure * scales.stress,
    }
    if history.friction:
        found["c_over_a"] = last.c / last.a
        found["dissipated_energy"] = history.dissipated_energy * scales.energy
    return found


def _deviations(kind: str, beside: Comparison | None, values: str) -> dict:
    """``values``: the key of the other's own numbers, which deviations with its own error in them do not give back."""
    if beside is None:
        return {}
    return {kind: beside.deviations, f"{kind}_worst_state": beside.worst, values: beside.values}
