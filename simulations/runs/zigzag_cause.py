"""Why tractions of a finished run zigzag: the critical coefficient of friction, also that of its own mesh."""

from analytic.half_plane.critical_friction import RateOperator, sliver_singular

from ..solvers.condensed.system import CondensedSystem
from .critical_friction import describe, elastic_slip, expected
from .simulation import Simulation

OTHER_METHOD = "solver.theta = 0 or a larger solver.gamma0 may help"
PLACES = 12  # of a sliver on the mesh
MOST_NODES = 400  # surface nodes in contact for which the mesh's own bound is looked for


def critical_of_mesh(simulation: Simulation) -> float | None:
    """Smallest mu known to leave the rates on the mesh of a finished run without a unique solution. On rank 0.

    inf where none is known; None without coupling, without the condensed system, for too many nodes in contact, and
    on other ranks.
    """
    system = simulation.stepping.system
    if simulation.body.mesh.comm.rank:
        return None
    closed = simulation.history.entries[-1].surface.pressure > 0
    is_small = 3 <= closed.sum() <= MOST_NODES
    if "coupling" not in simulation.effects or not isinstance(system, CondensedSystem) or not is_small:
        return None
    compliance, m = system.compliance.nodal(closed), int(closed.sum())
    x, y = slice(m), slice(m, 2 * m)
    blocks = (compliance[row, column] for row in (x, y) for column in (x, y))
    return sliver_singular(RateOperator.from_compliance(*blocks), PLACES)[0]


def cause(simulation: Simulation) -> str:
    """Why tractions may go up and down from node to node, and what can be done. On rank 0."""
    scene = simulation.scene
    critical, own = expected(scene, simulation.effects), critical_of_mesh(simulation)
    slip = elastic_slip(simulation)
    remedy = f"{slip}, a smaller load.mu or another mesh.degree may help"
    states = 'mesh.edges = "states", ' if scene.is_loop and scene.mesh.edges == "turns" else ""
    smoother = f"{slip}, {states}a smaller mesh.edge_facet or another number of solver.increments may help"
    if scene.solver.theta > 0:
        return f"with solver.theta = {scene.solver.theta} not every gamma0 is stable: {OTHER_METHOD}"
    if critical is None:
        return f"without coupling it is the mesh or the load steps, not friction: {smoother}"
    if own is None:
        return f"{describe(scene, critical)}: {remedy if scene.mu > critical.lower else smoother}"
    if scene.mu >= own:
        lost = "from where on Coulomb's law has no unique rate solution on this mesh"
        return f"mu = {scene.mu:g} is above {own:.3g}, {lost}: {remedy}"
    known = "up to where no second rate solution is known on this mesh"
    return f"mu = {scene.mu:g} is below {own:.3g}, {known}: {smoother}"
