"""One engine for many independent runs: over any executor, with a store of what is finished and one line of progress.

    rows = run_on(comm, items, work, Store(folder / "runs.jsonl"))  # every rank; None on those that work for rank 0

``work`` is a function of a module: it goes to other processes by name.
"""

import hashlib
import json
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI
from mpi4py.futures import MPICommExecutor

from ..command.progress import duration
from ..command.stopping import stopping
from ..output.files import OutputError
from ..output.folder import is_whole
from ..runs.freeing import collect
from ..scene import SceneError
from .store import Store

Row = dict[str, Any]
GO_ON = "the same command goes on where it was"
FAILED = "failed"  # key of a row that holds nothing but the reason why there is no result
POLL = 0.01  # seconds at most between two looks for messages of other ranks
COLLECT = 3.0  # seconds between two searches for reference cycles
PAUSE = 1.0  # seconds between two lines of progress


@dataclass(frozen=True)
class Item:
    """One run: a name for people, and the values that ``work`` is called with (numbers, texts, lists of these).

    values["folder"], where there is one, is the folder of its results.
    """

    name: str
    values: dict[str, Any]

    @property
    def key(self) -> str:
        """Key of its row in a store: the name and a hash of the values. Of the folder only the name counts, as the
        whole study may be moved.
        """
        folder = {"folder": Path(self.values["folder"]).name} if "folder" in self.values else {}
        text = json.dumps(self.values | folder, sort_keys=True)
        return f"{self.name} #{hashlib.sha256(text.encode()).hexdigest()[:16]}"


@contextmanager
def workers(comm: MPI.Comm) -> Iterator[Executor | None]:
    """On rank 0 an executor over the other ranks, None without any. These work until rank 0 leaves, and then get None.

    A rank that is free takes the next run. Wrong input or a file that cannot be written, found by rank 0, is raised on
    every rank. Collective.
    """
    if comm.size == 1:
        yield None
        return
    failure = None
    with MPICommExecutor(comm, root=0, backoff=POLL) as executor:  # type: ignore[arg-type]
        try:
            yield executor  # type: ignore[misc]
        except (SceneError, OutputError) as reason:  # of rank 0
            failure = reason
    failure = comm.bcast(failure)
    if failure is not None:
        raise failure


def run_on(
    comm: MPI.Comm,
    items: Iterable[Item],
    work: Callable[[Row], Row],
    store: Store | None = None,
    tell: Callable[[str], None] | None = None,
) -> list[Row] | None:
    """``run_all`` over the ranks of ``comm``: the rows on rank 0, None on the others. Collective."""
    with workers(comm) as executor:
        return run_all(items, work, store, executor, tell) if comm.rank == 0 else None


def run_all(
    items: Iterable[Item],
    work: Callable[[Row], Row],
    store: Store | None = None,
    executor: Executor | None = None,
    tell: Callable[[str], None] | None = None,
) -> list[Row]:
    """The row of every item, in order: what ``work(item.values)`` returns, or ``{"failed": reason}``.

    What the store holds is not run again, unless its folder is not whole; a failed run is told, never kept (another
    call tries it again), and never the end of the others. executor: None, or where runs may go; this process works too,
    from the end of the list, so that N ranks do the work of N. tell: called with lines of progress. OutputError where
    the store or the results of a run cannot be written: the next ones would not be kept either.
    """
    items = list(items)
    kept = store.read() if store else {}
    rows = {n: kept[item.key] for n, item in enumerate(items) if item.key in kept and _is_there(item)}
    progress = _Progress(len(items), len(rows), tell)

    def finish(number: int, row: Row):
        rows[number] = row
        if store and FAILED not in row:
            try:
                store.keep(items[number].key, items[number].values, row)
            except OSError as error:
                reason = f"{store.path} cannot be written: {error.strerror or error}"
                raise OutputError(f"{reason}; {GO_ON}") from None
        progress.step(items[number].name, row)

    if store:
        stopping.tell(GO_ON)
    missing = [number for number in range(len(items)) if number not in rows]
    try:
        if executor is None:
            for number in missing:
                finish(number, _attempt(work, items[number].values))
        else:
            waiting = {executor.submit(_remote, work, items[number].values): number for number in missing}
            _share(waiting, lambda number: _attempt(work, items[number].values), finish)
    except KeyboardInterrupt:  # in a program that uses this: commands end by ``stopping``
        if tell and store:
            tell(f"stopped; {GO_ON}")
        raise
    return [rows[number] for number in range(len(items))]


