"""State of the contact solver after an increment, and the memory that the next increment needs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from ..straight_way import StraightWay
from .interpolation import Edges
from .layout import Layout


@dataclass(frozen=True)
class ContactState:
    """Result of one increment; arrays are values at the nodes x, in increasing order.

    P, Q: loads [stress x length]; strain: of the half-plane along x [1]; x: nodes [length];
    weight, weight_q: quadrature weights [length] with which pressure and traction sum up to the loads, the same up to
    the error of interpolation; pressure, traction [stress]; slip: u_x - delta_x since the end of the normal stage
    [length], also where there is no contact; gap [length];
    contact, stick: left and right edge [length], stick that of all its zones, nan without friction;
    stick_zones: each of them, shape (n, 2); dissipated_energy: frictional work since first contact [stress x length²];
    delta_x, delta_y: displacements of the indenter [length], for k <= 0 up to a constant times the loads.
    """

    P: float
    Q: float
    strain: float
    x: np.ndarray
    weight: np.ndarray
    weight_q: np.ndarray
    pressure: np.ndarray
    traction: np.ndarray
    slip: np.ndarray
    gap: np.ndarray
    contact: tuple[float, float]
    stick: tuple[float, float]
    stick_zones: np.ndarray
    dissipated_energy: float
    delta_x: float
    delta_y: float

    @property
    def load(self):
        """(P, Q, strain)."""
        return self.P, self.Q, self.strain

    def pressure_at(self, x):
        """p at x [stress] of any shape, zero outside the contact."""
        return np.interp(x, self.x, self.pressure, left=0.0, right=0.0)

    def traction_at(self, x):
        """q at x [stress] of any shape, zero outside the contact."""
        return np.interp(x, self.x, self.traction, left=0.0, right=0.0)

    def slip_at(self, x):
        """Slip at x [length] of any shape, within the nodes."""
        return np.interp(x, self.x, self.slip)


@dataclass(frozen=True)
class StoredField:
    """Function of x known at the nodes of an increment, and beyond them from its tractions."""

    x: np.ndarray
    value: np.ndarray
    beyond: Callable

    @cached_property
    def _interpolant(self):
        return CubicSpline(self.x, self.value)

    def __call__(self, x):
        """Values at x, shape (n,)."""
        inside = (x >= self.x[0]) & (x <= self.x[-1])
        result = np.empty(len(x))
        result[inside] = self._interpolant(x[inside])
        if not inside.all():
            result[~inside] = self.beyond(x[~inside])
        return result


@dataclass(frozen=True)
class PiecewiseField:
    """Function of x that is another one between each two of the ``breaks`` (n,), and outside of them."""

    breaks: np.ndarray
    functions: tuple[Callable, ...]

    @classmethod
    def kept_in(cls, zones, old: Callable, new: Callable):
        """``old`` in each of the ``zones`` (m, 2), where it sticks, else ``new``.

        Interpolated again at each load step it would drift, most at old edges of stick, where it has kinks.
        """
        old = old if isinstance(old, cls) else cls(np.empty(0), (old,))
        breaks, functions = [], [new]
        for left, right in zones:
            inside = (old.breaks > left) & (old.breaks < right)
            first = np.searchsorted(old.breaks, left, side="right")
            breaks += [left, *old.breaks[inside], right]
            functions += [*old.functions[first : first + inside.sum() + 1], new]
        return cls(np.array(breaks), tuple(functions))

    def __call__(self, x):
        """Values at x, shape (n,)."""
        piece = np.searchsorted(self.breaks, x, side="right")
        result = np.empty(len(x))
        for number in np.unique(piece):
            result[piece == number] = self.functions[number](x[piece == number])
        return result


@dataclass(frozen=True)
class Memory:
    """Last state (None before first contact), its layout, functions of x: slip, its reference u_x - delta_x, pressure,
    traction, gap; the straight way of the loads so far, the frictional work before it, and the directions in which Q
    and the strain last moved."""

    state: ContactState | None
    layout: Layout
    slip: Callable = np.zeros_like
    reference: Callable = np.zeros_like
    pressure: Callable = np.zeros_like
    traction: Callable = np.zeros_like
    gap: Callable = np.zeros_like
    way: StraightWay | None = None
    begun: float = 0.0
    direction: tuple[float, float] = (0.0, 0.0)

    def position(self, x):
        """u_x - delta_x at x [length]."""
        return self.slip(x) + self.reference(x)

    def directions(self, load):
        """``direction`` once the load (P, Q, strain) is reached."""
        if self.state is None:
            return self.direction
        moved = (np.sign(new - old) for new, old in zip(load[1:], self.state.load[1:], strict=True))
        return tuple(now or before for now, before in zip(moved, self.direction, strict=True))

    def edges_left_behind(self, load):
        """Edges of stick where slip ended for good; those of the last increment count if a load turns back from it."""
        old = self.layout.old_edges
        turned = self.state is not None and self.directions(load) != self.direction
        return old + Edges.of_zones(self.layout.zones) if turned else old

    @property
    def dissipated_energy(self):
        """Frictional work so far [stress x length²]."""
        return self.state.dissipated_energy if self.state else 0.0
