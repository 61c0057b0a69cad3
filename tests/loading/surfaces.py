"""States of surface points before and after a load step, for tests of anchors."""

import numpy as np

from forms.contact import BACKWARD, CLOSED, FORWARD, OPEN
from simulations.loading.contact_points import Surface

X = np.linspace(-1.5, 1.5, 121)


def touching(half_width, s=0.0, stick=None) -> Surface:
    """A contact with a clearance that grows like the 3/2-th power beyond it; sliding outwards beyond ``stick``."""
    states = np.where(np.abs(X) <= half_width, CLOSED, OPEN)
    if stick is not None:
        states[(X > stick) & (states == CLOSED)], states[(X < -stick) & (states == CLOSED)] = BACKWARD, FORWARD
    return Surface(states, np.zeros(len(X)) + s, np.maximum(np.abs(X) - half_width, 0.0) ** 1.5)
