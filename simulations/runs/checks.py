"""Checks of a converged run: balance, contact conditions, no zigzags, no large error.

Each check is a number and the limit that it must not pass. Ordinary runs have them in summary.json.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from ..fem.surface import SurfaceState
from ..solvers.newton import ATTAINABLE, FORCE_TOLERANCE
from .history import Entry, History

# a run is wrong beyond these; of c over a
ERRORS = {"pressure_l2": 0.1, "traction_l2": 0.1, "a": 0.05, "c": 0.05, "dissipated_energy": 0.05}
PENETRATION = 1e-3  # an open point is held by its traction, which is not quite zero
WRONG_SLIP = 1e-4  # of loops measured below 1e-6
ZIGZAGS = 0.05  # of the range; loops at k = 0.3 have less than 0.003, the coupled one at k = -0.5 on coarse facets 0.04
BENT = 0.1  # of the range of u_y, which is about f(a) under a round indenter
AT_REST = 1e-3  # motion over the largest below which a load step moves nothing
FEW = 20  # nodes of a contact that is not smooth on its mesh
MORE_STEPS = "more solver.increments or, with friction from first contact, solver.normal_increments"
LARGE = (
    f"{MORE_STEPS} (first of all for the energy), a higher mesh.degree, finer facets (mesh.facet, mesh.edge_facet) or "
    "a smaller mesh.layer_growth make errors smaller"
)
UNKNOWN = f"the reference's own error is {{:.0%}}, which is too much to judge by; {MORE_STEPS} make it smaller"
AGAINST = (
    "slip goes against q most in load step {}, increment {} of history.csv: where points stop within it may be known "
    "too badly; another number of solver.{} changes that"
)
LOST = "so many states touch at too few nodes to have a half-width: a smaller mesh.facet or mesh.edge_facet may help"


class ChecksFailed(RuntimeError):
    """A run reached its end, but its results do not pass their checks; the message names those."""


class ChecksWarning(UserWarning):
    """The same as a warning, for the package from Python."""


@dataclass(frozen=True)
class Check:
    """A number that is to stay at or below its limit; cause: of it where it does not, as far as it is known."""

    value: float
    limit: float
    cause: str = ""

    @property
    def holds(self) -> bool:
        """False for nan too."""
        return bool(self.value <= self.limit)


def check(history: History, height: Callable, cause: Callable[[], str] | None = None) -> dict[str, Check]:
    """Checks of a run that ended. height: the indenter's f(x), in the history's units.

    cause: tells why tractions zigzag; it is asked only where they do.
    """
    entries = history.entries
    tolerance = max(entry.tolerance for entry in entries)
    lost = float(sum(np.isnan(entry.a) for entry in entries if entry.step.state or entry is entries[-1]))
    checks = {
        "residual": Check(largest(entry.residual for entry in entries), ATTAINABLE),
        # tractions read off the fields: Newton's tolerance, and once more the round-off that makes it
        "load balance": Check(largest(map(imbalance, entries)), 10 * tolerance),
        "p >= 0": Check(largest(map(tension, entries)), 0.0),
        "gap >= 0": Check(largest(penetration(entry.surface, height) for entry in entries), PENETRATION),
        "pressure zigzags": Check(largest(zigzags(entry.surface.pressure) for entry in entries), ZIGZAGS),
        "contact has a width": Check(lost, 0.0, LOST if lost else ""),
    }
    if history.friction:
        loaded = [entry.surface for entry in entries if np.any(entry.surface.traction)]
        pairs = [(a.surface, b.surface) for a, b in zip(entries, entries[1:])]
        reach = largest(largest_motion(a, b) for a, b in pairs if np.any(b.traction))
        wrong = [wrong_slip(a, b, reach) for a, b in pairs]
        checks |= {
            "|q| <= mu p": Check(largest(map(excess, loaded)), 10 * max(tolerance, FORCE_TOLERANCE)),
            "energy >= 0": Check(max(-history.dissipated_energy, 0.0), 0.0),
            "slip against q": Check(largest(wrong), WRONG_SLIP),
            "traction zigzags": Check(largest(map(traction_zigzags, loaded)), ZIGZAGS),
        }
        if not checks["slip against q"].holds:
            number = np.argmax(wrong) + 1
            key = "normal_increments" if entries[number].step.branch == "normal" else "increments"
            words = AGAINST.format(number + 1, number, key)
            checks["slip against q"] = replace(checks["slip against q"], cause=words)
    zigzagging = [name for name in checks if name.endswith("zigzags") and not checks[name].holds]
    if zigzagging and cause:
        checks[zigzagging[-1]] = replace(checks[zigzagging[-1]], cause=cause())
    return checks


def check_errors(errors: dict[str, float], own: dict[str, float], stick: float = 0.0) -> dict[str, Check]:
    """Checks of a run's errors beside its reference, by the names of ``comparison.compare``; nan is not known.

    stick: c/a of the reference, as the error of c is judged over a: a narrow stick zone spoils no more than c. Where c
    is nan the run has no stick zone, as if c were 0; stick = 0: c is not judged.
    own: the reference's part of these errors. It may have made them as much larger again, so twice this part is
    excused, but no more than twice the limit: a reference that is known less well does not judge the run.
    """
    scaled = errors | {"c": stick * float(np.nan_to_num(errors["c"], nan=-1.0)) if stick else np.nan}
    own = own | {"c": stick * own.get("c", 0.0)}
    known = {name: abs(scaled[name]) for name in ERRORS if not np.isnan(scaled.get(name, np.nan))}
    excused = {name: 2 * min(own.get(name, 0.0), ERRORS[name]) for name in known}
    found = {name: Check(max(error - excused[name], 0.0), ERRORS[name]) for name, error in known.items()}
    failing = [name for name in found if not found[name].holds]
    judged = [name for name in failing if own.get(name, 0.0) <= ERRORS[name]]
    for name in (judged or failing)[:1]:
        found[name] = replace(found[name], cause=LARGE if judged else UNKNOWN.format(own[name]))
    return {f"error of {name.removesuffix('_l2')}": check for name, check in found.items()}


def hold(checks: dict[str, Check]) -> bool:
    """True where all of them hold."""
    return all(check.holds for check in checks.values())


def describe(checks: dict[str, Check]) -> str:
    """One line: that all hold, or which do not."""
    failing = [f"{name} ({c.value:.1e}, limit {c.limit:.0e})" for name, c in checks.items() if not c.holds]
    causes = "".join(f"; {c.cause}" for c in checks.values() if c.cause)
    return f"checks that fail: {', '.join(failing)}{causes}" if failing else f"all {len(checks)} checks hold"


def largest(values: Iterable[float]) -> float:
    """The largest of numbers >= 0, nan where one is, which the built-in ``max`` may pass over; 0 without any."""
    return float(np.max([*values], initial=0.0))


def imbalance(entry: Entry) -> float:
    """Largest difference of the integrated tractions from the loads, over P."""
    (P, Q), step = entry.carried, entry.step
    return largest((abs(P - step.P), abs(Q - step.Q))) / step.P


def tension(entry: Entry) -> float:
    """Most negative pressure over the largest."""
    pressure = entry.surface.pressure
    return -min(pressure.min(), 0.0) / pressure.max()


def penetration(surface: SurfaceState, height: Callable) -> float:
    """Deepest overlap outside the contact over its depth: f(a), or how far the surface bends where f is flat."""
    gap = height(surface.x) + surface.approach
    open_nodes = surface.pressure <= 0
    reach = np.abs(surface.x[~open_nodes]).max()
    depth = max(float(height(reach)), BENT * np.ptp(surface.u[1]))
    return float(max(-gap[open_nodes].min(initial=0.0), 0.0) / depth)


def excess(surface: SurfaceState) -> float:
    """Largest |q| - mu p over the largest mu p."""
    return float(max((np.abs(surface.traction) - surface.limit).max(), 0.0) / surface.limit.max())


def largest_motion(before: SurfaceState, after: SurfaceState) -> float:
    """Largest change of u_x - delta_x in contact."""
    moved = after.relative_displacement - before.relative_displacement
    return float(np.abs(moved[after.pressure > 0]).max(initial=0.0))


def wrong_slip(before: SurfaceState, after: SurfaceState, reach: float = 0.0) -> float:
    """Work that friction does on points that slide along with it in a load step, relative to the largest possible one.

    The latter is that of the limit mu p and the largest motion at every point. A point sliding by less than Nitsche's
    method moves one that sticks may go the wrong way. reach: the largest motion of any step; one in which nothing
    moves, as at a dwell, shows round-off only and is measured by AT_REST of that.
    """
    moved = after.relative_displacement - before.relative_displacement
    touches = (before.pressure > 0) & (after.pressure > 0)  # of points that enter contact only a part is slip
    work = np.where((after.slides != 0) & touches, -after.weight * after.traction * moved, 0.0)
    most = after.line_load(after.limit) * max(largest_motion(before, after), AT_REST * reach)
    return float(-work[work < 0].sum() / most) if most else 0.0


def zigzags(values, scale: float = 0.0) -> float:
    """Total variation of nodal values that go up, down and up again from node to node, over their range or ``scale``.

    A smooth field has none, nor has a peak or a kink: it turns once. A contact of fewer than FEW nodes is not judged.
    """
    if np.count_nonzero(values) < FEW:
        return 0.0
    steps = np.diff(values)
    a, b, c = steps[:-2], steps[1:-1], steps[2:]
    in_turn = (a * b < 0) & (b * c < 0)
    return float(np.minimum(np.minimum(np.abs(a), np.abs(b)), np.abs(c))[in_turn].sum() / max(np.ptp(values), scale))


def traction_zigzags(surface: SurfaceState) -> float:
    """Those of q over its range, or that of mu p where this is larger."""
    return zigzags(surface.traction, surface.mu * np.ptp(surface.pressure))


def largest_zigzag(surface: SurfaceState) -> float:
    """The larger one of those of p and q."""
    return max(zigzags(surface.pressure), traction_zigzags(surface))


def drift(history: History) -> float:
    """Largest change of p and q from the end of one cycle to that of the next, over the largest p."""
    ends = [e for e in history.entries if e.step.state == "A" and e.step.cycle > 0]
    fields = [(entry.surface.pressure, entry.surface.traction) for entry in ends]
    return largest(np.abs(np.diff(fields, axis=0)).ravel()) / float(fields[-1][0].max())
