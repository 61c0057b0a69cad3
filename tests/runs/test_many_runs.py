"""Many runs in one process need no more memory than a few: what a run leaves behind is freed by the next one."""

import os
import shutil
import subprocess
import sys

import pytest
from running import MPI_ENVIRONMENT, ROOT


@pytest.mark.slow
@pytest.mark.parametrize("ranks, runs", [(1, 50), (2, 20)])
def test_memory_of_many_runs(ranks, runs):
    """Within 1.2 times that after five; without freeing it is 3 times after 50."""
    command = [sys.executable, str(ROOT / "tests" / "runs" / "many_runs.py"), str(runs)]
    if ranks > 1:
        command = [shutil.which("mpirun"), "-n", str(ranks), *command]
    paths = {"PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}"}
    done = subprocess.run(
        command, env=os.environ | MPI_ENVIRONMENT | paths, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
    first, last = map(float, done.stdout.split())
    assert last < 1.2 * first
