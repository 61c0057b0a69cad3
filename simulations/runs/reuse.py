"""Whether a scene can be run on the body of an earlier simulation: the same solid, and the mesh that it asks for."""

from dataclasses import astuple

import numpy as np

from ..fem.mesh import Grading
from ..scene import SceneError
from .limits import check_depth, check_resolution
from .plan import Plan

SIZES = ("facet", "edge_facet", "growth", "first_layer", "layer_growth", "extent", "edge_at")
LARGER_FACETS = 1.01  # facets at an edge over those that a mesh of its own would have there


def why_not(previous: Plan, have: Grading, mesh_of: tuple | None, new: Plan) -> str | None:
    """Why the body of ``previous`` does not do for ``new``, in one line; None where it does.

    have: the cells of its mesh; mesh_of: what these were graded for, ``Plan.graded_for`` of a scene, if that is known.
    It does where solid, effects on the body, degree and cell sizes are the same, and where the mesh is as fine at the
    edges of contact and stick of the new scene as one of its own would be.
    """
    if mesh_of is not None and mesh_of == new.graded_for:
        return None
    mine, theirs = new.scaled.modulus, previous.scaled.modulus
    same = type(mine) is type(theirs) and np.allclose(
        astuple(mine), astuple(theirs), rtol=1e-12, atol=0  # type: ignore[call-overload]
    )
    if not same or new.scene.solid.nu != previous.scene.solid.nu:
        return "another solid: k, nu, or the depth y0 over a, or the coating"
    for name in ("symmetry", "incompressibility", "bulk strain"):
        if (name in new.effects) != (name in previous.effects):
            return f"the effect {name} is on in one of them only"
    if any(plan.effects.works(plan.scene, plan.scaled.scales) for plan in (new, previous)):
        return "an effect adds to the stiffness of the body"
    if new.scene.mesh.degree != previous.scene.mesh.degree:
        return f"mesh.degree = {new.scene.mesh.degree}, not {previous.scene.mesh.degree}"
    wanted = new.grading()
    for name in SIZES:
        if not np.isclose(getattr(wanted, name), getattr(have, name), rtol=1e-12, atol=0):
            return f"mesh.{name} = {getattr(wanted, name):g}, not {getattr(have, name):g}"
    if wanted.strip > have.strip:
        return f"the contact is looked for on |x| < {wanted.strip:.3g} a, not {have.strip:.3g} a"
    places = np.array([*wanted.edges, *(x for left, right, _ in wanted.sweeps for x in np.linspace(left, right, 101))])
    coarse = places[have.facet_size(places) > LARGER_FACETS * wanted.facet_size(places)]
    if coarse.size:
        return f"its mesh is too coarse where contact or stick may end, at x = {np.abs(coarse).max():.3g} a"
    try:
        check_resolution(new.scene, have, new.loop)
        check_depth(new.scene, have)
    except SceneError as error:
        return str(error)
    return None
