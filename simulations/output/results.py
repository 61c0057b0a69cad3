"""Writes the folder of a run: fields, checkpoint and tables while it goes; at its end summary and picture."""

import shlex
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from ..runs import report_data
from ..runs.checks import Check, describe, hold
from ..runs.estimate import judged
from ..runs.history import Entry
from ..runs.reference import Tell
from ..runs.simulation import Simulation
from . import checkpoint
from . import files as output
from .checkpoint import Checkpoint
from .fields import FieldWriter
from .folder import versions
from .plots import plot_run
from .table import table

LONGEST_WRITE = 1.0  # s that a run which is stopped waits for a file that is being written
NOT_JUDGED = "the accuracy was not judged, as the run was stopped at its end: --overwrite starts again"
EVERY = 10.0  # seconds between two versions of the tables while the run goes on


class Results:
    """Writes what a Simulation yields into ``folder``. Every rank calls every method; rank 0 writes.

    again: the command that goes on with the run if it stops; tell: hears of the reference's increments. At the end
    rank 0 has the run's ``findings`` and ``summary``, and every rank ``failing``: which checks do not hold, or "".
    """

    def __init__(self, folder: Path, simulation: Simulation, again: str = "", tell: Tell | None = None):
        self.folder, self.simulation, self._tell = folder, simulation, tell
        self._again = again or f"--resume {shlex.quote(str(folder))}"
        self.scales = simulation.scaled.scales
        self.comm = simulation.body.mesh.comm
        self.summary: dict = {}
        self.findings: report_data.Findings | None = None
        self.failing = ""
        scene = simulation.scene
        self._fields = FieldWriter(
            folder, simulation.numbering, simulation.scaled, simulation.schedule, scene.output, scene.solid.nu
        )
        self._checkpoint = Checkpoint(folder, simulation)
        self._written = time.monotonic()

    def __enter__(self):
        return self

    def record(self, entry: Entry):
        """Keep a state: its fields if it matters, the memory to go on from it, and now and then the tables."""
        last = len(self.simulation.history.entries) - 1
        with self.simulation.watch("output"):
            if self._fields.wants(last):
                self._everywhere(lambda: self._fields.write(last))
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
        if output.writing.acquire(timeout=LONGEST_WRITE):  # else the disk does not answer
            self._write_failed(failure)

    def _write_failed(self, failure: str):
        """What there is of a run that ends before its time, on rank 0; what cannot be written is left out."""
        with suppress(OSError):
            if self.simulation.history.entries:
                self._write_tables()
            self.summary = report_data.summary(self.simulation, None, failure) | {"versions": versions()}
            output.write_summary(self.folder / "summary.json", self.summary)

    def table(self) -> str:
        """The results beside the reference, for reading. On rank 0."""
        assert self.findings is not None  # after the end
        return table(self.findings, self.simulation.history.has_cycle)

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
            raise output.OutputError(failure)

    def _write_tables(self):
        history = self.simulation.history
        times, height = self._fields.times, self.simulation.scaled.indenter.height
        output.write_history(self.folder / "history.csv", history, self.scales, times)
        output.write_surface(self.folder / "surface.h5", history, self.scales, times, height)
        self._fields.write_series(len(history.entries))
        self._written = time.monotonic()

    def __exit__(self, kind, error, trace):
        """Write what there is, after a failure too; then ranks may not be in step, and rank 0 does what it can."""
        if kind is None:
            self._everywhere(self._finish)
            self.failing = self.comm.bcast(self.failing)
        elif self.comm.rank == 0:
            self._write_failed((str(error) or kind.__name__).splitlines()[0])

    def _finish(self):
        """The tables, the comparison and the picture, after which there is nothing left to go on with."""
        if self.comm.rank == 0:
            simulation = self.simulation
            with simulation.watch("output"):
                self._write_tables()
            self.findings = report_data.find(simulation, self._tell)
            if simulation.scene.solver.accuracy is not None:  # until it is judged, which may take as long as the run
                self.findings.checks["accuracy"] = Check(np.nan, simulation.scene.solver.accuracy, NOT_JUDGED)
            with simulation.watch("files"):
                self._plot()
            self._write_summary()
            checkpoint.remove(self.folder)

    def judge_accuracy(self, tell: Callable[[str], None] = lambda words: None):
        """One more check of a run that has ended where ``solver.accuracy`` is given: its errors, measured or else
        estimated, against that. Collective. tell: called with words.
        """
        if self.simulation.scene.solver.accuracy is None:
            return
        check, accuracy = judged(self.simulation, self.findings.exact if self.findings else None, tell)

        def write():
            if self.findings:
                self.findings.checks["accuracy"] = check
                if not check.holds:  # which the picture is to say
                    self._plot()
                self._write_summary(accuracy=accuracy)

        self._everywhere(write)
        self.failing = self.comm.bcast(self.failing)

    def _write_summary(self, **more):
        assert self.findings is not None  # after the end
        found = self.findings.checks
        self.failing = "" if hold(found) else describe(found)
        self.summary = report_data.summary(self.simulation, self.findings) | {"versions": versions()} | more
        output.write_summary(self.folder / "summary.json", self.summary)

    def _plot(self):
        findings = self.findings
        lines = {findings.exact.other.name: findings.exact.other} if findings.exact else {}
        if findings.neglecting:
            label = f"closed form of another problem (no {', no '.join(findings.neglecting.without)})"
            lines[label] = findings.neglecting.other
        failing = [name for name, one in findings.checks.items() if not one.holds and one.cause != NOT_JUDGED]
        plot_run(self.folder / "fretting.png", self.simulation.scene.title, self.simulation, lines, failing)
