"""Memory of a load path in the traction: a polyline in the plane of P and Q, which holds for every contact.

Without coupling every traction is a superposition of the pressures of smaller loads, a chain of flat punches of
half-width s with the density n_x(s) = r n_y(s), |r| <= mu, (18), (27)-(31). With P(s) by (6) as the measure of s, the
state is the function Q(s) = ∫_0^s r dP, the line load that punches narrower than s carry: it starts at (0, 0) and ends
at the present loads. On a path of straight lines in P and Q it is a polyline. Its rules are

- P grows by dP and |dQ| <= mu dP: everything sticks, the new punches carry r = dQ/dP; a point is appended.
- Else the springs of the method of dimensionality reduction slip from the edge inwards, r = ±mu: a line of the slope
  ±mu through the new loads replaces what lies beyond its intersection with the polyline. The intersection is the
  load of the stick half-width. At constant P these are Masing's rules, [X5].
"""

from dataclasses import dataclass

import numpy as np

from .checks import require_partial_slip

SAME_POINT = 1e-14  # of P, and of mu P for Q: points of the polyline closer than this are one
SAME_SLOPE = 1e-9  # of mu


@dataclass(frozen=True)
class LoadMemory:
    """Polyline of the points P [stress x length], increasing from 0, and Q [same], with slopes |dQ/dP| <= mu.

    stick: the load P(s) of the half-width s of the zone that sticks under the last change of the loads.
    """

    mu: float
    P: np.ndarray
    Q: np.ndarray
    stick: float = 0.0

    @classmethod
    def unloaded(cls, mu):
        """No contact yet."""
        return cls(mu, np.zeros(1), np.zeros(1))

    @property
    def below_limit(self):
        """The load P(s) of the half-width s of the zone where |q| < mu p: beyond all punches carry mu, or all -mu."""
        slopes = np.diff(self.Q) / np.diff(self.P) / self.mu
        last = slopes[-1] if len(slopes) and abs(slopes[-1]) > 1 - SAME_SLOPE else np.inf
        inside = np.flatnonzero(np.abs(slopes - last) > SAME_SLOPE)
        return self.P[inside[-1] + 1] if len(inside) else self.P[0]

    def narrower(self, load):
        """Line load Q of the punches whose own P is at most ``load``; any shape."""
        return np.interp(load, self.P, self.Q)

    def advanced(self, P, Q):
        """Memory after a straight line from the present loads to P and Q. Needs P > 0 and |Q| < mu P."""
        require_partial_slip(P, Q, self.mu)
        dP, dQ = P - self.P[-1], Q - self.Q[-1]
        if dP == 0 and dQ == 0:
            return self
        if dP > 0 and abs(dQ) - self.mu * dP <= SAME_POINT * self.mu * P:
            return self._joined(len(self.P) - self._straight(dQ / dP), P, P, Q)
        direction = np.sign(dQ if dP >= 0 else Q - self.narrower(P))
        reserve, left = self.mu * self.P - direction * self.Q, self.mu * P - direction * Q
        # nearly in full slip: the second, as the first is the origin
        after = int(np.argmax(reserve >= left - SAME_POINT * self.mu * P) or np.argmax(reserve >= left))
        if direction == 0 or after == 0:  # 0: no punch slips, or by rounding only
            return self._joined(np.searchsorted(self.P, P), P, P, Q)
        share = (left - reserve[after - 1]) / (reserve[after] - reserve[after - 1])
        stick = self.P[after - 1] + min(share, 1.0) * (self.P[after] - self.P[after - 1])
        return self._joined(after, min(stick, P), P, Q)

    def _joined(self, kept, stick, P, Q):
        """The first ``kept`` points, that at the load ``stick``, and the new loads, without what is one with these."""
        loads = np.append(self.P[:kept], stick)
        loads = loads[loads < P - SAME_POINT * P]
        return LoadMemory(self.mu, np.append(loads, P), np.append(self.narrower(loads), Q), stick)

    def _straight(self, slope):
        """Whether a line of this slope only lengthens the last one."""
        last = np.diff(self.Q[-2:]) / np.diff(self.P[-2:])
        return bool(np.any(abs(last - slope) <= 1e-13 * self.mu))

    def slip_work(self, load, P, Q):
        """Friction work per punch on the way to P and Q: ∫ mu [P - P(s)] dQ(s) while the punch of P(s) = load slips.

        ∫ of it times D s^(-k-1) ds is the energy dissipated, D as in `ProfileContact.slip_work` but with (gk) for (bk).
        It is a polynomial of the second degree between the loads of ``breaks``.
        """
        start, load, total = (self.P[-1], self.Q[-1]), np.asarray(load, dtype=float), 0.0
        for sign in (1, -1):  # of the friction; its reserve mu P - sign Q falls where punches slip
            before, after = (self.mu * N - sign * T for N, T in (start, (P, Q)))
            if not after < before:
                continue
            slope = (start[0] - P) / (before - after)  # dP over d(reserve)
            first, last = self.mu * np.minimum(load, start[0]) - sign * self.narrower(load), after
            if slope < 0:  # punches that come into contact on the way slip from then on
                first = first + np.maximum(load - start[0], 0) / slope
            if slope > 0:  # those that leave it slip until then
                last = last + np.maximum(load - P, 0) / slope
            fall = np.maximum(first - last, 0)
            total = total + self.mu * fall * (np.maximum(P - load, 0) + slope * fall / 2)
        return np.broadcast_to(total, load.shape)[()]

    def breaks(self, after):
        """Loads between which slip_work is smooth, on the way to the memory ``after``; first that of the stick zone."""
        P, Q, stick = after.P[-1], after.Q[-1], after.stick
        on_way = self.P > P
        points = [stick, *self.P[self.P > stick], P]
        if on_way.any():  # punches that leave contact slip to either side of where the way crosses the polyline
            loads = np.concatenate([[P], self.P[on_way]])
            way = Q + (loads - P) / (self.P[-1] - P) * (self.Q[-1] - Q)
            above = way - self.narrower(loads)
            i = np.flatnonzero(above[1:] * above[:-1] < 0)
            points += list(loads[i] + (loads[i + 1] - loads[i]) * above[i] / (above[i] - above[i + 1]))
        return np.unique(points)
