"""What is tried, in this order, when Newton's method does not find the state at the end of a load step.

Each way of solving starts from the state before the step. The answer of every one is that of Coulomb's law as it is:
the safeguards only change how it is reached.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from ..fem.contact_problem import ContactProblem, X, Y
from ..fem.load import Load
from ..solvers.newton import Newton, NewtonResult
from .pinning import PinnedPoint


@dataclass(frozen=True)
class Options:
    """Limits of the load stepping.

    halvings: of a load step, one within the other; sweeps: of the fixed point; anchor_passes: solves for the anchors
    of points that enter contact, which are settled once they change by less than ``anchors_settled`` of how far they
    moved, in uncoupled contact, where they are exact, ``anchors_settled_uncoupled``; fallbacks: names of those that
    are allowed; confirm: one more Newton iteration after the last, to see whether contact states still change.
    """

    halvings: int = 6
    sweeps: int = 60
    anchor_passes: int = 8
    anchors_settled: float = 1e-3
    anchors_settled_uncoupled: float = 1e-5
    fallbacks: tuple[str, ...] = ("jumping Newton", "Newton", "guarded Newton", "fixed point")
    confirm: bool = False


@dataclass(frozen=True)
class Fallback:
    """A way of solving a load step: when it is tried, how it works, and why that helps.

    applies: to a problem; solve: from the Newton solver, the load and the options to all results, of which the last
    counts.
    """

    name: str
    when: str
    how: str
    reason: str
    applies: Callable[[ContactProblem], bool]
    solve: Callable[[Newton, Load, Options], list[NewtonResult]]

    def __str__(self):
        return f"{self.name}: {self.how}, {self.when}; {self.reason}"


def jumping_newton(newton: Newton, load: Load, options: Options) -> list[NewtonResult]:
    """Newton's method with jumps of edges, from the nearest state that is known."""
    start = {}
    if not newton.has_solved(load):  # else the state is that of other anchors
        start = {"extrapolate" if newton.last_steps.ahead(load) else "predict": True}
    return [newton.solve(load, jump=True, confirm=options.confirm, **start)]


def newton_as_it_is(newton: Newton, load: Load, options: Options) -> list[NewtonResult]:
    """Newton's method, with friction after a step in which every point in contact sticks."""
    return [newton.solve(load, predict=newton.system.problem.friction, confirm=options.confirm)]


def guarded_newton(newton: Newton, load: Load, options: Options) -> list[NewtonResult]:
    """Newton's method with restrained changes of the contact states, then without restraint to confirm."""
    with restrained(newton):
        guarded = newton.solve(load, predict=True)
    if not guarded.converged:
        return [guarded]
    return [guarded, newton.solve(load, confirm=options.confirm)]


def fixed_point(newton: Newton, load: Load, options: Options) -> list[NewtonResult]:
    """Friction limited by the last sweep's pressure, sweep after sweep until that is the present one.

    Each sweep is the tangent of a convex minimum, on which Newton does not cycle; the sweeps contract by about mu
    times the coupling.
    """
    results: list[NewtonResult] = []
    for sweep in range(options.sweeps):
        with newton.system.problem.safeguards.lagged_pressure():
            results.append(newton.solve(load, predict=sweep == 0))
        if not results[-1].converged:
            results[-1] = replace(results[-1], reason=f"in a fixed-point sweep, {results[-1].reason}")
            return results
        balance = newton.balance(load)
        if balance.converged:
            break
    return [*results, balance]


@contextmanager
def restrained(newton: Newton) -> Iterator[None]:
    """Meanwhile no point turns from sliding one way to sliding the other without sticking in between, and one point
    is pinned where all would slide.
    """
    problem = newton.system.problem
    pinned = PinnedPoint(problem)
    newton.after_linearise, newton.after_residual = problem.safeguards.note_sliding, pinned.update
    try:
        yield
    finally:
        newton.after_linearise, newton.after_residual = lambda: None, lambda: False
        problem.safeguards.forget()


FALLBACKS = (
    Fallback(
        "jumping Newton",
        "first",
        "semismooth Newton with full steps and jumps of edges, from the line through the last two states; where "
        "the load turns, from a step in which all points stick",
        "edges move on nearly as they did, and the active set alone would creep to them",
        lambda problem: problem.friction,
        jumping_newton,
    ),
    Fallback(
        "Newton",
        "otherwise",
        "semismooth Newton with full steps, from a step in which all points in contact stick",
        "it ends after a few iterations wherever the contact states settle",
        lambda problem: True,
        newton_as_it_is,
    ),
    Fallback(
        "guarded Newton",
        "where Newton cycles or its tangent is singular",
        "no point turns round without sticking in between, and one is pinned where all would slide",
        "contact states that keep changing settle, and the indenter is never free to move",
        lambda problem: problem.friction,
        guarded_newton,
    ),
    Fallback(
        "fixed point",
        "where guarded Newton fails too, with coupling",
        "friction limited by the last sweep's pressure, until that no longer changes",
        "with a known limit each sweep is a convex minimum",
        lambda problem: problem.directions == (X, Y),
        fixed_point,
    ),
)
HALVING = "halving: two steps of half the load, one after the other, where all of these fail"


def explained(problem: ContactProblem) -> list[str]:
    """What is tried for a problem, one line each."""
    return [str(fallback) for fallback in FALLBACKS if fallback.applies(problem)] + [HALVING]
