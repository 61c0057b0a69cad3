"""State of a coupled loop in the user's units: fields at nodes, and as functions of x."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .panels import even_kernel
from .rule import smooth_rule


@dataclass(frozen=True)
class Units:
    """Units of length [length], stress [stress], displacement [length], and energy [stress x length²] of a problem.

    shift_x, shift_y: displacements [length] under unit loads between the kernels of ``PowerLawKernel`` and those here.
    """

    length: float
    stress: float
    displacement: float
    shift_x: float
    shift_y: float

    @classmethod
    def of(cls, normal):
        """Units of a normal stage."""
        solid, a = normal.solid, normal.a
        displacement = normal.P * (solid.y0 / a) ** solid.k / solid.E0
        # R(a/y0): the kernels of ``PowerLawKernel`` have y0 for the length that is a here
        shift = float(even_kernel(np.array([a / solid.y0]), solid.k)[0]) * normal.P / solid.E0
        return cls(a, normal.P / a, displacement, solid.gk * shift, solid.bk * shift)

    @property
    def load(self):
        """Unit of line loads [stress x length]."""
        return self.stress * self.length


class CoupledState:
    """State at the loads P and Q [stress x length]; arrays are values at the nodes x of the contact, which increase.

    x: nodes [length], gathered at the edges and where the tractions are not smooth; weight: their quadrature weights
    [length]; pressure, traction [stress]; slip: u_x - delta_x since the end of the normal stage [length]; contact,
    stick: left and right edge [length]; stick_zones: shape (1, 2); delta_x, delta_y: displacements of the indenter
    [length], for k <= 0 up to a constant times the loads; branch: ``Branch`` of the state, None before Q acts;
    is_certain: see ``Branch``.
    """

    def __init__(self, normal, state, branch=None, friction=None, turn=None):
        """friction: ``FrictionalWork`` of the branch; turn: the state in which it began, None for that without Q."""
        units = Units.of(normal)
        self._units, self._normal, self._state = units, normal, state
        self._friction, self._turn = friction, turn
        self.P, self.Q = units.load, units.load * state.Q
        self.contact = _times(units.length, state.contact)
        self.stick = _times(units.length, getattr(state, "stick", (np.nan, np.nan)))
        self.stick_zones = np.array([self.stick]) if np.isfinite(self.stick[0]) else np.empty((0, 2))
        self.delta_x = units.displacement * state.delta_x + units.shift_x * state.Q
        self.delta_y = units.displacement * state.delta_y + units.shift_y
        self.branch = branch
        self.is_certain = branch is None or (turn is None or turn.is_certain) and branch.is_certain(state.Q)
        x_l, x_r = state.contact
        x, weight = smooth_rule(x_l, x_r, state.breaks)
        self.x, self.weight = units.length * x, units.length * weight
        self.pressure, self.traction = units.stress * state.tractions(x)

    @property
    def dissipated_energy(self):
        """Frictional work since first contact [stress x length²]. It needs more states; ContactNotConverged."""
        return self.dissipated_since(None)

    def dissipated_since(self, turn: "CoupledState | None"):
        """The same since an earlier state in which Q turned; what was before is not solved for it."""
        if self is turn:
            return 0.0
        before = self._turn.dissipated_since(turn) if self._turn else self._normal.dissipated_energy
        return before + (self._since_turn if self._friction else 0.0)

    @cached_property
    def _since_turn(self):
        return self._friction.at(self._state) * self._units.load * self._units.displacement

    @cached_property
    def slip(self):
        """u_x - delta_x since the end of the normal stage, at the nodes [length]."""
        return self.slip_at(self.x)

    def _tractions_at(self, x):
        x = np.asarray(x, dtype=float)
        inside = np.clip(x.ravel() / self._units.length, *self._state.contact)
        values = self._units.stress * self._state.tractions(inside).reshape(2, *x.shape)
        return np.where((x > self.contact[0]) & (x < self.contact[1]), values, 0.0)

    def pressure_at(self, x):
        """p at x [stress] of any shape, zero outside the contact."""
        return self._tractions_at(x)[0]

    def traction_at(self, x):
        """q at x [stress] of any shape, zero outside the contact."""
        return self._tractions_at(x)[1]

    def slip_at(self, x):
        """u_x - delta_x at x since the end of the normal stage [length], also outside the contact; any shape."""
        x = np.asarray(x, dtype=float)
        scaled = x.ravel() / self._units.length
        moved = self._state.displacements(scaled) - self._normal.displacements(scaled)
        return self._units.displacement * moved[0].reshape(x.shape)


def _times(factor, pair):
    return factor * float(pair[0]), factor * float(pair[1])
