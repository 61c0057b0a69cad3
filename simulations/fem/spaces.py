"""Function spaces of the body: displacements, in the mixed form the mean stress too, and values at surface points."""

from dataclasses import dataclass

import basix.ufl
import numpy as np
from dolfinx import fem


@dataclass(frozen=True)
class Spaces:
    """space: of all unknowns; displacements: of u alone; dofs (n, 2): where in ``space`` the displacements of node n
    are; points: of one value at every node of every cell.
    """

    space: fem.FunctionSpace
    displacements: fem.FunctionSpace
    dofs: np.ndarray
    points: fem.FunctionSpace


def create_spaces(mesh, degree: int, mixed: bool) -> Spaces:
    """Lagrange elements of ``degree``, 1 to 3; mixed: with a mean stress of one degree less (Taylor and Hood)."""
    cell = mesh.basix_cell()
    element = basix.ufl.element("Lagrange", cell, degree, shape=(2,))
    if mixed:
        pair = basix.ufl.mixed_element([element, basix.ufl.element("Lagrange", cell, degree - 1)])
        space = fem.functionspace(mesh, pair)
        displacements, dofs = space.sub(0).collapse()
    else:
        space = displacements = fem.functionspace(mesh, element)
        dofs = np.arange(2 * len(space.tabulate_dof_coordinates()))
    dofs = np.asarray(dofs, dtype=np.int32).reshape(-1, 2)
    return Spaces(space, displacements, dofs, fem.functionspace(mesh, ("DG", degree)))
