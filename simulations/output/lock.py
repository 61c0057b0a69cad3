"""A lock on the folder of a run: one process at a time writes into it, on this machine or another.

The kernel's lock on the file ``run.lock`` ends with the process that holds it, however that ends. Between machines,
where it may not be seen, the file is touched every BEAT seconds: one that has been still for SILENT seconds is stale.
"""

import fcntl
import json
import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

from ..scene import SceneError, shown

NAME = "run.lock"
BEAT = 15.0
FIRST_NAMESPACE = "pid:[4026531836]"  # of processes outside every container: the same number in every Linux kernel
SILENT = 600.0  # one factorisation of the largest mesh may hold a sign of life up for minutes


class Locked(SceneError):
    """Another process writes into the folder."""


class Lock:
    """Holds the lock of ``folder`` from its making until ``release``; Locked where another process does."""

    def __init__(self, folder: Path):
        self._path, self._done = folder / NAME, threading.Event()
        while not self._take():
            pass  # its last owner removed the file meanwhile
        threading.Thread(target=self._beat, daemon=True).start()

    def release(self):
        """Let the folder go; where it has disappeared there is nothing to let go."""
        self._done.set()
        with suppress(OSError):
            if self._is_mine():
                self._path.unlink()
        os.close(self._file)

    def _take(self) -> bool:
        self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            has_kernel_lock = True
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise Locked(self._refusal()) from None
            except OSError:  # a file system without locks
                has_kernel_lock = False
            if not self._is_mine():
                os.close(self._file)
                return False
            if self._is_alive(has_kernel_lock):
                raise Locked(self._refusal())
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, json.dumps(_myself()).encode(), 0)
        except BaseException:
            os.close(self._file)
            raise
        return True

    def _is_mine(self) -> bool:
        """Whether the open file is still the one in the folder."""
        try:
            return os.path.samestat(os.fstat(self._file), os.stat(self._path))
        except FileNotFoundError:
            return False

    def _is_alive(self, has_kernel_lock) -> bool:
        """Whether the owner that the file names may still be at work, though its kernel lock was not seen."""
        owner = self._owner()
        if not owner:
            return False
        if owner.get("boot") == _boot() and has_kernel_lock:
            return False  # this machine's kernel would have refused
        return time.time() - os.fstat(self._file).st_mtime < SILENT

    def _owner(self) -> dict:
        try:
            owner = json.loads(os.pread(self._file, 4096, 0))
            return owner if isinstance(owner, dict) else {}
        except (OSError, ValueError):
            return {}

    def _refusal(self) -> str:
        owner, age = self._owner(), max(time.time() - os.fstat(self._file).st_mtime, 0.0)
        pid = owner.get("pid", "?")
        who = "a process in a container" if pid is None else f"process {pid}"
        who += f" on {owner.get('host', '?')}, begun {owner.get('started', '?')}"
        return (
            f"{shown(self._path.parent)} is locked: {who}, writes into it (last sign of life {age:.0f} s ago; the lock "
            f"ends with that process, or after {SILENT:.0f} s without one)"
        )

    def _beat(self):
        while not self._done.wait(BEAT):
            with suppress(OSError):
                os.utime(self._file)


def _myself() -> dict:
    started = time.strftime("%Y-%m-%d %H:%M:%S")
    # in a container the number is that of another process to those outside, who would end the wrong one
    pid = os.getpid() if _pid_namespace() == FIRST_NAMESPACE else None
    return {"host": socket.gethostname(), "pid": pid, "started": started, "boot": _boot()}


def _pid_namespace() -> str:
    with suppress(OSError):
        return os.readlink("/proc/self/ns/pid")
    return ""


def _boot() -> str:
    """The running kernel: the same for all containers of a machine, another after a restart."""
    with suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8").strip()
    return socket.gethostname()
