"""Progress lines of a run: each phase and its seconds, a line a load step with the time left; on a terminal one
line, written over.
"""

import os
import shutil
import sys
import time

from ..runs.simulation import Simulation
from .command import say

LAUNCHED = ("PMIX_RANK", "PMI_RANK", "OMPI_COMM_WORLD_RANK")  # mpirun's ranks have a terminal even where it has none
PHASES = {  # those that are announced, by name on the stopwatch
    "mesh": "mesh",
    "forms": "forms (compiled the first time, which takes about a minute)",
    "reference": "reference",
    "files": "picture",
}
SELDOM = 5.0  # s between two words of the reference
FILES = 1.0  # s at the end


class Progress:
    """Lines on rank 0's standard output; nothing at all where ``quiet``."""

    def __init__(self, quiet: bool = False):
        self.quiet = quiet
        self._live = not quiet and sys.stdout.isatty() and not any(name in os.environ for name in LAUNCHED)
        self.simulation: Simulation = None  # type: ignore[assignment]  # until ``begin``
        self.total = self._first = 0  # load steps: all, and those done before ``begin``
        self._start = self._afterwards = self._reference_start = self._said = 0.0  # s

    def begin(self, simulation: Simulation, afterwards: float = 0.0):
        """The load steps are about to begin; ``afterwards`` the seconds that are expected after the last of them."""
        self.simulation, self._afterwards = simulation, afterwards + FILES
        self.total, self._first = len(simulation.schedule), len(simulation.history.entries)
        self._start = time.perf_counter()

    def say(self, text: str):
        """A line of its own."""
        if not self.quiet:
            say(text)

    def phase(self, name: str, seconds: float | None):
        """A phase begins (seconds None) or has ended."""
        if name in PHASES and not self.quiet:
            say(f"{PHASES[name]} ... " if seconds is None else duration(seconds), end="" if seconds is None else "\n")

    def step(self, entry):
        """The load step just done."""
        done = len(self.simulation.history.entries)
        line = f"{done:4d}/{self.total}  {describe(entry, self.simulation)}"
        each = (time.perf_counter() - self._start) / (done - self._first)
        left = f", {duration(each * (self.total - done) + self._afterwards)} left"
        if not self._live:
            self.say(line + left)
            return
        stays = bool(entry.step.state) or done == self.total
        if not stays:  # one line of a narrow terminal, which 80 columns are: the time left is what is waited for
            line = line[: shutil.get_terminal_size().columns - 1 - len(left)].rstrip(", ")
        say(f"\r\x1b[K{line}{left}", end="\n" if stays else "")

    def reference(self, done: int, total: int):
        """A load step of the reference is done: said when the reference takes long."""
        now = time.perf_counter()
        if done == 1:
            self._reference_start = self._said = now
        elif now - self._said > SELDOM and not self.quiet:
            self._said = now
            left = (now - self._reference_start) / (done - 1) * (total - done)
            say(f"{done}/{total}, {duration(left)} left ... ", end="")


def duration(seconds: float) -> str:
    """Seconds in words: 0.3 s, 8 s, 12 min, 3 h 20 min."""
    if seconds < 0.95:
        return f"{seconds:.1f} s"
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"


def describe(entry, simulation: Simulation) -> str:
    """One load step: its load, contact or stick, and what it took."""
    step = entry.step
    load = f"P = {step.P:.3f} P_max   a = {entry.a * simulation.scaled.scales.length:.4g} m"
    if step.branch != "normal":
        share = f"Q/(mu P) = {step.Q / (simulation.mu * step.P):+.3f}   c/a = {entry.c / entry.a:.4f}"
        load = share if simulation.scene.is_loop else f"P = {step.P:.3f} P_max   {share}"
    trouble = f", {entry.cuts} cuts" if entry.cuts else ""
    trouble += f", anchors unsettled by {entry.unsettled:.1%}" if entry.unsettled else ""
    return f"{step.branch:9s} {load}   {entry.iterations} iterations{trouble}, {entry.seconds:.2f} s"
