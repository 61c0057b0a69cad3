"""Packages that are not the recorded ones are named with every run."""

from simulations.output import folder


def test_packages_that_moved_are_named(tmp_path, monkeypatch):
    moved = tmp_path / "moved.txt"
    moved.write_text("python3-numpy 1:2.2.4+ds-1 1:2.2.5+ds-1\n")
    monkeypatch.setattr(folder, "MOVED", moved)
    assert folder.versions()["python3-numpy"] == "1:2.2.5+ds-1 (recorded: 1:2.2.4+ds-1)"
    moved.write_text("")
    assert "python3-numpy" not in folder.versions()
