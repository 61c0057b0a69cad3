"""Safeguards against cycling of Newton's method under friction; none of them is in the test of what is accepted.

Predictor: all points in contact stick. Last iterate: no point turns from sliding one way to sliding the other without
sticking in between, and a pinned point does not slide. Lagged pressure: friction is limited by a pressure kept.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from forms import contact, weak_form

from .surface_points import PointExpression, SurfacePoints


class NewtonSafeguards:
    """Changes to Coulomb's law in the forms, all of them off at first.

    pressure: expression of the pressure that is lagged; None where the pressure is held anyway.
    """

    def __init__(self, points: SurfacePoints, law: weak_form.Contact, pressure: PointExpression | None):
        self._points, self._friction, self._pressure = points, law.friction, pressure
        self._sliding = PointExpression(points, law.sliding)
        self._beyond_limit = PointExpression(points, law.beyond_limit)

    @contextmanager
    def all_stick(self) -> Iterator[None]:
        """The predictor: meanwhile every point in contact sticks."""
        self._friction.all_stick.value = 1.0
        try:
            yield
        finally:
            self._friction.all_stick.value = 0.0

    @property
    def is_predicting(self) -> bool:
        """True within ``all_stick``."""
        return bool(self._friction.all_stick.value)

    @contextmanager
    def lagged_pressure(self) -> Iterator[None]:
        """Meanwhile friction is limited by the pressure of now."""
        self._pressure.into(self._friction.lagged_pressure)
        self._friction.is_lagged.value = 1.0
        try:
            yield
        finally:
            self._friction.is_lagged.value = 0.0

    def note_sliding(self):
        """Remember where points slide now: until ``forget`` none turns round without sticking in between."""
        self._sliding.into(self._friction.slid)

    def pin(self, which: np.ndarray):
        """Let those of this rank's points (bool (m,)) not slide until ``note_sliding`` or ``forget``."""
        self._friction.slid.x.array[self._points.dofs[which]] = contact.PINNED
        self._friction.slid.x.scatter_forward()

    @contextmanager
    def imposed(self, values: np.ndarray) -> Iterator[None]:
        """Meanwhile contact states are imposed on this rank's points: values (m,) of ``contact.slides``, 0 for none."""
        self._friction.slid.x.array[self._points.dofs] = values
        self._friction.slid.x.scatter_forward()
        try:
            yield
        finally:
            self.forget()

    def forget(self):
        """No point pinned and none known to slide: Coulomb's law as it is."""
        self._friction.slid.x.array[:] = 0.0

    def slip_beyond_limit(self) -> np.ndarray:
        """How far this rank's points slide beyond where friction stops them (m,) [length]; negative in stick."""
        return self._beyond_limit.values()
