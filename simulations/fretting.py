"""Press a rigid cylinder onto a graded half-plane and rock it:  python -m simulations.fretting [SCENE.toml]."""

import sys

from .command.arguments import Request, command_line, read_request, set_petsc_options
from .command.command import comm, on_root, run, say
from .command.progress import Progress
from .command.stopping import stopping
from .output import checkpoint
from .output.folder import begin, claimed, files, go_on, lost_table
from .output.results import Results
from .output.table import table
from .runs.checks import ChecksFailed
from .runs.estimate import expectation, judged
from .runs.explain import explain
from .runs.reference import expected_seconds
from .runs.report_data import find
from .runs.simulation import Simulation
from .runs.timing import Stopwatch
from .scene import DEFAULT_SCENE, SceneError


def main(
    arguments: list[str],
    program: str = "simulations.fretting",
    description=__doc__,
    default=DEFAULT_SCENE,
    has_friction: bool = True,
):
    """Read the scene, run it, keep what it yields, and print the results beside the reference."""
    request = on_root(lambda: read_request(arguments, program, description, default))
    if request.scene.friction and not has_friction:
        raise SceneError(f"load.mu = {request.scene.mu:g} is not allowed with {program}: simulations.fretting takes it")
    set_petsc_options(request.petsc)
    if request.explain:
        say(explain(Simulation(comm, request.scene)))
        return
    folder = request.output
    if request.resume and on_root(lambda: checkpoint.is_complete(folder)):
        lost = on_root(lambda: lost_table(folder))
        if lost:
            why = f"the run is complete, but its {lost} is missing"
            raise SceneError(f"--resume {folder}: {why}; start again, in another folder or with --overwrite")
        if not request.quiet:
            say(f"{folder} is complete: nothing is left to do")
        failing = on_root(lambda: checkpoint.failing_checks(folder))
        if failing:
            raise ChecksFailed(f"checks that fail: {', '.join(failing)}")
        return
    with claimed(comm, folder, request.scene_file, request.overwrite, request.resume):
        stopping.tell(f"start again with {request.command}")
        progress = Progress(request.quiet)
        simulation = prepare(request, progress)
        again = command_line(program, "--resume", str(folder), *request.petsc)
        go(simulation, folder, progress, again)


def prepare(request: Request, progress: Progress) -> Simulation:
    """A simulation that is ready to run, where an earlier run was left if there is one. Writes nothing before that."""
    saved = on_root(lambda: checkpoint.load(request.output)) if request.resume else None
    watch = Stopwatch(progress.phase)
    simulation = Simulation(comm, request.scene, saved.cells if saved else None, watch=watch)
    if saved:
        checkpoint.restore(saved, simulation)
        on_root(lambda: go_on(request.output))
    else:
        on_root(lambda: begin(request.output, request.scene))
    return simulation


def go(simulation: Simulation, folder, progress: Progress, again: str):
    """Run to the end, with files in ``folder`` and progress; ``again`` is the command that goes on if it stops."""
    title = simulation.scene.title or "fretting"
    progress.say(f"{title}: {simulation.body.unknowns} unknowns, {comm.size} rank(s)")
    if simulation.scene.solver.accuracy is not None:
        progress.say(expectation(simulation.scene))
    for words in simulation.warnings:
        say(f"warning: {words}", file=sys.stderr)
    progress.begin(simulation, expected_seconds(simulation))
    if simulation.history.entries:
        progress.say(f"going on after increment {len(simulation.history.entries)}/{progress.total}")
    with Results(folder, simulation, again) as results:
        stopping.tell(f"go on with {again}", results.keep)
        for entry in simulation.run():
            results.record(entry)
            progress.step(entry)
        results.write_tables()
        findings = find(simulation, progress.reference) if comm.rank == 0 else None
        results.end(findings)
    if simulation.scene.solver.accuracy is not None:
        stopping.tell(f"the run is done, but its accuracy is not judged: {folder}")
        results.judge(*judged(simulation, findings.exact if findings else None, progress.say))
    stopping.tell(f"the run is done: {folder}")
    if findings:
        progress.say(f"\n{table(findings, simulation.history.has_cycle)}")
        seconds = "  ".join(f"{phase} {value:.1f} s" for phase, value in results.summary["seconds"].items())
        progress.say(f"{results.summary['newton_iterations']} Newton iterations;  {seconds}")
        progress.say(f"written to {folder}: {', '.join(files(folder))}")
    if results.failing:
        raise ChecksFailed(results.failing)


if __name__ == "__main__":
    run(main)
