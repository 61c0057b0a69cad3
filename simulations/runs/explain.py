"""Text of --explain: the physics that a scene will simulate, before anything is solved."""

from forms.contact import X, Y

from ..loading.fallbacks import explained
from . import critical_friction
from .simulation import Simulation

TERMS = {X: "tangential traction", Y: "contact pressure"}


def explain(simulation: Simulation) -> str:
    """The effects with their reasons and what is left out, then the sizes of contact and problem, and warnings."""
    body, solver, stepping = simulation.body, simulation.scene.solver, simulation.stepping
    problems = [stepping.normal, stepping.frictional]
    about, scales = "" if simulation.contact else "about ", simulation.scaled.scales
    size = f"{about}a = {scales.length:.4g} m, mean pressure P/(2a) = {about}{scales.stress / 2:.4g} Pa"
    lines = [str(simulation.effects), f"{'contact':26s} {size}", f"{'unknowns':26s} {body.unknowns}"]
    for stage, problem in zip(("normal stage", "tangential stage"), problems):
        if problem is not None:
            unknown = " and ".join(TERMS[i] for i in problem.directions)
            rigid = f"{len(problem.directions)} rigid displacement(s)"
            lines.append(f"{stage:26s} {unknown}, {rigid}, {solver.method} Newton")
    if solver.theta != 0:
        why = f"solver.theta = {solver.theta:g} needs it: every displacement is an unknown"
        lines.append(f"{'full Newton':26s} {why}, which takes longer")
    critical = critical_friction.expected(simulation.scene, simulation.effects)
    if critical is not None:
        lines.append(f"{'critical friction':26s} {critical_friction.describe(simulation.scene, critical)}")
    edges = ", ".join(f"{edge:.4g}" for edge in simulation.cells.edges if edge > 0)
    lines.append(f"{'surface nodes':26s} {simulation.sampler.x.size}, graded to x/a = ±{edges}")
    lines.append(f"{'load steps':26s} {len(simulation.schedule)}")
    last = stepping.frictional or stepping.normal
    lines += [f"{'solved by' if i == 0 else '':26s} {way}" for i, way in enumerate(explained(last))]
    lines += [f"{'warning':26s} {words}" for words in simulation.warnings]
    return "\n".join(lines)
