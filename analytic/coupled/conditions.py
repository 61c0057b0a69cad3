"""Conditions of contact and friction that the edges of a state do not ensure."""

import numpy as np

from ..checks import ContactNotConverged
from .edges import ARRIVAL
from .rule import smooth_rule

BORNE = 1e-5  # violation of the conditions that is borne, in units of the problem,
BACKWARDS = 0.01, 1e-8  # and of slip since the state before: over that in the right direction, and in any case


def check(state, before, base, direction):
    """Raise ContactNotConverged unless p >= 0, |q| <= mu p, and points have slipped in the direction of Q.

    before: the state before on the branch, or ``base``, the one at the turn; direction: of Q since then.
    """
    x_l, x_r = state.contact
    c_l, c_r = state.stick
    if c_l < base.contact[0] or c_r > base.contact[1]:
        raise ContactNotConverged(ARRIVAL)
    x, weight = smooth_rule(x_l, x_r, state.breaks)
    p, q = state.tractions(x)
    if (tension := weight @ np.maximum(-p, 0)) > BORNE:
        raise ContactNotConverged(f"the pressure is negative, its integral {tension:.1e} P")
    if (over := weight @ np.maximum(np.abs(q) - state.problem.mu * p, 0)) > BORNE:
        raise ContactNotConverged(f"q exceeds its limit where it sticks, by {over:.1e} P in all")
    back, forth = _slipped(state, before, base, direction)
    share, least = BACKWARDS
    if back > max(share * forth, least):
        raise ContactNotConverged(f"a point slips backwards, by {back:.1e}")


def _slipped(state, before, base, direction):
    """Largest slip backwards, and in the direction of the branch, since the state before.

    Of points that touched in both: what comes into contact has moved before. A longer way would hide that points
    still slip backwards, as they do where they came in stick and have not all slipped yet.
    """
    back = forth = 0.0
    left, right = max(state.contact[0], before.contact[0]), min(state.contact[1], before.contact[1])
    for low, high in ((left, state.stick[0]), (state.stick[1], right)):
        if low < high:
            x, _ = smooth_rule(low, high, [*before.breaks, *base.contact])
            moved = direction * (state.displacements(x)[0] - before.displacements(x)[0])
            back, forth = max(back, moved.max()), max(forth, -moved.min())
    return back, forth
