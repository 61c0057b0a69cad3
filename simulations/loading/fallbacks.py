"""What is tried, in this order, when Newton's method does not find the state at the end of a load step.

Each way of solving starts from the state before the step. The answer of every one is that of Coulomb's law as it is:
the safeguards only change how it is reached.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..fem.contact_problem import ContactProblem
from ..fem.load import Load
from ..solvers.newton import Newton, NewtonResult


@dataclass(frozen=True)
class Limits:
    """Limits of the load stepping.

    halvings: of a load step, one within the other; anchor_passes: solves for the anchors of points that enter contact.
    They are settled once they change by less than ``anchors_settled`` of how far they moved; in uncoupled contact,
    where they are exact, by less than ``anchors_settled_uncoupled``.
    """

    halvings: int = 6
    anchor_passes: int = 12
    anchors_settled: float = 1e-3
    anchors_settled_uncoupled: float = 1e-5


@dataclass(frozen=True)
class Fallback:
    """A way of solving a load step: when it is tried, how it works, and why that helps.

    applies: to a problem; solve: from the Newton solver and the load to all results, of which the last counts.
    """

    name: str
    when: str
    how: str
    reason: str
    applies: Callable[[ContactProblem], bool]
    solve: Callable[[Newton, Load], list[NewtonResult]]

    def __str__(self):
        return f"{self.name} ({self.when}): {self.how}. {self.reason}."


def jumping_newton(newton: Newton, load: Load) -> list[NewtonResult]:
    """Newton's method with jumps of edges, from the nearest state that is known."""
    start = {}
    if not newton.has_solved(load):  # else the state is that of other anchors
        start = {"extrapolate" if newton.last_steps.ahead(load) else "predict": True}
    return [newton.solve(load, jump=True, **start)]


def newton_as_it_is(newton: Newton, load: Load) -> list[NewtonResult]:
    """Newton's method from the present state."""
    return [newton.solve(load)]


def path(newton: Newton, load: Load) -> list[NewtonResult]:
    """Newton's steps from the last iterate, each cut where the first point changes its state, then Newton's test."""
    followed = newton.follow(load)
    if not followed.converged:
        return [followed]
    return [followed, newton.solve(load)]


FALLBACKS = (
    Fallback(
        "jumping Newton",
        "first, with friction",
        "semismooth Newton with full steps, in which edges of contact and stick may jump; it starts on the line "
        "through the last two states, where the load turns with all points stuck",
        "Edges move on nearly as before, and without jumps they take many steps",
        lambda problem: problem.friction,
        jumping_newton,
    ),
    Fallback(
        "Newton",
        "first, without friction",
        "semismooth Newton with full steps",
        "It ends after a few iterations once the contact states settle",
        lambda problem: not problem.friction,
        newton_as_it_is,
    ),
    Fallback(
        "path",
        "where that fails",
        "from the iterate with the least residual, each step ends where the first point opens, closes, sticks or "
        "slides",
        "Contact states change one by one, and none comes twice",
        lambda problem: True,
        path,
    ),
)
HALVING = (
    "halving (where all of these fail, or where tractions zigzag, if they do so less then): two steps of half the "
    "load, one after the other."
)


def explained(problem: ContactProblem) -> list[str]:
    """What is tried for a problem, one line each."""
    return [str(fallback) for fallback in FALLBACKS if fallback.applies(problem)] + [HALVING]
