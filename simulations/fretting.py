"""Press a rigid cylinder onto a graded half-plane and rock it:  python -m simulations.fretting [SCENE.toml]."""

from .command import comm, on_root, read_request, run, say, set_petsc_options
from .explain import explain
from .results import FILES, Results
from .scene import DEFAULT_SCENE
from .simulation import Simulation


def main(arguments: list[str], program: str = "simulations.fretting", description=__doc__, default=DEFAULT_SCENE):
    """Read the scene, run it, keep what it yields, and print the results beside the closed form."""
    request = on_root(lambda: read_request(arguments, program, description, default))
    set_petsc_options(request.petsc)
    say("preparing mesh and forms (the first run compiles them, some ten seconds)")
    simulation = Simulation(comm, request.scene)
    if request.explain:
        say(explain(simulation))
        return
    total = len(simulation.programme)
    say(f"{request.scene['title'] or 'fretting'}: {simulation.body.unknowns} unknowns, {comm.size} rank(s)")
    with Results(request.output, simulation) as results:
        for number, entry in enumerate(simulation.run(), start=1):
            results.record(entry)
            say(f"{number:4d}/{total}  {describe(entry, simulation)}")
    if comm.rank == 0:
        say(f"\n{results.table()}")
        seconds = "  ".join(f"{phase} {value:.1f} s" for phase, value in results.summary["seconds"].items())
        say(f"{results.summary['newton_iterations']} Newton iterations;  {seconds}")
        say(f"written to {request.output}: {', '.join(FILES)}")


def describe(entry, simulation: Simulation) -> str:
    """One line of progress."""
    increment = entry.increment
    load = f"P = {increment.P:.3f} P_max   a = {entry.a * simulation.scaled.scales.length:.4g} m"
    if increment.branch != "normal":
        share = f"Q/(mu P) = {increment.Q / (simulation.mu * increment.P):+.3f}   c/a = {entry.c / entry.a:.4f}"
        load = share if simulation.scene.is_loop else f"P = {increment.P:.3f} P_max   {share}"
    cuts = f", {entry.cuts} cuts" if entry.cuts else ""
    return f"{increment.branch:9s} {load}   {entry.iterations} iterations{cuts}, {entry.seconds:.2f} s"


if __name__ == "__main__":
    run(main)
