"""The folder of a sweep: what may be written into it, and what ``--overwrite`` takes away.

A sweep goes on in a folder whose finished runs are all its own. The table and the runs of another sweep, a single run
and files that no sweep wrote are not replaced.
"""

from collections.abc import Iterable
from pathlib import Path

from ..output.folder import FILES, remove_run
from ..scene import SceneError, shown
from .engine import Item
from .store import Store

KEPT, TABLE = "sweep.jsonl", "sweep.csv"
RUNS = "run-{:04d}"  # folder of a scene, by its number


def take(folder: Path, items: Iterable[Item], overwrite: bool) -> Store:
    """The store of a sweep in ``folder``, which is made; SceneError where something there would be lost.

    items: all its runs; overwrite: take away the table, the runs and the store of another sweep.
    """
    store, table = Store(folder / KEPT), folder / TABLE
    start = f"--output {shown(folder)} is not allowed: "
    run = next((name for name in FILES if (folder / name).exists()), None)
    if run:
        raise SceneError(f"{start}it holds {run}, of a single run; choose another folder")
    stranger = KEPT if not store.is_own() else TABLE if table.exists() and not store.path.exists() else None
    if stranger:
        raise SceneError(f"{start}it holds {stranger}, which no sweep wrote; choose another folder")
    if store.read().keys() - {item.key for item in items} and not overwrite:
        raise SceneError(f"{start}it holds another sweep; --overwrite replaces it, --output DIR keeps both")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if overwrite:
            for run_folder in sorted(folder.glob("run-[0-9]*")):
                remove_run(run_folder)
            table.unlink(missing_ok=True)
            store.path.unlink(missing_ok=True)
        store.path.touch()  # tells that the table is a sweep's, though all scenes may fail
    except OSError as error:
        raise SceneError(f"{start}{error.strerror or error}") from None
    return store
