"""Coefficient of friction above which Coulomb's law on surface elements has more than one rate solution.

In contact, elements of equal length stick or slip, and P, Q and the contact stay as they are. A rate r of slip takes
the rates q = K r and p = G r of traction and pressure. Points that stick have r = 0, points that slip q = mu s p, with
the sign s of their traction. So the rates are unique for every pattern of stick and slip as long as no principal
minor of K - mu S G vanishes (a P-matrix): Klarbring, Ciavarella & Barber 2007; Hassani, Hild, Ionescu & Sakki 2003.
docs/critical_friction.md says what this tells about a continuous surface.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from .operator import element_moments
from .surface_kernel import SurfaceKernel

ELEMENTS = 12
LARGEST_MU = 100.0  # of the coefficients that are looked at; beyond it is infinite
STEPS = 24  # of the bisection
WIDTHS = (1, 2, 3)  # of the stretches that a step of the search changes
REAL = 1e-9  # relative imaginary part below which an eigenvalue is real
SEEDS = ("+-0+", "-0+-", "0+-+", "-0+")  # short stretches that singular patterns have
# left end, then "----", then right end: for k < -0.3 and k > 0.85 singular ones have slivers at the edges of contact
ENDS = (("+", "+-0"), ("+", "-0-"), ("-", "+0"))


@dataclass(frozen=True)
class RateOperator:
    """Rates of traction q = K r and pressure p = G r per rate r of slip against the indenter, at constant loads.

    stiffness: K (n, n), its rows add up to zero; pressing: G (n, n) [both stress/length].
    """

    stiffness: np.ndarray
    pressing: np.ndarray

    @classmethod
    def of(cls, kernel: SurfaceKernel, half_width: float = 1.0, elements: int = ELEMENTS) -> "RateOperator":
        """Of equal elements of constant traction on |x| < half_width [length], with displacements at their middles."""
        nodes = np.linspace(-half_width, half_width, elements + 1)
        normal, tangential, coupling = element_moments(kernel, (nodes[1:] + nodes[:-1]) / 2, nodes)[:, 0]
        return cls.from_compliance(tangential, coupling, -coupling, normal)

    @classmethod
    def from_compliance(cls, xx, xy, yx, yy) -> "RateOperator":
        """From displacements u_x = xx q + xy p and u_y = yx q + yy p (n, n) of tractions, or nodal forces, in contact.

        They hold up to a rigid translation; the sum of q and that of p are the loads.
        """
        n, scale = len(yy), np.abs(yy).max()
        matrix = np.zeros((2 * n + 2, 2 * n + 2))
        matrix[: 2 * n, : 2 * n] = np.block([[yy, yx], [xy, xx]]) / scale
        matrix[:n, -2] = matrix[n : 2 * n, -1] = -1.0
        matrix[-2, :n] = matrix[-1, n : 2 * n] = 1.0
        inverse = np.linalg.inv(matrix)
        return cls(inverse[n : 2 * n, n : 2 * n] / scale, inverse[:n, n : 2 * n] / scale)

    def singular(self, patterns) -> np.ndarray:
        """Smallest mu > 0 at which each pattern (m, n) of signs, 0 for stick, has a second solution; inf for none.

        A pattern in which all slip is no bound: the indenter is then free to move.
        """
        patterns = np.atleast_2d(np.asarray(patterns, dtype=float))
        slips = patterns != 0
        pairs = slips[:, :, None] & slips[:, None, :]
        K = np.where(pairs, self.stiffness, 0.0) / np.abs(self.stiffness).max()
        K += np.where(slips, 0.0, 1.0)[:, :, None] * np.eye(patterns.shape[1])
        G = np.where(pairs, patterns[:, :, None] * self.pressing, 0.0) / np.abs(self.stiffness).max()
        free = slips.all(axis=1)
        K[free] = np.eye(patterns.shape[1])
        values = np.linalg.eigvals(np.linalg.solve(K, G))
        size = np.abs(values).max(axis=1, keepdims=True)
        inverse = np.where(np.abs(values.imag) <= REAL * size, values.real, 0.0).max(axis=1)
        inverse[free] = 0.0
        return np.where(inverse > 1 / LARGEST_MU, 1 / np.maximum(inverse, 1 / LARGEST_MU), np.inf)

    def is_unique(self, mu: float, stuck: int) -> bool:
        """True where no pattern in which the element ``stuck`` sticks has a second solution; False: not known.

        Sufficient: all K - mu S G are H-matrices. Their rows are chosen one by one by the signs, so that one vector
        v > 0 has to prove it for the worst row of each element; it is found by policy iteration.
        """
        K, G = (np.delete(np.delete(m, stuck, 0), stuck, 1) for m in (self.stiffness, self.pressing))
        diagonal = np.diag(K) - mu * np.abs(np.diag(G))
        rows = [-np.abs(K - mu * sign * G) for sign in (1.0, -1.0)]
        for row in rows:
            np.fill_diagonal(row, diagonal)
        chosen = np.zeros(len(K), dtype=bool)
        for _ in range(len(K)):
            try:
                v = np.linalg.solve(np.where(chosen[:, None], rows[1], rows[0]), np.ones(len(K)))
            except np.linalg.LinAlgError:
                return False
            if v.min() <= 0:
                return False
            images = np.stack([row @ v for row in rows])
            if images.min() > 0:
                return True
            chosen = images[1] < images[0]
        return False


@dataclass(frozen=True)
class CriticalFriction:
    """Bounds of the critical coefficient: unique rates below ``lower``, a second solution at ``upper``.

    pattern: signs of the traction where elements slip and 0 where they stick, such as "+-0+----"; "" where upper = inf.
    """

    lower: float
    upper: float
    pattern: str


def critical_friction(operator: RateOperator) -> CriticalFriction:
    """Sure lower bound, over all patterns with an element that sticks, and upper bound by local search."""
    if not np.abs(operator.pressing).max() * LARGEST_MU > np.diag(operator.stiffness).min() / LARGEST_MU:
        return CriticalFriction(np.inf, np.inf, "")  # no coupling, the Holl ratio
    upper, pattern = smallest_singular(operator)
    return CriticalFriction(largest_unique(operator), upper, pattern)


def largest_unique(operator: RateOperator) -> float:
    """Largest mu, by bisection, for which ``is_unique`` wherever one element sticks."""
    n, low, high = len(operator.stiffness), 0.0, LARGEST_MU
    for _ in range(STEPS):
        middle = (low + high) / 2
        if all(operator.is_unique(middle, stuck) for stuck in range(n)):
            low = middle
        else:
            high = middle
    return low


def smallest_singular(operator: RateOperator) -> tuple[float, str]:
    """Smallest mu with a second solution that steepest descent over patterns finds, and the pattern."""
    starts = _starts(len(operator.stiffness))
    values = operator.singular(starts)
    best: tuple[float, np.ndarray] = (np.inf, np.zeros(0))
    for first in values.argsort()[:3]:
        value, signs = values[first], starts[first]
        while True:
            near = _neighbours(signs)
            found = operator.singular(near)
            if not found.min() < value * (1 - 1e-9):
                break
            value, signs = found.min(), near[found.argmin()]
        if value < best[0]:
            best = float(value), signs
    return best[0], _written(best[1])


def sliver_singular(operator: RateOperator, places: int) -> tuple[float, str]:
    """Smallest mu with a second solution where all slips but one element, which has a sliver beside it; the pattern.

    The patterns are "++-0+--" and "--+0-++" at that many ``places``: an upper bound for many elements.
    """
    n = len(operator.stiffness)
    patterns = []
    for place in np.unique(np.linspace(1, n - 2, places).astype(int)):
        pattern = np.where(np.arange(n) < place, 1.0, -1.0)
        pattern[place - 1 : place + 2] = [-1.0, 0.0, 1.0]
        patterns += [pattern, -pattern]
    values = operator.singular(patterns)
    return float(values.min()), _written(patterns[values.argmin()])


def _written(signs):
    return "".join("0+-"[int(sign)] for sign in signs)


def _starts(n):
    """Patterns (m, n) of a short seed at every place between two stretches of slip."""
    sign = {"+": 1.0, "-": -1.0, "0": 0.0}
    patterns = []
    for seed, flip, left, right in product(SEEDS, (1.0, -1.0), (1.0, -1.0), (1.0, -1.0)):
        short = [flip * sign[c] for c in seed]
        places = range(n - len(seed) + 1)
        patterns += [np.array([left] * place + short + [right] * (n - len(seed) - place)) for place in places]
    for first, end in ENDS:
        pattern = np.full(n, -1.0)
        pattern[0], pattern[-len(end) :] = sign[first], [sign[c] for c in end]
        patterns += [pattern, pattern[::-1]]
    return np.unique(patterns, axis=0)


def _neighbours(signs):
    """Patterns that differ from this one in a short stretch, or are it moved by one element."""
    n, near = len(signs), [np.roll(signs, 1), np.roll(signs, -1)]
    for width, sign in product(WIDTHS, (-1.0, 0.0, 1.0)):
        for first in range(n - width + 1):
            pattern = signs.copy()
            pattern[first : first + width] = sign
            near.append(pattern)
    return np.unique(near, axis=0)
