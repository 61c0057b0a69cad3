"""What pytest reads of itself: the order of the tests, and the run that several of them look at."""

import pytest
from running import run_command

from simulations.runs.simulation import Simulation


def pytest_collection_modifyitems(items):
    """Quick tests first."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


@pytest.fixture(scope="session")
def default_run(tmp_path_factory):
    """Folder of the main job: the default scene on two ranks, as README has it."""
    folder = tmp_path_factory.mktemp("default")
    done = run_command("--output", folder, ranks=2)
    assert done.returncode == 0, done.stderr
    (folder / "stdout.txt").write_text(done.stdout)
    return folder


@pytest.fixture
def whole_steps(monkeypatch):
    """No load step is taken in halves because tractions zigzag: rules for anchors are seen by themselves."""
    monkeypatch.setattr(Simulation, "_zigzag", lambda simulation: 0.0)
