"""Start and end of every command: rank 0 alone reads, checks and speaks.

Each kind of ending has an exit code and one line on stderr: wrong input 2, no solution 3, failing checks 4, results
that cannot be written 5, a signal 128 and its number (``stopping``). Anything unforeseen ends with 1 and aborts all
ranks, so that none waits for another.
"""

import ctypes
import os
import signal
import socket
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from typing import TypeVar

from mpi4py import MPI
from petsc4py import PETSc

from ..fem import parallel
from ..loading.stepping import SolveError
from ..output.files import OutputError
from ..runs.checks import ChecksFailed
from ..scene import SceneError
from .stopping import stopping

T = TypeVar("T")
comm = MPI.COMM_WORLD
NO_SOLUTION, CHECKS_FAILED, NOT_WRITTEN = 3, 4, 5  # exit codes; 2 is that of wrong input
LONGEST_WAIT = 30.0  # s that a rank which failed waits for the others to fail too
_is_within_line = False  # what was said last: an error begins below it
LAST = 0.2  # s by which rank 0 ends after the others: mpirun then has nobody left to end, and no more to say


def on_root(work: Callable[[], T]) -> T:
    """Result of ``work`` done by rank 0; wrong input, or a file that cannot be written, is raised on every rank."""
    return parallel.on_root(comm, work, (SceneError, OutputError, SystemExit))


def run(main: Callable[[list[str]], None]):
    """Run a command's ``main(arguments)`` and exit as its kind of ending asks."""
    apart = comm.Dup()  # for the end alone: on ``comm`` a rank that failed would meet what the others do together
    stopping.listen(comm.rank == 0)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)  # which PETSc would take for a crash
    _warn_in_one_line()
    code: int | str = 0
    try:
        main(sys.argv[1:])
    except SystemExit as end:
        code = end.code or 0
    except SceneError as error:
        code = _failed(error, 2)
    except SolveError as error:
        code = _failed(f"not converged: {error}", NO_SOLUTION)
    except ChecksFailed as error:
        code = _failed(error, CHECKS_FAILED)
    except OutputError as error:
        code = _failed(error, NOT_WRITTEN)
    except BaseException:
        traceback.print_exc()
        stopping.over()
        if comm.size == 1:
            sys.exit(1)
        comm.Abort(1)
    if code:
        stopping.over()
    _leave_together(apart, code)


def _failed(error, code: int) -> int:
    say(str(error), file=sys.stderr)
    return code


def _leave_together(comm: MPI.Comm, code):
    """Exit once every rank has come here, rank 0 last and with the largest code: else mpirun ends the rest noisily."""
    if isinstance(code, str):
        code = _failed(code, 1)
    together = None
    if comm.size > 1:
        together, waited = comm.Ibarrier(), time.monotonic()
        while not together.Test():
            if code and time.monotonic() - waited > LONGEST_WAIT:
                comm.Abort(code)
            time.sleep(0.01)
    rank, ranks = comm.rank, comm.allgather((code, socket.gethostname(), os.getpid()))  # one rank alone may have failed
    code = max(ranks)[0]
    PETSc._finalize()  # here, where every rank does
    if not MPI.Is_finalized():
        MPI.Finalize()
    stopping.listen(rank == 0)  # PETSc has taken the handlers away
    sys.stdout.flush()
    ctypes.CDLL(None).fflush(None)  # what PETSc has printed
    if rank == 0 and code:
        _wait_for_end([pid for _, host, pid in ranks[1:] if host == socket.gethostname()])
    stopping.over()  # not before: until here a rank may be killed, and the line says that the run is done
    os._exit(0 if rank else code)  # not through the interpreter's own end, in which a signal would find no handler


def _wait_for_end(others: list[int]):
    """Wait until mpirun has seen the end of the other ranks of this machine."""
    start = time.monotonic()
    while any(os.path.exists(f"/proc/{pid}") for pid in others) and time.monotonic() - start < LONGEST_WAIT:
        time.sleep(0.01)
    if others:
        time.sleep(LAST)


def _warn_in_one_line():
    """Warnings come once, from rank 0."""
    said = set()

    def show(message, category, *where, **more):
        if str(message) not in said:
            said.add(str(message))
            say(f"warning: {message}", file=sys.stderr)

    warnings.showwarning = show


def say(text: str, file=None, end: str = "\n"):
    """Print on rank 0. Where nobody can listen any more (a closed pipe, a full disk) the run goes on silently."""
    global _is_within_line
    if comm.rank == 0:
        stream = file or sys.stdout
        begin = "\n" if file and _is_within_line and stream.isatty() else ""
        _is_within_line = not end
        try:
            print(begin + text, file=stream, end=end, flush=True)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
