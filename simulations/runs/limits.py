"""Limits of the method, named before anything is solved: SceneError with the key and a value that would do.

Every limit is measured (docs/stability.md). All lengths are in contact half-widths.
"""

from collections.abc import Sequence
from math import ceil, expm1, inf, log, log10, sqrt

from analytic import FrettingLoop

from ..fem.contact_problem import ContactProblem
from ..fem.mesh import Grading
from ..loading.schedule import LoadStep
from ..scene import Scene, SceneError, rounded, shown
from ..scene.output import NORMAL
from ..scene.tables import ExponentialCoating, LinearCoating, PowerLawCoating, Tabulated
from ..solvers.newton import ATTAINABLE, FORCE_TOLERANCE, OVER_ROUND_OFF

MOST_UNKNOWNS = 1_000_000  # some minutes, and 3 GB in the factorisation
MOST_MATRIX = 4.0  # GB in the dense matrices of the condensed method
NARROWEST = 3.0  # slip zone over edge_facet: there the energy is off by 5 %, with 1 by 30 %, with 0.2 by 180 %
MOST_AT_ENDS = 0.1  # estimated relative error of the traction from its steep ends alone
LOWEST = 0.05  # the first layer's lowest Gauss point, over its height: 0.07 and more
LOWEST_EXPONENT = -300.0  # decimal logarithm of the smallest ordinary number is -307.7
LEAST_SLIP_LOAD = 1e-7  # Q²/(mu P²): there the tolerance of loads changes the energy by 1 %, at 4e-9 by 27 %
MOST_FRICTION = 1 - 1e-9  # |Q|/(mu P): nearer to 1 what sticks carries less than that tolerance, and slides away
STABLE_GAMMA0 = 0.3  # below it the active set cycles (0.2 at k = 0) or fails (0.1 at k = 0.3), unless theta = -1
STIFFEST = -0.9  # k, below which pressing alone may fail


def check_parameters(scene: Scene):
    """SceneError for Nitsche's parameters with which the contact terms are not stable."""
    gamma0, theta = scene.solver.gamma0, scene.solver.theta
    if gamma0 < STABLE_GAMMA0 and theta > -1:
        raise SceneError(
            f"solver.gamma0 = {gamma0:g} is not allowed with theta = {theta:g}: the contact terms are stable from "
            f"{STABLE_GAMMA0:g} on; the default is 10"
        )


def check_loads(scene: Scene, schedule: Sequence[LoadStep]):
    """SceneError for a Q whose distance from 0, or from mu P, the tolerance of loads hides."""
    share = float(max(abs(step.Q) / step.P for step in schedule))
    key = f"load.{'amplitude' if scene.is_loop else 'points'}"
    if 0 < share < (least := sqrt(LEAST_SLIP_LOAD * scene.mu)):
        raise SceneError(
            f"Q is {share:.2g} P at most, too little beside the tolerance of loads, {FORCE_TOLERANCE:g} P: with "
            f"load.mu = {scene.mu:g} it has to be {rounded(least, up=True):.0e} P or more ({key})"
        )
    if scene.friction and share > MOST_FRICTION * scene.mu:
        raise SceneError(
            f"Q is {share / scene.mu!r} mu P at most, too close to sliding beside the tolerance of loads, "
            f"{FORCE_TOLERANCE:g} P: {MOST_FRICTION!r} mu P or less is allowed ({key})"
        )


def check_depth(scene: Scene, cells: Grading):
    """SceneError for k so close to 1 that dy/ds = s^(k/(1-k))/(1-k), for the mesh depth s, underflows."""

    def underflows(k):
        first = (cells.first_layer / (cells.layer_growth - 1)) ** (1 - k) * expm1((1 - k) * log(cells.layer_growth))
        return k / (1 - k) * log10(LOWEST * first) < LOWEST_EXPONENT

    allowed = scene.k
    while allowed > 0 and underflows(allowed):
        allowed = (ceil(200 * allowed) - 1) / 200
    if allowed < scene.k:
        raise SceneError(
            f"solid.k = {scene.k!r} is too close to 1: dy/ds of the mesh depth s = y^(1-k) underflows in the first "
            f"layer; {allowed:g} or less is possible with this mesh.first_layer and mesh.layer_growth"
        )


