"""End of a command by a signal: at once, with one line that says how to go on, and an exit code of its own.

States are kept after every load step, each file whole or not at all, so that nothing is lost by ending anywhere. No
exception is raised for it: libraries in the middle of their work lose or misreport those. The handler, or a thread
where the main one is busy in a library, writes what there is and ends the process. Where even that is not possible
(SIGKILL, a library that does not let go before mpirun kills), a second process, the ``_Herald``, sees the end of this
one and says the line in its stead.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path

STOPPING = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU", "SIGUSR1")  # the last two: batch systems near their time limit
RANK = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID")
MANAGERS = ("mpirun", "prterun", "mpiexec", "orterun")
AFTER_ROOT = 0.5  # s that other ranks wait before they end, as mpirun then ends rank 0
FIRST = 0.05  # s
GIVEN = 5.0  # s for the last words and files
HERALD = """trap '' INT TERM HUP
while read -r line; do [ "$line" = "" ] && exit 0; words=$line; done
printf '%s\\n' "$words" >&2"""


class Stopping:
    """What a signal, or the end of the process, makes a command say. One for the process.

    go_on: how to go on, in words; keep: function of the reason, which writes what there is.
    """

    def __init__(self):
        self.is_root, self._is_listening, self._ending = True, False, threading.Lock()
        self._go_on = "nothing was begun; start again with the same command"
        self.keep: Callable[[str], None] | None = None
        self._herald: _Herald | None = None
        self._stderr = 2

    def listen_as_command(self):
        """``listen`` where this process is one of the package's commands, not a program that uses the package."""
        spec = getattr(sys.modules["__main__"], "__spec__", None)
        if spec and spec.name.partition(".")[0] == __name__.partition(".")[0]:
            for name in ("stdin", "stdout", "stderr"):
                if getattr(sys, name) is None:  # closed: the next file to be opened would get what is printed
                    setattr(sys, name, open(os.devnull, "r+", encoding="utf-8"))
            if isinstance(sys.stdout, TextIOWrapper):  # a title may have letters that the terminal's encoding has not
                sys.stdout.reconfigure(errors="replace")
            ranks = (os.environ.get(name) for name in RANK)
            self.listen(next((rank for rank in ranks if rank), "0") == "0")

    def listen(self, is_root: bool):
        """From here on signals end the process as this module says. Again once libraries have set theirs."""
        self.is_root = is_root
        if not self._is_listening:
            self._is_listening, self._stderr = True, _stderr()
            reading, writing = os.pipe()
            os.set_blocking(writing, False)
            signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
            threading.Thread(target=self._hear, args=(reading,), daemon=True).start()
        for name in STOPPING:
            number = getattr(signal, name)
            if signal.getsignal(number) is not signal.SIG_IGN:  # nohup, or a shell's background job
                signal.signal(number, self._end)

    def tell(self, go_on: str, keep: Callable[[str], None] | None = None):
        """Set what is said and done from now on."""
        self._go_on, self.keep = go_on, keep
        if self.is_root and self._is_listening:
            self._herald = self._herald or _Herald(self._stderr)
            self._herald.will_say(self._line("ended by force"))

    def over(self):
        """The command ends by itself: there is nothing to say."""
        if self._herald:
            self._herald.leave()
            self._herald = None
        self._go_on, self.keep = "", None

    def _line(self, reason):
        return f"{reason}; {self._go_on}" if self._go_on else reason

    def _hear(self, reading):
        while number := os.read(reading, 1)[0]:
            if number in [getattr(signal, name) for name in STOPPING]:
                time.sleep(FIRST)  # the main thread is the better one to end in, if it is free
                self._end(number)

    def _end(self, number, frame=None):
        """Say the line, keep what there is and end. Called by the thread, and as the handler in the main thread."""
        if not self._ending.acquire(blocking=False):
            while True:  # the other one ends the process; nothing else is to happen meanwhile
                time.sleep(GIVEN)
        is_passed_on = number == signal.SIGTERM and self._stderr != 2  # mpirun makes one of every signal that it gets
        code, reason = 128 + number, f"stopped by {'a signal' if is_passed_on else signal.Signals(number).name}"
        last = threading.Timer(GIVEN, os._exit, [code])
        last.daemon = True
        last.start()
        signal.setitimer(signal.ITIMER_REAL, 2 * GIVEN)  # should even that thread not come to its turn
        if not self.is_root:
            time.sleep(AFTER_ROOT)
            os._exit(code)
        with suppress(OSError):
            start = "\n" if os.isatty(self._stderr) else ""  # below the line that is written over
            os.write(self._stderr, f"{start}{self._line(reason)}\n".encode())
        with suppress(BaseException):  # whatever state the rest is in
            if self._herald:
                self._herald.leave()
            if self.keep:
                self.keep(reason)
        os._exit(code)


class _Herald:
    """A process that says one line once this one has ended without ``leave``."""

    def __init__(self, stderr: int):
        self._process = None
        with suppress(OSError):
            self._process = subprocess.Popen(
                ["/bin/sh", "-c", HERALD],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=stderr,
                start_new_session=True,
            )

    def will_say(self, line: str):
        self._write(line.replace("\n", " "))

    def leave(self):
        self._write("")
        if self._process:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(1.0)

    def _write(self, line):
        with suppress(OSError, ValueError):
            if self._process:
                os.write(self._process.stdin.fileno(), f"{line}\n".encode())


def _stderr() -> int:
    """Where the user reads: the process manager's own stderr, as it passes nothing on once it is told to stop."""
    parent = Path(f"/proc/{os.getppid()}")
    with suppress(OSError):
        if (parent / "comm").read_text(encoding="utf-8").strip() in MANAGERS:
            return os.open(parent / "fd" / "2", os.O_WRONLY | os.O_APPEND)
    return 2


stopping = Stopping()
