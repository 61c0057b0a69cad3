"""Writes the folder of a run: fields, checkpoint and tables while it goes; at its end summary and picture."""

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from ..runs import report_data
from ..runs.checks import Check, describe, hold
from ..runs.history import Entry
from ..runs.simulation import Simulation
from . import checkpoint, files
from .checkpoint import Checkpoint
from .fields import FieldWriter
from .folder import versions
from .plots import plot_run

LONGEST_WRITE = 1.0  # s that a run which is stopped waits for a file that is being written
NOT_JUDGED = "the accuracy was not judged, as the run was stopped at its end: --overwrite starts again"
EVERY = 10.0  # seconds between two versions of the tables while the run goes on


class Results:
    """Writes what a Simulation yields into ``folder``. Every rank calls every method; rank 0 writes.

    again: what goes on with the run if it stops, in words. At the end rank 0 has the run's ``summary``, and every
    rank ``failing``: which checks do not hold, or "".
    """

    def __init__(self, folder: Path, simulation: Simulation, again: str):
        self.folder, self.simulation, self._again = folder, simulation, again
        self.scales = simulation.scaled.scales
        self.comm = simulation.body.mesh.comm
        self.summary: dict = {}
        self.failing = ""
        self._findings: report_data.Findings | None = None  # on rank 0, at the end
        self._fields = FieldWriter(folder, simulation)
        self._checkpoint = Checkpoint(folder, simulation)
        self._written = time.monotonic()
        self._recorded = len(simulation.history.entries)  # load steps whose fields are there, those of a resumed run

    def __enter__(self):
        return self

    def record(self, entry: Entry):
        """Keep a state: its fields if it matters, the memory to go on from it, and now and then the tables."""
        last = len(self.simulation.history.entries) - 1
        with self.simulation.watch("output"):
            if self._fields.wants(last):
                self._everywhere(lambda: self._fields.write(last))
            self._recorded = last + 1
            self._everywhere(lambda: self._checkpoint.save(entry))
            if self.comm.rank == 0 and time.monotonic() - self._written > EVERY:
                with suppress(OSError):  # the next ones, or the last, will do
                    self._write_tables()

    def keep(self, failure: str):
        """Before a signal ends the process, on rank 0: write what there is. ``writing`` stays held, so that no other
        thread writes after it.
        """
        if self.summary.get("converged"):
            return  # it has reached its end: what says so is written, or about to be
        if files.writing.acquire(timeout=LONGEST_WRITE):  # else the disk does not answer
            self._write_failed(failure)

    def _write_failed(self, failure: str):
        """What there is of a run that ends before its time, on rank 0; what cannot be written is left out."""
        with suppress(OSError):
            if self.simulation.history.entries:
                self._write_tables()
            self.summary = report_data.summary(self.simulation, None, failure) | {"versions": versions()}
            files.write_summary(self.folder / "summary.json", self.summary)

    def _everywhere(self, write: Callable[[], None]):
        """``write``, in which rank 0 may fail: OutputError on every rank."""
        failure = None
        try:
            write()
        except OSError as error:
            again = f"; go on with {self._again}" if self.folder.is_dir() else ": the folder is gone; start again"
            failure = f"{self.folder} cannot be written: {error.strerror or error}{again}"
        failure = self.comm.bcast(failure)
        if failure:
            raise files.OutputError(failure)

    def _on_root(self, write: Callable[[], None]):
        """The same of what rank 0 alone writes."""
        self._everywhere(write if self.comm.rank == 0 else lambda: None)

    def _finish(self, write: Callable[[], None]):
        """The same of what says how the run ended; every rank learns which checks fail."""
        self._on_root(write)
        self.failing = self.comm.bcast(self.failing)

    def _write_tables(self):
        history = self.simulation.history
        times, height = self._fields.times, self.simulation.scaled.indenter.height
        files.write_history(self.folder / "history.csv", history, self.scales, times)
        files.write_surface(self.folder / "surface.h5", history, self.scales, times, height)
        self._fields.write_series(self._recorded)  # the last state may have come and not be on the disk
        self._written = time.monotonic()

    def write_tables(self):
        """The tables of what was recorded."""
        with self.simulation.watch("output"):
            self._on_root(self._write_tables)

    def end(self, findings: report_data.Findings | None):
        """Summary and picture of a run at its end, after which there is nothing left to go on with.

        findings: of rank 0. Where ``solver.accuracy`` is given, they do not hold until ``judge`` is called.
        """
        self._findings = findings
        wanted = self.simulation.scene.solver.accuracy
        if findings and wanted is not None:  # judging may take as long as the run
            findings.checks["accuracy"] = Check(np.nan, wanted, NOT_JUDGED)

        def write():
            with self.simulation.watch("files"):
                self._plot()
            self._write_summary()
            checkpoint.remove(self.folder)

        self._finish(write)

    def judge(self, check: Check, accuracy: dict):
        """After the end: the check of the errors against ``solver.accuracy``, and what summary.json says of it."""

        def write():
            self._findings.checks["accuracy"] = check
            if not check.holds:  # which the picture is to say
                self._plot()
            self._write_summary(accuracy=accuracy)

        self._finish(write)

    def __exit__(self, kind, error, trace):
        """After a failure write what there is; then ranks may not be in step, and rank 0 does what it can."""
        if kind is not None and self.comm.rank == 0:
            self._write_failed((str(error) or kind.__name__).splitlines()[0])

    def _write_summary(self, **more):
        assert self._findings is not None  # after the end
        found = self._findings.checks
        self.failing = "" if hold(found) else describe(found)
        self.summary = report_data.summary(self.simulation, self._findings) | {"versions": versions()} | more
        files.write_summary(self.folder / "summary.json", self.summary)

    def _plot(self):
        findings = self._findings
        lines = {findings.exact.other.name: findings.exact.other} if findings.exact else {}
        if findings.neglecting:
            label = f"closed form of another problem (no {', no '.join(findings.neglecting.without)})"
            lines[label] = findings.neglecting.other
        failing = [name for name, one in findings.checks.items() if not one.holds and one.cause != NOT_JUDGED]
        plot_run(self.folder / "fretting.png", self.simulation, lines, failing)
