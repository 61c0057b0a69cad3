"""Path of solutions from a problem that is solved to the one that is to be solved: Lemke's method for contact.

Heights, positions at rest and loads are changed until a guess fulfils every condition, and are then led back. On
the way the solution is piecewise linear, and one node after the other changes its status. If need be the path
turns round, which iterations of active sets cannot. It ends after finitely many changes.
"""

from dataclasses import dataclass

import numpy as np

from ..checks import ContactNotConverged
from .linear import ContactSets, Data, LinearProblems

STEPS_PER_NODE = 4  # before it is given up
GUESS_MARGIN = 1e-3  # of the largest pressure or displacement: how far a guess is moved inside its conditions
FLAT = 1e-16  # rates below are rounding; between neighbours at an edge, slip differs by 1e-11


@dataclass(frozen=True)
class Start:
    """Sets and data of a problem that is solved, and its largest pressure and displacement for comparison."""

    sets: ContactSets
    data: Data
    stress: float
    length: float


def near(operator, mu, data: Data, guess) -> Start:
    """The ``guess``, an IncrementSolution, moved inside its conditions: it solves a problem not far from ``data``."""
    s, sets, some = guess, guess.sets, _some(guess.x)
    stress, length = np.abs(s.pressure).max(), np.ptp(data.height)
    p = np.where(sets.closed, np.maximum(s.pressure, some * stress), 0.0)
    limit = mu * p
    q = np.where(sets.slipping, sets.slipping * limit, np.clip(s.traction, (some - 1) * limit, (1 - some) * limit))
    u_x, u_y = operator.displacement(p, q)
    gap = np.where(sets.closed, 0.0, np.maximum(s.gap, some * length))
    position = u_x - s.delta_x
    slip = np.maximum(-sets.slipping * (position - data.rest), some * length)
    rest = np.where(sets.closed, position + sets.slipping * slip, data.rest)
    return Start(sets, Data(gap - u_y + s.delta_y, rest, operator.weight @ p, operator.weight_q @ q), stress, length)


def sticking(operator, data: Data, guess) -> Start:
    """Every node in contact of the ``guess`` sticks under q = p Q/P, which |Q| < mu P allows at each of them."""
    closed, some = guess.sets.closed, _some(guess.x)
    stress, length = np.abs(guess.pressure).max(), np.ptp(data.height)
    p = np.where(closed, np.maximum(guess.pressure, some * stress), 0.0)
    p *= data.P / (operator.weight @ p)
    q = data.Q / data.P * p
    u_x, u_y = operator.displacement(p, q)
    gap = np.where(closed, 0.0, np.maximum(guess.gap, some * length))
    rest = np.where(closed, u_x - guess.delta_x, data.rest)
    start = Data(gap - u_y + guess.delta_y, rest, data.P, operator.weight_q @ q)
    return Start(ContactSets(closed, np.zeros(len(p))), start, stress, length)


def _some(x):
    """Margins for the nodes, no two alike: they then change their status one by one."""
    return GUESS_MARGIN * (1 + np.modf(0.6180339887 * np.arange(len(x)))[0])


def followed(problems: LinearProblems, data: Data, start: Start):
    """Solution for ``data`` at the end of the path from ``start``; raises ContactNotConverged."""
    mu, sets, added, units = problems.mu, start.sets, start.data - data, (start.stress, start.length)
    t, direction, entered = 1.0, -1.0, None
    limit = STEPS_PER_NODE * len(data.height)
    for _ in range(limit):
        fixed, change = problems.solve(sets, data, added)
        rate = _conditions(mu, sets, added, change, *units)
        value = _conditions(mu, sets, data, fixed, *units) + t * rate
        if entered is not None:
            direction = np.sign(rate[entered]) or 1.0
            value[entered] = np.nan
        falls = direction * rate < -FLAT
        steps = np.where(falls & ~np.isnan(value), np.maximum(value, 0.0) / np.where(falls, np.abs(rate), 1.0), np.inf)
        row, node = np.unravel_index(steps.argmin(), steps.shape)
        if direction < 0 and steps[row, node] >= t:
            return fixed
        if not np.isfinite(steps[row, node]):
            raise ContactNotConverged("the path from a solved problem to this one does not arrive")
        t += direction * steps[row, node]
        moved = fixed.position + t * change.position - data.rest - t * added.rest
        sets, entered = _switched(mu, sets, row, node, moved)
    raise ContactNotConverged(f"the path from a solved problem to this one takes more than {limit} changes of status")


def _conditions(mu, sets, data, s, stress, length):
    """What must not be negative, shape (2, n), nan for none.

    Open: gap; slip: pressure, slip against the traction; stick: reserves of friction mu p - q and mu p + q.
    """
    slips, stick = sets.slipping != 0, sets.stuck & (mu > 0)
    first = np.where(sets.closed, np.where(stick, mu * s.pressure - s.traction, s.pressure) / stress, s.gap / length)
    slip = -sets.slipping * (s.position - data.rest)
    second = np.where(stick, (mu * s.pressure + s.traction) / stress, slip / length)
    return np.array([first, np.where(stick | slips, second, np.nan)])


def _switched(mu, sets, row, node, moved):
    """Sets after the condition (row, node) has come to zero, and the condition that was kept at zero so far."""
    closed, slipping = sets.closed.copy(), sets.slipping.copy()
    sign = slipping[node]
    entered = 0, node
    if not closed[node]:
        closed[node] = True
        slipping[node] = -np.sign(moved[node]) if mu else 0.0
    elif mu == 0 or (sign and row == 0):
        closed[node], slipping[node] = False, 0.0
    elif sign:
        slipping[node] = 0.0
        entered = (0 if sign > 0 else 1), node
    else:
        slipping[node] = sign = 1.0 if row == 0 else -1.0
        entered = 1, node
        if slipping[closed].all():
            # All slip: the indenter moves by itself, until a point that slips the other way rests.
            others = closed & (slipping == -sign)
            if not others.any():
                raise ContactNotConverged("every node in contact slips")
            node = np.where(others, np.abs(moved), np.inf).argmin()
            slipping[node] = 0.0
            entered = (0 if sign < 0 else 1), node
    return ContactSets(closed, slipping), entered