def check_output(scene: Scene, schedule: Sequence[LoadStep], extent: float):
    """SceneError for states that the run does not come to, and for points outside the domain."""
    output, reach = scene.output, extent * scene.half_width
    if not isinstance(output.states, str):
        there = [NORMAL, *dict.fromkeys(step.state for step in schedule if step.state)]
        unknown = [name for name in output.states if name not in there]
        if unknown:
            names = ", ".join(there)
            raise SceneError(f"output.states = {shown(list(output.states))} is not allowed: this run has {names}")
    ends = [("lines", line, (line[:2], line[2:4])) for line in output.lines]
    for key, given, points in (*ends, *(("points", point, (point,)) for point in output.points)):
        if any(abs(x) > reach or y > reach for x, y in points):
            raise SceneError(
                f"output.{key}: {shown(list(given))} leaves the domain |x| ≤ {reach:.4g} m, "
                f"0 ≤ y ≤ {reach:.4g} m ({extent:g} contact half-widths)"
            )


def check_size(scene: Scene, cells: Grading, columns: int, layers: int):
    """SceneError for meshes, of so many cells along x and into the depth, that no ordinary machine holds."""
    degree = scene.mesh.degree
    unknowns = 2 * (degree * columns + 1) * (degree * layers + 1)
    keys = "mesh.facet, mesh.edge_facet, mesh.growth, mesh.first_layer, mesh.layer_growth, mesh.extent, mesh.degree"
    if unknowns > MOST_UNKNOWNS:
        raise SceneError(
            f"the mesh is too fine: {columns} x {layers} cells are {unknowns:.2g} unknowns, the limit is "
            f"{MOST_UNKNOWNS:.0e} ({keys})"
        )
    if scene.solver.method == "condensed":
        nodes = degree * min(columns, 2 * cells.strip / min(cells.facet, cells.edge_facet))
        forces = 2 * nodes
        compliance = 3 * forces * forces  # displacements of the nodes of the surface cells, three layers for degree 2
        jacobian = 4 * forces**2  # itself, the inverses of two of them, and the rows that are kept
        size = 8e-9 * (compliance + jacobian)
        if size > MOST_MATRIX:
            raise SceneError(
                f"the mesh is too fine: {nodes:.0f} surface nodes make dense matrices of {size:.0f} GB, the limit is "
                f"{MOST_MATRIX:g} (mesh.facet, mesh.edge_facet, mesh.growth, mesh.degree; or solver.method)"
            )


def check_resolution(scene: Scene, cells: Grading, loop: FrettingLoop | None):
    """SceneError where the mesh cannot show what the scene is about: the slip zone, or ends steeper than its facets.

    The zones are those of the closed form; coupling moves them but does not make them wider.
    """
    facet, key = min((cells.edge_facet, "edge_facet"), (cells.facet, "facet"))
    if loop is not None:
        slip = loop.a - loop.c
        if slip < NARROWEST * facet:
            raise SceneError(
                f"mesh.edge_facet = {cells.edge_facet:g} is too coarse: the slip zone is {slip:.2g} a wide at "
                f"load.amplitude = {scene.load.amplitude} and needs {rounded(slip / NARROWEST):g} or less"
            )
    if scene.k >= 0:
        return
    name, size = max((key, facet), ("first_layer", cells.first_layer), key=lambda entry: entry[1])
    needed = size_for(MOST_AT_ENDS, scene.k)
    if size > needed:
        raise SceneError(
            f"mesh.{name} = {size:g} is too coarse for k = {scene.k:g}: tractions that end so steeply would be off by "
            f"about {expected_error(scene.k, size):.0%}; {rounded(needed):g} or less keeps that below "
            f"{MOST_AT_ENDS:.0%}"
        )


