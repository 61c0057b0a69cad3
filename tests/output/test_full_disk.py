"""A full disk in each phase: one line, exit code 5, what was whole stays whole; the run goes on when there is room."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from restarting import RUN, assert_same
from running import ROOT, coarse_arguments, contents, environment, fill_disk

import simulations.sweep
from simulations import fretting
from simulations.output.files import OutputError, write_text

SMALL, LARGER = 280, 560  # kB: too small for the first field; too small for the indices and the picture


@pytest.mark.parametrize("call", [12, 31, 34, 36, 38])
def test_at_a_chosen_write(call, uninterrupted, tmp_path, monkeypatch):
    """Of checkpoint, table, index or summary."""
    folder = tmp_path / "run"
    fill_disk(monkeypatch, call)
    with pytest.raises(OutputError, match="No space left on device; go on with .*--resume") as error:
        fretting.main(coarse_arguments(folder, **RUN))
    assert "\n" not in str(error.value)
    assert not [path for path in folder.rglob("part.*")]
    monkeypatch.undo()
    fretting.main(["--resume", str(folder)])
    assert_same(folder, uninterrupted)


def test_a_file_takes_its_place_once_it_is_on_the_disk(tmp_path, monkeypatch):
    """What was there stays until then."""
    write_text(tmp_path / "a", "old")
    fill_disk(monkeypatch, 1)
    with pytest.raises(OutputError):
        write_text(tmp_path / "a", "new")
    assert contents(tmp_path) == {Path("a"): b"old"}


def test_records_of_a_checkpoint_are_on_the_disk_before_they_count(tmp_path, monkeypatch):
    """For every load step: states.bin is, before the memory.npz that tells how many of its records there are."""
    events, fsync, replace = [], os.fsync, os.replace

    def seen_fsync(descriptor):
        fsync(descriptor)
        events.append(Path(f"/proc/self/fd/{descriptor}").readlink().name)

    def seen_replace(source, target):
        events.append("counts" if Path(target).name == "memory.npz" else "")
        replace(source, target)

    monkeypatch.setattr(os, "fsync", seen_fsync)
    monkeypatch.setattr(os, "replace", seen_replace)
    fretting.main([*coarse_arguments(tmp_path, **RUN, load__cycles=0, solver__increments=1), "--quiet"])
    of_checkpoint = [event for event in events if event in ("states.bin", "part.memory.npz", "counts")]
    assert of_checkpoint == ["states.bin", "part.memory.npz", "counts"] * 2


def test_the_table_of_a_sweep(tmp_path, monkeypatch):
    fill_disk(monkeypatch, 3)  # after the folder and the finished run
    with pytest.raises(OutputError) as error:
        simulations.sweep.main([*coarse_arguments(tmp_path, **RUN), "--vary", "solid.k=0.2,", "--quiet"])
    assert str(error.value) == f"{tmp_path / 'sweep.csv'} cannot be written: No space left on device"
    assert not [*tmp_path.glob("part.*")]


def test_files_that_may_not_grow(uninterrupted, tmp_path):
    """The kernel itself refuses a write, on any machine: a field file is larger than the limit of this process."""
    folder, limits = tmp_path / "run", resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, limits[1]))
    try:
        with pytest.raises(OutputError, match="cannot be written: File too large; go on with .*--resume"):
            fretting.main([*coarse_arguments(folder, **RUN), "--quiet"])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not [path for path in folder.rglob("part.*")]
    fretting.main(["--resume", str(folder), "--quiet"])
    assert_same(folder, uninterrupted)


WITHIN = """
disk=$1 small=$2 larger=$3 copy=$4 && shift 4
mount -t tmpfs -o size=${small}k tmpfs "$disk" || exit 77
"$@" --output "$disk/run"; echo $?
mount -o remount,size=${larger}k "$disk" && "${@:1:3}" --quiet --resume "$disk/run"; echo $?
mount -o remount,size=64m "$disk" && "${@:1:3}" --quiet --resume "$disk/run"; echo $?
cp -r "$disk/run" "$copy"
"""


def test_a_small_file_system(uninterrupted, tmp_path):
    """Twice too small, then with room; a throwaway view of the machine holds it."""
    command = [sys.executable, "-m", "simulations.fretting", *coarse_arguments("", **RUN)[:-2], "--quiet"]
    disk, copy = tmp_path / "disk", tmp_path / "copy"
    disk.mkdir()
    view = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--mount"]
    done = subprocess.run(
        [*view, "bash", "-c", WITHIN, "-", *map(str, (disk, SMALL, LARGER, copy)), *command],
        cwd=ROOT,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=300,
    )
    if done.returncode == 77 or done.stderr.startswith("unshare:"):
        pytest.skip(f"no file system can be mounted here ({done.stderr.strip()}); the limit of file sizes was tried")
    assert done.stdout.split() == ["5", "5", "0"], done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 2 and all("No space left on device; go on with " in line for line in lines), lines
    assert_same(copy, uninterrupted)
