"""The dense Newton step of the condensed problem, on rank 0:  (I + T C) df - T e ddelta = b,  sum df = b_load.

T (sparse) is minus the derivative of the contact forces by the strip's displacements, C the compliance matrix of the
strip and e its rigid translations. From one step to the next only rows of T change whose contact state does,
so one matrix is inverted and every other is that one with some rows replaced (Woodbury). A node that opens (df = b) or
slides (its traction is known from its pressure) has a row of one or two entries, and costs no product with C. Where the
rows to be replaced become many, the inverse itself takes up those replaced so far. The first inverse is kept beside
it: after a turn of the load all points stick again, as they did then.
"""

import numpy as np
from scipy.linalg import blas, lapack
from scipy.sparse import csr_matrix

from .matrix import ComplianceMatrix

FEW = 0.15  # share of changed rows that neither open nor slide, beyond which another matrix is inverted
MANY = 0.15  # share of rows that change before the inverse takes up those replaced so far,
FEWER = 0.5  # if that leaves less than this share of them
REFINED = 1e-10, 1e-7  # residual of a step, over the load and over what it is to balance, beyond which it is refined
SOLVED = 1e-6  # relative residual of a step that is worth taking
PROPORTIONAL = 1e-13  # relative: rows this close to proportional are


class DenseTangent:
    """Factorises and solves the step for tangents T of one sparsity pattern, on rank 0.

    matrix: C; translations: (r, m), those of the m directions; sides: 2 for half of a problem. ``tangent``: the last T.
    """

    def __init__(self, matrix: ComplianceMatrix, translations: np.ndarray, sides: float):
        self._matrix, self._translations = matrix, translations
        self._rigid = translations.shape[1]
        self._size = matrix.shape[1]
        self._inverse = np.empty((0, 0))
        n = self._size // self._rigid
        self._sums = np.hstack([sides * np.kron(np.eye(self._rigid), np.ones(n)), np.zeros((self._rigid, self._rigid))])
        self.tangent = csr_matrix(matrix.shape[::-1])
        self._base: csr_matrix | None = None  # none where it is singular
        self._first: tuple[np.ndarray, csr_matrix] | None = None  # the first inverse, and its tangent
        self._singular = False
        self._rows = self._pressing = np.zeros(0, dtype=int)  # rows replaced, and those of their nodes' pressure
        self._ratio = np.zeros(0)  # of sliding ones among them to the pressure's, else 0
        self._rest = self._columns = self._lu = self._pivots = np.zeros((0, 0))
        self._known: dict[int, tuple[np.ndarray, np.ndarray]] = {}  # rows of T and of J, by their number

    def factorise(self, tangent: csr_matrix):
        """Prepare ``solve`` for T (mn, r)."""
        free, sliding, ratio = self._states(tangent)
        changed = self._choose_base(tangent)
        self.tangent = tangent
        if changed is not None:
            rest = changed & ~free & ~sliding
            if np.count_nonzero(rest) <= FEW * self._size:
                self._replace(np.flatnonzero(changed & free), np.flatnonzero(changed & sliding), ratio, rest)
                return
        self._rebase()

    def _choose_base(self, tangent) -> np.ndarray | None:
        """Rows (mn,) in which T differs from the base, after one with few of them was chosen; None without a base."""
        if self._base is None:
            return None
        changed = _changed(tangent, self._base)
        if np.count_nonzero(changed) <= MANY * self._size:
            return changed
        if self._first is not None:
            since_first = _changed(tangent, self._first[1])
            if np.count_nonzero(since_first) < np.count_nonzero(changed):
                (self._inverse, self._base), changed, self._rows = self._first, since_first, self._rows[:0]
        if len(self._rows) and not self._singular:
            since_last = _changed(tangent, self.tangent)
            if np.count_nonzero(since_last) < FEWER * np.count_nonzero(changed):
                self._take_up()
                changed = since_last
        return changed

    def _take_up(self):
        """Make the last tangent the base: the inverse with its rows replaced."""
        rows = self._rows
        if self._first is not None and self._inverse is self._first[0]:
            self._inverse = self._inverse.copy(order="F")
        inverse = self._inverse
        inverse[:, rows] = 0.0
        wanted = -self._new_rows(inverse)
        number = np.arange(len(rows))
        wanted[number, rows] += 1.0
        sliding = self._ratio != 0.0
        wanted[number[sliding], self._pressing[sliding]] -= self._ratio[sliding]
        known, _ = lapack.dgetrs(self._lu, self._pivots, wanted)
        self._inverse = blas.dgemm(1.0, self._columns, known, 1.0, inverse, overwrite_c=True)
        self._base = self.tangent

    def _rebase(self):
        free, _, ratio = self._states(self.tangent)
        self._invert(self.tangent, free)
        if self._first is None and self._base is not None:
            self._first = self._inverse, self._base
        none = np.array([], dtype=int)
        self._replace(none, none, ratio, np.zeros(self._size, dtype=bool))

    def solve(self, b: np.ndarray, load: float) -> np.ndarray:
        """The step (mn + m,) for the right-hand side ``b``, under a ``load``; nan where the tangent is singular.

        Refined once where need be: with E very large at the surface first steps are of forces much larger than the
        load, and the first answer has digits enough only for those. Where that does not help the base was no good
        for this tangent, which becomes the base itself.
        """
        x, defect = self._refined(b, load)
        if defect > SOLVED and len(self._rows):
            self._rebase()
            x, defect = self._refined(b, load)
        self._singular = defect > SOLVED
        return np.full_like(b, np.nan) if self._singular else x

    def solve_fixed(self, b: np.ndarray) -> np.ndarray:
        """The same without the first of the translations, and whatever the sum of the forces along it."""
        row = self._size
        matrix = np.vstack([self._full_rows(self.tangent, np.arange(row)), self._sums])
        matrix[row], matrix[row, row], right = 0.0, 1.0, b.copy()
        right[row] = 0.0
        *_, x, singular = lapack.dgesv(matrix, right)
        return np.full_like(b, np.nan) if singular else x

    def _refined(self, b, load):
        """A step and its residual over the largest of ``b``; the latter infinite where there is none."""
        if self._singular:
            return b, np.inf
        x = self._solve(b)
        residual, defect = self._residual(x, b)
        if defect < np.inf and np.abs(residual).max() > min(REFINED[0] * load, REFINED[1] * np.abs(b).max()):
            x = x + self._solve(residual)
            _, defect = self._residual(x, b)
        return x, defect

    def _residual(self, x, b):
        residual = b - self.multiply(x)
        if not np.all(np.isfinite(residual)):
            return residual, np.inf
        scale = np.abs(b).max()
        return residual, np.abs(residual).max() / scale if scale else 0.0

    def _solve(self, b):
        rows, right = self._rows, b.copy()
        right[rows] = 0.0
        x = self._inverse @ right
        if len(rows):
            wanted = b[rows] - self._ratio * b[self._pressing] - self._new_rows(x)
            known, _ = lapack.dgetrs(self._lu, self._pivots, wanted)
            x += self._columns @ known
        return x

    def multiply(self, x: np.ndarray) -> np.ndarray:
        """J x."""
        strip = self._matrix.apply(x[: self._size]) - self._translations @ x[self._size :]
        return np.concatenate([x[: self._size] + self.tangent @ strip, self._sums @ x])

    def _states(self, tangent):
        """Rows (mn,) of T that are zero; rows that are a multiple of their node's pressure row; and those multiples."""
        size = np.maximum.reduceat(np.abs(tangent.data), tangent.indptr[:-1])
        free, sliding, ratio = size == 0.0, np.zeros(self._size, dtype=bool), np.zeros(self._size)
        n = self._size // 2
        along, into = np.split(tangent.data, [tangent.indptr[n]])
        columns = np.split(tangent.indices, [tangent.indptr[n]])
        if self._rigid == 2 and np.array_equal(columns[0], columns[1]):
            first, length = tangent.indptr[:n], np.diff(tangent.indptr[: n + 1])
            norm = np.add.reduceat(into * into, first)
            ratio[:n] = np.add.reduceat(along * into, first) / np.where(norm > 0, norm, 1.0)
            defect = np.maximum.reduceat(np.abs(along - np.repeat(ratio[:n], length) * into), first)
            sliding[:n] = ~free[:n] & (defect <= PROPORTIONAL * size[:n])
        return free, sliding, ratio

    def _known_rows(self, tangent, rows):
        """``_full_rows``, of which those are kept: a node that sticks has the same row whenever it does."""
        data = [tangent.data[tangent.indptr[row] : tangent.indptr[row + 1]] for row in rows]
        new = [i for i, row in enumerate(rows) if row not in self._known or np.any(self._known[row][0] != data[i])]
        if new:
            for i, full in zip(new, self._full_rows(tangent, rows[new])):
                self._known[rows[i]] = data[i].copy(), full.copy()
        return np.array([self._known[row][1] for row in rows])

    def _full_rows(self, tangent, rows):
        """Rows of J (g, mn + m)."""
        chosen = tangent[rows]
        full = np.hstack([self._matrix.times(chosen), -(chosen @ self._translations)])
        full[np.arange(len(rows)), rows] += 1.0
        return full

    def _invert(self, tangent, free):
        """Make ``tangent`` the base: an open node's row is that of the identity and stays out of the factorisation."""
        active = np.append(~free, np.ones(self._rigid, bool))
        matrix = np.vstack([self._full_rows(tangent, np.flatnonzero(~free)), self._sums])
        self._inverse, singular = _inverse(matrix, active)
        self._base = None if singular else tangent

    def _replace(self, free, sliding, ratio, rest):
        """Factorise the system that the changed rows' right-hand sides satisfy."""
        rest = np.flatnonzero(rest)
        self._rows = np.concatenate([free, sliding, rest])
        self._ratio = np.concatenate([np.zeros(len(free)), ratio[sliding], np.zeros(len(rest))])
        self._pressing = self._rows.copy()
        self._pressing[len(free) : len(free) + len(sliding)] += self._size // 2
        self._rest = self._known_rows(self.tangent, rest) if len(rest) else np.zeros((0, self._size + self._rigid))
        self._singular = self._base is None
        if len(self._rows):
            self._columns = self._inverse[:, self._rows]
            self._lu, self._pivots, singular = lapack.dgetrf(self._new_rows(self._columns), overwrite_a=True)
            self._singular = self._singular or bool(singular)

    def _new_rows(self, x):
        """The replaced rows of J times ``x`` (mn + m, ...); a sliding one less its ratio times that of the pressure."""
        few = len(self._rows) - len(self._rest)
        images = (x[self._rows[:few]].T - self._ratio[:few] * x[self._pressing[:few]].T).T
        return np.concatenate([images, self._rest @ x])


def _changed(tangent: csr_matrix, other: csr_matrix) -> np.ndarray:
    """Which rows (mn,) of two tangents of one pattern differ."""
    return np.logical_or.reduceat(tangent.data != other.data, tangent.indptr[:-1])


def _inverse(rows: np.ndarray, active: np.ndarray) -> tuple[np.ndarray, bool]:
    """Inverse (n, n) of the matrix whose ``active`` rows (bool (n,)) are ``rows`` (g, n), the others those of the
    identity; and whether it is singular.
    """
    inverse = np.eye(len(active), order="F")
    right = inverse[active]
    right[:, ~active] = -rows[:, ~active]
    *_, inverse[active], singular = lapack.dgesv(rows[:, active], right)
    return inverse, bool(singular)