def expected_error(k: float, size: float) -> float:
    """Relative L2 error of a traction that ends like distance^((1+k)/2) on cells of ``size`` a, to a factor of two.

    The distance's power leaves size^(1 + k/2); the factor is fitted to loops from k = -0.9 to 0.
    """
    return 0.1 / (1 + k) * size ** (1 + k / 2)


def size_for(error: float, k: float) -> float:
    """The inverse of ``expected_error``: cells, over a, on which a traction ends with this error."""
    return (error * (1 + k) / 0.1) ** (1 / (1 + k / 2))


def check_round_off(scene: Scene, cells: Grading, problem: ContactProblem):
    """SceneError where the surface cells are so stiff that the last digits of the displacement are contact forces.

    Displacements are of order one, in P/E(a).
    """
    attainable = OVER_ROUND_OFF * problem.terms.force_per_digit
    if attainable > ATTAINABLE:
        left = f"round-off would leave forces of {attainable:.0e} P unbalanced ({FORCE_TOLERANCE:.0e} is the aim)"
        factor = (attainable / ATTAINABLE) ** (1 / (1 - scene.k))
        thickness = getattr(scene.material, "thickness", inf)
        if thickness < cells.first_layer * scene.half_width:  # the first layer ends where the coating does
            would = f"{rounded(factor * thickness, up=True):g} m or more would do, or the substrate without coating"
            key = "solid.thickness" if "thickness" in scene.solid.given() else "the last depth of solid.points"
            raise SceneError(f"{key} = {thickness:.3g} m is too thin for cells of its own: {left}; {would}")
        thicker = cells.first_layer * factor
        thicker = rounded(thicker * cells.layer_growth, up=True)  # fitted layers may be lower by this
        would = f"{thicker:g} or more would do"
        if scene.k < 0 and thicker > size_for(MOST_AT_ENDS, scene.k):
            would = "no height that the steep ends of the traction allow would do: a smaller solver.gamma0 is needed"
        raise SceneError(
            f"mesh.first_layer = {cells.first_layer:g} is too thin for k = {scene.k:g} and solver.gamma0 = "
            f"{scene.solver.gamma0:g}: {left}; {would}"
        )


def too_wide(scene: Scene, strip: float) -> str:
    """What to say of a contact that ends beyond the strip |x| < ``strip`` a, with the keys that make it so wide."""
    words = f"the contact reaches the end of |x| < {strip * scene.half_width:.3g} m, in which it is looked for"
    coating = coating_keys(scene)
    if coating:
        words += f"; {coating} make it wider than on a half-plane of the modulus at the depth a: a thicker coating"
        words += " or one nearer to its substrate is needed"
    return words


def too_stiff(scene: Scene) -> str:
    """What to say of a load step without friction that has no answer; "" where k is not the reason."""
    if scene.k >= STIFFEST:
        return ""
    return (
        "k is so close to -1 that round-off of the stiff surface makes the tangent singular: a larger mesh.first_layer "
        "and mesh.edge_facet, a smaller mesh.extent or mesh.degree = 1 may help"
    )


def coating_keys(scene: Scene) -> str:
    """Keys and values of a coating in a message; "" where there is none."""
    solid = scene.solid
    if isinstance(solid, PowerLawCoating):
        return f"solid.thickness = {solid.thickness:.3g} m and solid.k = {solid.k:g}"
    if isinstance(solid, (LinearCoating, ExponentialCoating)):
        ratio = solid.E_substrate / solid.E0
        return f"solid.thickness = {solid.thickness:.3g} m and solid.E_substrate = {ratio:.3g} solid.E0"
    if isinstance(solid, Tabulated):
        return f"solid.points down to {solid.thickness:.3g} m"
    return ""
