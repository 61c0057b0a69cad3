"""Guesses for the edges of a branch at a load, the distance of Q from the turn: variables (4,) of ``edges_of``."""

import numpy as np

from .edges import edges_of, variables_of

MIRRORED = np.array([-1.0, 1.0, 1.0, -1.0])  # signs of the variables at -x, in reverse order
CLOSE = 1e-3  # to where stick ended, over its half-width


def uncoupled(k, limit, load, half=1.0):
    """From a state of full stick for -half < x < half, without coupling, (48)."""
    c = _stick(k, limit, load)
    return variables_of(half * np.array([-1.0, -c, c, 1.0]), load, (-half, half))


def pressed(base, direction, load):
    """From a state pressed with friction, as ``uncoupled``; on one side slip goes on from where it is."""
    c = _stick(base.problem.k, base.problem.mu, load)
    shorter = min(c, base.stick[1] * (1 - CLOSE))
    c_l, c_r = (-c, shorter) if base.goes_on == direction else (-shorter, c)
    return variables_of(np.array([-1.0, c_l, c_r, 1.0]), load, base.contact)


def _stick(k, limit, load):
    """Half-width of stick without coupling, (48)."""
    return max(1 - load / limit, 1e-3) ** (1 / (2 + k))


def mirrored(branch, load):
    """From a branch of the other direction."""
    return branch.guessed(load)[::-1] * MIRRORED


def beyond(earlier, last, within, base, direction, load):
    """As ``within`` up to the turn at which the last branch began; beyond as if the earlier one, which ended there, had
    gone on."""
    Q = base.Q + direction * load
    if not last.is_undone(Q):
        return within(load)
    load_of_earlier = abs(Q - earlier.base.Q)
    edges = edges_of(earlier.guessed(load_of_earlier), load_of_earlier, earlier.base.contact)
    return variables_of(edges, load, base.contact)


def turned(branch, load):
    """After the first turn, from the branch before it: as after half the load from there, (36), [X5]."""
    half = max(load / 2, branch.loads[0])
    return mirrored(branch, half) - np.log(load / half) * np.array([0, 1, 1, 0])
