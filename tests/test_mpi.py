"""The tests in tests/mpi on several ranks: each rank runs all of them, and each has to pass."""

import pytest
from running import run_python


@pytest.mark.parametrize("ranks", [2, 3])
def test_on_ranks(ranks):
    done = run_python("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/mpi", ranks=ranks, timeout=900)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert done.stdout.count(" passed") == ranks