def _share(waiting: dict[Future, int], attempt: Callable[[int], Row], finish: Callable[[int, Row], None]):
    """Finish what comes back, until nothing is out; meanwhile this process works from the end of the list."""
    try:
        while waiting:
            for future in [future for future in waiting if future.done()]:
                finish(waiting.pop(future), _result(future))
            # what can still be cancelled has not begun, and is this process's own from now on
            mine = next((future for future in reversed(waiting) if future.cancel()), None)
            if mine is not None:
                number = waiting.pop(mine)
                finish(number, attempt(number))
            else:
                wait(waiting, return_when=FIRST_COMPLETED)
    finally:
        for future in waiting:
            future.cancel()


def _is_there(item: Item) -> bool:
    """False where the folder of a run's results is gone, or part of what it holds."""
    return "folder" not in item.values or is_whole(Path(item.values["folder"]))


def _attempt(work, values) -> Row:
    """What ``work`` returns, or why it does not."""
    try:
        return work(values)
    except OutputError:
        raise
    except Exception as error:
        return {FAILED: _reason(error)}
    finally:
        _collect()


_collected = [0.0]  # when this process last freed what runs left in reference cycles


def _collect():
    """Free it, but not after every run: Python does not see how large it is, and the search takes 0.1 s."""
    if time.monotonic() - _collected[0] > COLLECT:
        collect()
        _collected[0] = time.monotonic()


def _remote(work, values) -> Row:
    """The same in another process, from which a signal's own exception could not be sent back."""
    try:
        return _attempt(work, values)
    except KeyboardInterrupt as stop:
        raise KeyboardInterrupt(str(stop)) from None


def _result(future: Future) -> Row:
    try:
        return future.result()
    except OutputError:
        raise
    except Exception as error:  # the process ended, or the row could not be sent
        return {FAILED: _reason(error)}


def _reason(error: Exception) -> str:
    """One line: the message of the project's own exceptions; of others the type and the place too."""
    said = (str(error).strip().splitlines() or ["no reason given"])[0]
    if type(error).__module__.partition(".")[0] in ("simulations", "analytic"):
        return said
    places = traceback.extract_tb(error.__traceback__)
    where = f", {places[-1].filename.rpartition('/')[2]} line {places[-1].lineno}" if places else ""
    return f"{type(error).__name__}: {said}{where}"


class _Progress:
    """Lines like ``12/225  k = 0.3, 3 min left``; a run that failed is told at once."""

    def __init__(self, total: int, kept: int, tell: Callable[[str], None] | None):
        self._total, self._done, self._first, self._tell = total, kept, kept, tell
        self._start = self._said = time.monotonic()
        if tell and kept:
            tell(f"{kept} of {total} runs kept from before")

    def step(self, name: str, row: Row):
        """One more is done."""
        self._done += 1
        if self._tell is None:
            return
        if FAILED in row:
            self._tell(f"{name}: {row[FAILED]}")
        now = time.monotonic()
        if now - self._said < PAUSE and self._done < self._total:
            return
        self._said = now
        left = (now - self._start) / (self._done - self._first) * (self._total - self._done)
        rest = f"{duration(left)} left" if self._done < self._total else f"{duration(now - self._start)}"
        self._tell(f"{self._done:4d}/{self._total}  {name}, {rest}")
