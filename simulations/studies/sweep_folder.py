"""The folder of a sweep: what may be written into it, and what ``--overwrite`` takes away.

A sweep goes on in a folder whose finished runs are all its own. The table and the runs of another sweep, a single run
and files that no sweep wrote are not replaced.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..fem.parallel import on_root
from ..output.folder import ANY_RUN, FILES, SWEEP, has_lost_scene, is_whole, locked, refuse_changed, remove_run
from ..scene import SceneError, shown
from .engine import Item
from .store import Store

KEPT, TABLE = SWEEP


@contextmanager
def taken(comm, folder: Path, items: list[Item], overwrite: bool, option: str = "--output") -> Iterator[Store]:
    """The store of a sweep in ``folder``, which is made, and locked meanwhile. Collective.

    SceneError where another process writes there, or where something there would be lost. items: all its runs;
    overwrite: take away the table, the runs and the store of another sweep; option: what a refusal calls the folder.
    """
    lock = None

    def take():
        nonlocal lock
        lock = locked(folder, option)
        _make_ready(folder, items, overwrite, option)

    try:
        on_root(comm, take, SceneError)
        yield Store(folder / KEPT)
    finally:
        if lock:
            lock.release()


def _make_ready(folder, items, overwrite, option):
    store, table = Store(folder / KEPT), folder / TABLE
    start = f"{option} {shown(folder)} is not allowed: "
    run = next((name for name in FILES if (folder / name).exists()), None)
    if run:
        raise SceneError(f"{start}it holds {run}, of a single run; choose another folder")
    stranger = KEPT if not store.is_own() else TABLE if table.exists() and not store.path.exists() else None
    if stranger:
        raise SceneError(f"{start}it holds {stranger}, which no sweep wrote; choose another folder")
    kept = store.read()
    if kept.keys() - {item.key for item in items} and not overwrite:
        replaces = "--overwrite" if option.startswith("--") else "overwrite=True"
        raise SceneError(f"{start}it holds another sweep; {replaces} replaces it, another folder keeps both")
    try:
        # a run that was kept and has lost its scene would be refused as another's, and could never be solved again
        own = [Path(item.values["folder"]) for item in items if item.key in kept and "folder" in item.values]
        lost = {run_folder for run_folder in own if has_lost_scene(run_folder)}
        replaced = lost
        if overwrite:  # what the other sweep has and this one will have
            runs = (*store.values(), *(item.values for item in items))
            replaced = {folder / Path(values["folder"]).name for values in runs if "folder" in values}
            for run_folder in sorted(replaced):  # before anything is taken away
                if not has_lost_scene(run_folder):
                    refuse_changed(run_folder)
            # those that failed or were stopped are in no row, and would be in the way of a scene of their number
            replaced |= {run_folder for run_folder in folder.glob(ANY_RUN) if not is_whole(run_folder)}
        for run_folder in sorted(replaced):
            remove_run(run_folder)
        if overwrite:
            table.unlink(missing_ok=True)
            store.path.unlink(missing_ok=True)
        store.path.touch()  # tells that the table is a sweep's, though all scenes may fail
    except OSError as error:
        raise SceneError(f"{start}{error.strerror or error}") from None
