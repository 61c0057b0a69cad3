"""Press a rigid cylinder onto a graded half-plane and rock it:  python -m simulations.fretting [SCENE.toml]."""

import sys

from .command.command import comm, on_root, read_request, run, say, set_petsc_options
from .command.progress import Progress
from .output import checkpoint
from .output.files import write_summary
from .output.results import Results, begin, files
from .run.estimate import coarser, estimated, expectation
from .run.explain import explain
from .run.simulation import Simulation
from .scene import DEFAULT_SCENE


def main(arguments: list[str], program: str = "simulations.fretting", description=__doc__, default=DEFAULT_SCENE):
    """Read the scene, run it, keep what it yields, and print the results beside the closed form."""
    request = on_root(lambda: read_request(arguments, program, description, default))
    saved, folder = request.saved, request.output
    if saved and saved.complete:
        say(f"{folder} is complete: nothing is left to do")
        return
    if not request.explain and not saved:
        on_root(lambda: begin(folder, request.scene))
    if not request.quiet:
        say("preparing mesh and forms (the first run compiles them, some ten seconds)")
    set_petsc_options(request.petsc)
    simulation = Simulation(comm, request.scene, saved.cells if saved else None)
    if request.explain:
        say(explain(simulation))
        return
    if saved and saved.increments:
        checkpoint.restore(saved, simulation)
    go(simulation, folder, request.quiet, f"python -m {program} --resume {folder}")


def go(simulation: Simulation, folder, quiet: bool, again: str):
    """Run to the end, with files in ``folder`` and progress; ``again`` is the command that goes on if it stops."""
    progress = Progress(simulation, quiet)
    title = simulation.scene.title or "fretting"
    progress.say(f"{title}: {simulation.body.unknowns} unknowns, {comm.size} rank(s)")
    if simulation.scene.solver.accuracy is not None:
        progress.say(expectation(simulation.scene))
    if simulation.history.entries:
        progress.say(f"going on after increment {len(simulation.history.entries)}/{progress.total}")
    try:
        with Results(folder, simulation, again) as results:
            for entry in simulation.run():
                results.record(entry)
                progress.step(entry)
    except KeyboardInterrupt as stop:
        say(f"{stop or 'interrupted'}; go on with {again}", file=sys.stderr)
        raise
    if simulation.scene.solver.accuracy is not None:
        judge(simulation, results, folder, progress)
    if comm.rank == 0:
        progress.say(f"\n{results.table()}")
        seconds = "  ".join(f"{phase} {value:.1f} s" for phase, value in results.summary["seconds"].items())
        progress.say(f"{results.summary['newton_iterations']} Newton iterations;  {seconds}")
        progress.say(f"written to {folder}: {', '.join(files())}")


def judge(simulation: Simulation, results: Results, folder, progress: Progress):
    """Say the error found, or estimated where there is no closed form to find it by, beside the accuracy asked for;
    and keep it.
    """
    scene = simulation.scene
    errors = comm.bcast(results.summary.get("errors")) if simulation.effects.has_closed_form else None
    exact = errors is not None
    if not exact:
        progress.say("second mesh, for the estimate of the error")
        other, ratio = coarser(comm, scene)
        errors = estimated(simulation, other.run_to_end(), ratio)
    name, largest = max(((name, abs(value)) for name, value in errors.items()), key=lambda item: item[1])
    wanted, kind = scene.solver.accuracy, "found" if exact else "estimated, not measured"
    verdict = "within" if largest <= wanted else "NOT within"
    progress.say(f"largest error {largest:.1e} ({name}; {kind}): {verdict} {wanted:g}")
    if comm.rank == 0:
        results.summary["accuracy"] = {
            "wanted": wanted,
            "largest_error": largest,
            "is_estimate": not exact,
            "errors": errors,
        }
        write_summary(folder / "summary.json", results.summary)


if __name__ == "__main__":
    run(main)
