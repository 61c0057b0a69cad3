"""Seconds by phase."""

import time
from collections.abc import Callable
from contextlib import contextmanager


class Stopwatch:
    """Adds up the wall seconds of named phases:  ``with watch("solve"): ...``.

    tell: called with a phase's name when it begins, and with its name and seconds when it ends. last: seconds of the
    phase that ended last, those inside it included.
    """

    def __init__(self, tell: Callable[[str, float | None], None] | None = None):
        self._tell = tell
        self.seconds: dict[str, float] = {}
        self.last = 0.0
        self._inside = 0.0  # seconds of phases inside the present one
        self._start = time.perf_counter()

    @contextmanager
    def __call__(self, phase: str):
        start, outside = time.perf_counter(), self._inside
        self._inside = 0.0
        if self._tell:
            self._tell(phase, None)
        try:
            yield
        finally:
            self.last = time.perf_counter() - start
            self.seconds[phase] = self.seconds.get(phase, 0.0) + self.last - self._inside
            self._inside = outside + self.last
            if self._tell:
                self._tell(phase, self.last)

    def go_on(self, seconds: dict[str, float]):
        """Add what an earlier part of the run took, by phase and in ``total``."""
        self._start -= seconds.get("total", 0.0)
        for phase, value in seconds.items():
            if phase != "total":
                self.seconds[phase] = self.seconds.get(phase, 0.0) + value

    @property
    def total(self) -> float:
        """Seconds since the watch was made."""
        return time.perf_counter() - self._start
