"""The engine for many runs: the same rows over any executor, failures as rows, a store that goes on where it was."""

import os
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context, parent_process

import pytest
from running import run_command

from simulations.output.files import OutputError
from simulations.studies.engine import FAILED, Item, run_all
from simulations.studies.store import Store

ITEMS = [Item(f"n = {n}", {"n": n}) for n in range(8)]
SQUARES = [{"square": n * n} for n in range(8)]


def square(values):
    """Work of a moment."""
    return {"square": values["n"] ** 2}


def fails_at_three(values):
    """Work that fails once in its own way."""
    if values["n"] == 3:
        raise ZeroDivisionError("three")
    return square(values)


def ends_a_process_of_the_pool(values):
    """Work that takes its process along; here it takes long, so that the pool has its share."""
    if parent_process() is not None:
        os._exit(1)
    time.sleep(0.1)
    return square(values)


def slow_where_first(values):
    """A first run that takes as long as many others."""
    time.sleep(0.5 if values["n"] == 0 else 0.01)
    return {"pid": os.getpid()}


def cannot_write(values):
    """Work whose results find no place."""
    raise OutputError(f"results/{values['n']} cannot be written: No space left on device")


def cannot_write_elsewhere(values):
    """The same in a process of the pool alone."""
    return square(values) if parent_process() is None else cannot_write(values)


def spawned(workers):
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def test_rows_come_in_order_whoever_works():
    assert run_all(ITEMS, square) == SQUARES
    with spawned(2) as executor:
        assert run_all(ITEMS, square, executor=executor) == SQUARES


def test_nobody_waits_for_one_long_run():
    """One process has the long run; this one does all others meanwhile."""
    with spawned(1) as executor:
        executor.submit(os.getpid).result()  # started
        rows = run_all(ITEMS, slow_where_first, executor=executor)
    assert rows[0]["pid"] != os.getpid()
    assert sum(row["pid"] == os.getpid() for row in rows) >= 4  # the pool holds a few that it has taken already


def test_a_failed_run_is_a_row_and_is_tried_again(tmp_path):
    store, said = Store(tmp_path / "runs.jsonl"), []
    for executor in (None, ThreadPoolExecutor(2)):
        rows = run_all(ITEMS, fails_at_three, store, executor, said.append)
        assert rows[3][FAILED].startswith("ZeroDivisionError: three, test_engine.py line")
        assert [row for row in rows if FAILED not in row] == SQUARES[:3] + SQUARES[4:]
    assert sum("n = 3: ZeroDivisionError" in line for line in said) == 2
    assert "7 of 8 runs kept from before" in said
    assert run_all(ITEMS, square, store) == SQUARES
    assert len(store.path.read_text().splitlines()) == 8


def test_a_process_that_ends_is_a_reason():
    with spawned(1) as executor:
        rows = run_all(ITEMS, ends_a_process_of_the_pool, executor=executor)
    assert len(rows) == 8
    assert "process" in rows[0][FAILED]
    assert rows[-1] == SQUARES[-1]


def test_a_stopped_study_goes_on(tmp_path):
    """Stopped by Ctrl-C after three runs, with a line cut short; what is finished is not run again."""
    store, seen = Store(tmp_path / "runs.jsonl"), []

    def work(values):
        seen.append(values["n"])
        if len(seen) == 4:
            raise KeyboardInterrupt
        return square(values)

    with pytest.raises(KeyboardInterrupt):
        run_all(ITEMS, work, store)
    with store.path.open("a") as file:
        file.write('{"key": "n = 7 #12')
    assert run_all(ITEMS, work, store) == SQUARES
    assert seen == [0, 1, 2, 3, 3, 4, 5, 6, 7]
    assert len(store.read()) == 8


def test_zeros_in_the_place_of_all_lines_are_no_other_file(tmp_path):
    """A power cut may leave them; --overwrite would refuse the folder for ever."""
    store = Store(tmp_path / "runs.jsonl")
    store.path.write_bytes(bytes(300))
    assert store.is_own() and store.read() == {}
    assert run_all(ITEMS, square, store) == SQUARES and len(store.read()) == 8


def test_other_values_are_another_run(tmp_path):
    store = Store(tmp_path / "runs.jsonl")
    run_all([Item("one", {"n": 2})], square, store)
    assert run_all([Item("one", {"n": 3})], square, store) == [{"square": 9}]


def test_a_full_disk_is_no_row(tmp_path):
    """What cannot be kept ends the study: it would be lost."""
    with pytest.raises(OutputError, match="runs.jsonl cannot be written"):
        run_all(ITEMS, square, Store(tmp_path / "absent" / "runs.jsonl"))


def test_a_full_disk_in_a_run_ends_the_study_too():
    """Also one of another process."""
    with pytest.raises(OutputError, match="^results/0 cannot be written"):
        run_all(ITEMS, cannot_write)
    with spawned(1) as executor, pytest.raises(OutputError, match="^results/. cannot be written"):
        run_all(ITEMS, cannot_write_elsewhere, executor=executor)


@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks_share_the_runs(ranks):
    """Over MPI: every rank works, rank 0 too, and all rows are there."""
    done = run_command(ranks=ranks, module="tests.studies.sharing", timeout=60)
    assert (done.returncode, done.stdout) == (0, f"24 rows by {ranks} ranks\n"), done.stderr
