"""The depth coordinate in which the graded half-plane is meshed and solved.

Below a loaded surface of modulus ``y^k`` with ``k > 0`` the displacement behaves like ``y^(1-k)``: a
finite traction is a vanishing modulus times an infinite strain. No polynomial in ``y`` follows
that. In ``s = y^(1-k)`` the displacement is smooth, so for ``k > 0`` the mesh lives in ``(x, s)``.
For ``k <= 0`` the displacement is smooth in ``y`` itself and ``s = y``.

Everything else is written in physical gradients and volumes; this object is the only place that
knows the difference.
"""

from dataclasses import dataclass
from typing import Any

import ufl


@dataclass(frozen=True)
class DepthMap:
    """The map ``y(s) = s^m`` from mesh depth ``s`` to physical depth ``y`` (both dimensionless).

    Works on numbers, numpy arrays and UFL expressions alike; m may be a UFL constant.
    """

    m: Any = 1.0
    is_identity: bool = True

    def y(self, s):
        """Physical depth at mesh depth ``s``."""
        return s if self.is_identity else s**self.m

    def s(self, y):
        """Mesh depth at physical depth ``y``."""
        return y if self.is_identity else y ** (1.0 / self.m)

    def stretch(self, s):
        """``dy/ds``, which is also the ratio of physical to mesh volume."""
        return 1.0 if self.is_identity else self.m * s ** (self.m - 1.0)

    def gradient(self, u, s):
        """Physical gradient ``du_i/d(x, y)`` of a vector field ``u`` on the ``(x, s)`` mesh."""
        if self.is_identity:
            return ufl.grad(u)
        return ufl.dot(ufl.grad(u), ufl.as_matrix([[1.0, 0.0], [0.0, 1.0 / self.stretch(s)]]))
