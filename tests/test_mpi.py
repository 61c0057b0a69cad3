"""The tests in tests/mpi on several ranks: each rank runs all of them, and each has to pass."""

import shutil
import subprocess
import sys

import pytest
from running import ROOT, environment


@pytest.mark.parametrize("ranks", [2, 3])
def test_on_ranks(ranks):
    command = [shutil.which("mpirun"), "-n", str(ranks), sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [*command, "tests/mpi"], cwd=ROOT, env=environment(), timeout=900, text=True, capture_output=True
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert done.stdout.count(" passed") == ranks
