"""Many runs in one process need no more memory than a few: what a run leaves behind is freed by the next one."""

import signal

import pytest
from running import run_command

from simulations.runs.freeing import collect


@pytest.mark.slow
@pytest.mark.parametrize("ranks, runs", [(1, 50), (2, 20)])
def test_memory_of_many_runs(ranks, runs):
    """Within 1.2 times that after five; without freeing it is 3 times after 50."""
    done = run_command(runs, module="tests.runs.many_runs", ranks=ranks, timeout=900)
    assert done.returncode == 0, done.stderr
    first, last = map(float, done.stdout.split())
    assert last < 1.2 * first


def test_an_interrupt_while_garbage_is_collected_is_not_lost():
    """Python drops what is raised in a finalizer."""

    class Cycle:
        def __init__(self):
            self.itself = self

        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    Cycle()
    with pytest.raises(KeyboardInterrupt):
        collect()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
