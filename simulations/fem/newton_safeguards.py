"""Contact states imposed on a single step of Newton's method; they are not in the test of what is accepted."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from forms import contact, weak_form

from .surface_points import SurfacePoints


class NewtonSafeguards:
    """Contact states imposed on points, none at first."""

    def __init__(self, points: SurfacePoints, law: weak_form.Contact):
        self._points, self._imposed = points, law.friction.imposed

    @contextmanager
    def imposed(self, values: np.ndarray) -> Iterator[None]:
        """Meanwhile contact states are imposed on this rank's points: values (m,) of ``contact.slides``, 0 for none."""
        self._imposed.x.array[self._points.dofs] = values
        self._imposed.x.scatter_forward()
        try:
            yield
        finally:
            self._imposed.x.array[:] = 0.0

    def all_stick(self):
        """The predictor: meanwhile every point in contact sticks."""
        return self.imposed(np.full(len(self._points.dofs), contact.PINNED))
