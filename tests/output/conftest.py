"""The run that interrupted ones are compared with."""

import pytest
from restarting import RUN
from running import coarse_arguments, run_command


@pytest.fixture(scope="session")
def uninterrupted(tmp_path_factory):
    """Folder of RUN, not stopped; nobody writes there."""
    folder = tmp_path_factory.mktemp("uninterrupted")
    done = run_command(*coarse_arguments(folder, **RUN))
    assert done.returncode == 0, done.stderr
    return folder
