"""The body in parts that do not see each other: its symmetric and its antisymmetric half, where it has a mirror.

On a mesh that is its own mirror image in x = 0 every field is the sum of one whose u_x is odd and one whose u_x is
even. Each is known from one half, and has a stiffness of its own there; the first from x <= 0, the second from x >= 0:
two ranks that own one half each find in it what they need.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_matrix

from forms.contact import X, Y

from ...fem.body import ElasticBody
from ...fem.parallel import gathered

SAME_POSITION = 1e-11  # positions closer than this (over the extent of the mesh) are the same
EVEN, ODD = 1.0, -1.0
NONE = np.array([], dtype=int)


@dataclass(frozen=True)
class Part:
    """Unknowns of one half, or of the whole body; numbers are global dofs, sorted.

    dofs: (h,) those on one side; mirrored: (o,) indices in ``dofs`` of those off the axis; images: (o,) their mirror
    images; signs: (o,) what an image is to them. A whole body has none of these.
    """

    dofs: np.ndarray
    is_half: bool = False
    mirrored: np.ndarray = field(default_factory=lambda: NONE)
    images: np.ndarray = field(default_factory=lambda: NONE)
    signs: np.ndarray = field(default_factory=lambda: NONE)

    @property
    def on_axis(self) -> np.ndarray:
        """(h,) True on the axis of a half."""
        axis = np.full(len(self.dofs), self.is_half)
        axis[self.mirrored] = False
        return axis

    def restrict(self, forces: np.ndarray) -> np.ndarray:
        """Forces (h, ...) on this part from those (N, ...) on the body; half of one on the axis."""
        part = self.matrix(len(forces)).T @ forces
        return part / 2.0 if self.is_half else part

    def own(self, displacements: np.ndarray) -> np.ndarray:
        """What of displacements (N,) of the body, or of other values at its dofs, is this part's (h,)."""
        return self.restrict(displacements) * np.where(self.on_axis, 2.0, 1.0)

    def matrix(self, size: int) -> csr_matrix:
        """Displacements of the body from those of this part, (size, h)."""
        h = np.arange(len(self.dofs))
        rows, columns = np.concatenate([self.dofs, self.images]), np.concatenate([h, self.mirrored])
        values = np.concatenate([np.ones(len(h)), self.signs])
        return csr_matrix((values, (rows, columns)), shape=(size, len(h)))

    def among(self, chosen: np.ndarray) -> "Part":
        """The same for the dofs ``chosen`` (sorted, their own mirror image), numbered by their place among them."""
        place = np.cumsum(np.isin(self.dofs, chosen)) - 1
        kept = np.isin(self.dofs[self.mirrored], chosen)
        return Part(
            np.searchsorted(chosen, self.dofs[np.isin(self.dofs, chosen)]),
            self.is_half,
            place[self.mirrored[kept]],
            np.searchsorted(chosen, self.images[kept]),
            self.signs[kept],
        )


def parts(body: ElasticBody) -> list[Part]:
    """The symmetric and the antisymmetric part, or the whole body where it is not its own mirror image."""
    position, parity, kind = _positions(body)
    columns, column = _levels(position[:, 0])
    rows, row = _levels(position[:, 1])
    whole = Part(np.arange(len(parity)))
    asymmetry = np.abs(columns + columns[::-1]).max()
    if body.is_half or len(columns) % 2 == 0 or asymmetry > SAME_POSITION * np.abs(columns).max():
        return [whole]
    number = np.full((kind.max() + 1, len(columns), len(rows)), -1)
    number[kind, column, row] = np.arange(len(parity))
    images = number[kind, len(columns) - 1 - column, row]
    middle = len(columns) // 2
    halves = []
    for signs, beside in ((parity, column < middle), (-parity, column > middle)):
        dofs = np.flatnonzero(beside | ((column == middle) & (signs > 0)))
        mirrored = np.flatnonzero(beside[dofs])
        halves.append(Part(dofs, True, mirrored, images[dofs[mirrored]], signs[dofs[mirrored]]))
    return halves if _is_mirror_image(body, halves[0], len(parity)) else [whole]


def _positions(body):
    """Of all dofs: positions (N, 2), signs (N,) of their images in a symmetric field, and kinds (N,)."""
    owned = body.stiffness.getLocalSize()[0]
    position, parity, kind = np.zeros((owned, 2)), np.zeros(owned), np.zeros(owned, dtype=int)
    x = body.displacements.tabulate_dof_coordinates()[: body.owned_nodes, :2]
    for direction, sign in ((X, ODD), (Y, EVEN)):
        dofs = body.dofs[: body.owned_nodes, direction]
        position[dofs], parity[dofs], kind[dofs] = x, sign, direction
    if body.mixed:
        space, dofs = body.space.sub(1).collapse()
        n = space.dofmap.index_map.size_local
        dofs = np.asarray(dofs)[:n]
        position[dofs], parity[dofs], kind[dofs] = space.tabulate_dof_coordinates()[:n, :2], EVEN, 2
    return tuple(gathered(body.mesh.comm, values) for values in (position, parity, kind))


def _levels(values):
    """Distinct ``values`` (m,), equal up to round-off, and for each of them its level (n,)."""
    ordered = np.sort(values)
    new = np.diff(ordered) > SAME_POSITION * np.abs(ordered).max()
    lowest = ordered[np.concatenate([[True], new])]
    return lowest, np.searchsorted(lowest, values, side="right") - 1


def _is_mirror_image(body, half, size):
    """Whether forces of a symmetric field are symmetric: what is put into the body may not be."""
    displacement, force = body.stiffness.createVecs()
    first, last = body.stiffness.getOwnershipRange()
    extend = half.matrix(size)
    displacement.array[:] = (extend @ np.cos(np.arange(len(half.dofs))))[first:last]
    body.stiffness.mult(displacement, force)
    force = gathered(body.mesh.comm, force.array_r)
    symmetric = extend @ half.own(force)
    return np.abs(force - symmetric).max() < 1e-9 * np.abs(force).max()
