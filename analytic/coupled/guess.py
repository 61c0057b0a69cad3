"""Guesses for the edges of a branch: functions of the distance from the turn.

Each returns the variables (4,) of ``edges.edges_of``.
"""

import numpy as np

from .edges import variables_of

MIRRORED = np.array([-1.0, 1.0, 1.0, -1.0])  # signs of the variables at -x, in reverse order


def uncoupled(k, limit):
    """From a state of full stick, without coupling, (48)."""

    def guess(load):
        c = max(1 - load / limit, 1e-3) ** (1 / (2 + k))
        return variables_of(np.array([-1.0, -c, c, 1.0]), load, (-1.0, 1.0))

    return guess


def mirrored(branch):
    """From a branch of the other direction."""

    def guess(load):
        return branch.guessed(load)[::-1] * MIRRORED

    return guess


def turned(branch):
    """After the first turn, from the branch before it: as after half the load from there, (36), [X5]."""

    def guess(load):
        half = np.clip(load / 2, branch.loads[0], branch.span)
        return mirrored(branch)(half) - np.log(load / half) * np.array([0, 1, 1, 0])

    return guess
