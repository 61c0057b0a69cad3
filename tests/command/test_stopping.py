"""A run that is stopped at any moment ends in one line with the command that goes on, and reaches the same numbers."""

import json
import os
import random
import signal
import threading
import time
from subprocess import PIPE

import numpy as np
import pytest
from running import coarse_arguments, ranks_of, run_command, start_python, surface

from simulations.command.arguments import command_line

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
MOMENTS = {1: 12, 2: 8}  # by ranks
LINE = ("go on with python -m simulations.fretting --resume", "start again with python -m simulations.fretting")
DONE = "the run is done"


def start(*arguments, ranks=1, options=(), module="simulations.fretting"):
    return start_python("-u", *options, "-m", module, *arguments, ranks=ranks, stdout=PIPE, stderr=PIPE)


def stopped(process, victim, number, after):
    """Exit code and stderr of a process whose ``victim`` gets the signal so many seconds after its first word."""
    watchdog = threading.Timer(300, process.kill)
    watchdog.start()
    try:
        assert os.read(process.stdout.fileno(), 1)
        time.sleep(after)
        try:
            os.kill(victim(), number)
        except (ProcessLookupError, IndexError, FileNotFoundError):
            pass  # it was faster
        _, said = process.communicate()
        return process.returncode, said.decode()
    finally:
        watchdog.cancel()


def test_what_is_to_be_typed_goes_by_docker_run_where_that_was_used(monkeypatch):
    monkeypatch.setenv("GRADED_FRETTING_RUN", "/my folder/docker/run")
    said = command_line("simulations.fretting", "--resume", "one run")
    assert said == "'/my folder/docker/run' python -m simulations.fretting --resume 'one run'"
    monkeypatch.delenv("GRADED_FRETTING_RUN")
    assert command_line("simulations.sweep") == "python -m simulations.sweep"


def files_of(folder):
    return {path.name for path in folder.iterdir()} if folder.exists() else set()


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    """Folder of a run that nobody stops, and the seconds from its first word to its end."""
    folder = tmp_path_factory.mktemp("uninterrupted")
    process = start(*coarse_arguments(folder, solid__nu=0.3, effects__coupling="false"))
    os.read(process.stdout.fileno(), 1)
    begin = time.monotonic()
    process.communicate()
    assert process.returncode == 0
    return folder, time.monotonic() - begin


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_stopped_at_random_moments(ranks, uninterrupted, tmp_path):
    """Stopped and gone on with, over and over, until it has been stopped MOMENTS times; every run that gets to its end
    has the numbers of the one that was not stopped.
    """
    expected, seconds = uninterrupted
    chance, stops, runs = random.Random(18 + ranks), 0, 0
    while stops < MOMENTS[ranks]:
        runs += 1
        folder, code = tmp_path / str(runs), None
        while code != 0:
            again = ["--resume", folder] if (folder / "scene.toml").exists() else None
            again = again or coarse_arguments(folder, solid__nu=0.3, effects__coupling="false")
            if stops >= MOMENTS[ranks]:
                done = run_command(*again, ranks=ranks)
                assert done.returncode == 0, done.stderr
                break
            number = SIGNALS[stops % 3]
            process = start(*again, ranks=ranks)

            def victim(process=process, number=number):
                if ranks == 1 or number != signal.SIGKILL:
                    return process.pid
                return ranks_of(process.pid)[chance.randrange(ranks)]

            code, said = stopped(process, victim, number, chance.uniform(0.0, seconds))
            if code != 0:
                stops += 1
                is_done = files_of(folder) == files_of(expected)
                is_silent = not said or number == signal.SIGKILL and " by " not in said.partition("prterun")[0]
                if ranks > 1 and is_done and is_silent:
                    continue  # after the last words: mpirun passed no signal on, or a rank was killed as it ended
                check_ending(code, said, number, ranks)
        mine, theirs = surface(folder), surface(expected)
        for name in ("pressure", "traction", "slip"):
            assert np.abs(mine[name] - theirs[name]).max() <= 1e-10 * np.abs(theirs[name]).max(), name
        assert json.loads((folder / "summary.json").read_text())["converged"] is True
        # a signal in the last moments leaves the lock to the next command; mpirun may still end with 0
        left = {"run.lock"} if ranks > 1 else set()
        assert files_of(folder) - left == files_of(expected)


def check_ending(code, said, number, ranks):
    lines = [line for line in said.splitlines() if any(words in line for words in (*LINE, DONE))]
    assert len(lines) == 1 and "Traceback" not in said, said
    if ranks == 1:
        assert said.splitlines() == lines, said
        assert code == (-number if number == signal.SIGKILL else 128 + number)


def test_stopped_while_the_libraries_are_loaded(tmp_path):
    process = start(*coarse_arguments(tmp_path / "run"), options=("-X", "importtime"))
    while "petsc4py" not in (line := process.stderr.readline().decode()):
        assert line
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    words = [line for line in said.decode().splitlines() if not line.startswith("import time:")]
    assert process.returncode == 130 and len(words) == 1 and "nothing was begun" in words[0]
    assert not (tmp_path / "run").exists()


def test_the_exit_code_of_a_batch_system(tmp_path):
    """A time limit that is near: SIGUSR1."""
    code, said = stopped(process := start(*coarse_arguments(tmp_path)), lambda: process.pid, signal.SIGUSR1, 0.3)
    assert code == 128 + signal.SIGUSR1 and "stopped by SIGUSR1; " in said


def test_a_signal_that_mpirun_passes_on_is_not_named(tmp_path):
    """It comes as SIGTERM, whichever it was."""
    process = start(*coarse_arguments(tmp_path, solver__increments=200), ranks=2)
    _, said = stopped(process, lambda: process.pid, signal.SIGINT, 0.3)
    assert "SIGTERM" not in said and ("stopped by a signal; " in said or "ended by force; " in said)


@pytest.mark.parametrize("ranks, number, code", [(1, "SIGINT", 130), (2, "SIGTERM", 143), ("mpirun", "SIGTERM", 1)])
def test_a_stopped_sweep_says_how_to_go_on(ranks, number, code, tmp_path):
    """To rank 0, or to mpirun, which then has a code of its own; what is finished is kept, as after a SIGKILL."""
    arguments = coarse_arguments(tmp_path, reference__kind='"none"')
    vary = ["--vary", "solid.k=0.0:0.4:40"]
    process = start(*vary, *arguments, ranks=1 if ranks == 1 else 2, module="simulations.sweep")
    watchdog = threading.Timer(120, process.kill)
    watchdog.start()
    kept = tmp_path / "sweep.jsonl"
    while process.poll() is None and not (kept.exists() and kept.read_text().endswith("\n")):
        time.sleep(0.02)
    os.kill(ranks_of(process.pid)[0] if ranks == 2 else process.pid, getattr(signal, number))
    _, said = process.communicate()
    watchdog.cancel()
    assert process.returncode == code, said
    assert said.decode().count("the same command goes on where it was\n") == 1 and b"Traceback" not in said, said
    assert "a[m]" in json.loads(kept.read_text().splitlines()[0])["row"]
