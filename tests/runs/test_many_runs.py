"""Many runs in one process need no more memory than a few: what a run leaves behind is freed by the next one."""

import pytest
from running import run_command


@pytest.mark.slow
@pytest.mark.parametrize("ranks, runs", [(1, 50), (2, 20)])
def test_memory_of_many_runs(ranks, runs):
    """Within 1.2 times that after five; without freeing it is 3 times after 50."""
    done = run_command(runs, module="tests.runs.many_runs", ranks=ranks, timeout=900)
    assert done.returncode == 0, done.stderr
    first, last = map(float, done.stdout.split())
    assert last < 1.2 * first
