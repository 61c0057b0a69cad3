"""Press a rigid cylinder onto a graded half-plane and rock it:  python -m simulations.fretting [SCENE.toml]."""

from .command import comm, on_root, read_request, run, say, set_petsc_options
from .estimate import coarser, estimated, expectation
from .explain import explain
from .output import write_summary
from .results import FILES, Results
from .scene import DEFAULT_SCENE
from .simulation import Simulation


def main(arguments: list[str], program: str = "simulations.fretting", description=__doc__, default=DEFAULT_SCENE):
    """Read the scene, run it, keep what it yields, and print the results beside the closed form."""
    request = on_root(lambda: read_request(arguments, program, description, default))
    set_petsc_options(request.petsc)
    say("preparing mesh and forms (the first run compiles them, about a minute)")
    simulation = Simulation(comm, request.scene)
    if request.explain:
        say(explain(simulation))
        return
    if "solver.accuracy" in request.scene.values:
        say(expectation(request.scene))
    total = len(simulation.programme)
    say(f"{request.scene['title'] or 'fretting'}: {simulation.body.unknowns} unknowns, {comm.size} rank(s)")
    with Results(request.output, simulation) as results:
        for number, entry in enumerate(simulation.run(), start=1):
            results.record(entry)
            say(f"{number:4d}/{total}  {describe(entry, simulation)}")
    if "solver.accuracy" in request.scene.values:
        judge(request, simulation, results)
    if comm.rank == 0:
        say(f"\n{results.table()}")
        seconds = "  ".join(f"{phase} {value:.1f} s" for phase, value in results.summary["seconds"].items())
        say(f"{results.summary['newton_iterations']} Newton iterations;  {seconds}")
        say(f"written to {request.output}: {', '.join(FILES)}")


def judge(request, simulation: Simulation, results: Results):
    """Say the error found, or estimated where there is no closed form, beside the accuracy asked for; keep it in
    the summary.
    """
    scene = request.scene
    exact = scene.has_closed_form
    if exact:
        errors = comm.bcast(results.summary.get("errors"))
    else:
        say("second mesh, for the estimate of the error")
        other, ratio = coarser(comm, scene)
        for _ in other.run():
            pass
        errors = estimated(simulation, other, ratio)
    name, largest = max(((name, abs(value)) for name, value in errors.items()), key=lambda item: item[1])
    wanted, kind = scene["solver.accuracy"], "found" if exact else "estimated, not measured"
    verdict = "within" if largest <= wanted else "NOT within"
    say(f"largest error {largest:.1e} ({name}; {kind}): {verdict} {wanted:g}")
    if comm.rank == 0:
        results.summary["accuracy"] = {
            "wanted": wanted,
            "largest_error": largest,
            "is_estimate": not exact,
            "errors": errors,
        }
        write_summary(request.output / "summary.json", results.summary)


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
