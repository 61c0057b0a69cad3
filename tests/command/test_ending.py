"""The end of a command under mpirun: one exit code of all ranks, and none waits for another."""

import signal

import pytest
from running import run_command, run_python

AT_ITS_END = """
import os, signal
from simulations.command import command
command.stopping.over = lambda: os.kill(os.getpid(), signal.SIGTERM)
command.run(lambda arguments: None)
"""


def test_a_signal_after_the_libraries_have_ended_finds_a_handler():
    done = run_python("-c", AT_ITS_END, timeout=60)
    assert done.returncode == 128 + signal.SIGTERM and done.stderr.startswith("stopped by SIGTERM"), done.stderr


@pytest.mark.parametrize("rank, said", [(0, "not converged: on one rank\n"), (1, "")])
def test_a_failure_of_one_rank_is_the_end_of_all(rank, said):
    done = run_command(rank, ranks=2, module="tests.command.failing", timeout=60)
    assert (done.returncode, done.stderr) == (3, said)


def test_a_rank_that_waits_for_one_that_failed_is_aborted():
    """Rank 1 makes a communicator for its work meanwhile: on the same one MPI would mix that with the last barrier."""
    done = run_command(0, "workers", ranks=2, module="tests.command.failing", timeout=30)
    assert done.returncode == 3 and "Traceback" not in done.stderr


@pytest.mark.parametrize("arguments, code", [(["--list", "--only", "sweep"], 0), (["--output", "/etc/passwd/x"], 2)])
def test_a_study_of_rank_0_alone_ends_with_its_code(arguments, code):
    done = run_command(*arguments, ranks=2, module="simulations.studies.cost", timeout=60)
    assert done.returncode == code and len(done.stderr.splitlines()) == (code > 0), done.stderr
