"""What a scene will simulate, before anything is solved."""

from .simulation import Simulation


def explain(simulation: Simulation) -> str:
    """The effects with their reasons and what is left out, then the sizes of the problem."""
    body, solver = simulation.body, simulation.scene["solver.method"]
    problems = [simulation.solver.problem, simulation.solver.frictional]
    terms = {0: "tangential traction", 1: "contact pressure"}
    lines = [str(effect) for effect in simulation.effects.listed]
    lines.append(f"{'displacement unknowns':26s} {body.unknowns}")
    for stage, problem in zip(("normal stage", "tangential stage"), problems):
        if problem is not None:
            unknown = " and ".join(terms[i] for i in problem.directions)
            lines.append(f"{stage:26s} {unknown}, {len(problem.directions)} rigid displacement(s), {solver} Newton")
    lines.append(f"{'surface nodes':26s} {simulation.sampler.x.size}")
    lines.append(f"{'increments':26s} {len(simulation.programme)}")
    return "\n".join(lines)
