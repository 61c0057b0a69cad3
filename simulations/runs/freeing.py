"""Memory of PETSc objects and of bodies that nobody uses any more, given back while there are more to come.

A body refers to itself in places, and Python's collector, which counts objects and not bytes, lets dozens pile up.
Across ranks PETSc destroys what is freed only once every rank has freed it, and has to be asked on the communicators
of the objects themselves.
"""

import gc
import signal
import threading
import weakref

from mpi4py import MPI
from petsc4py import PETSc

from ..fem.body import ElasticBody

_made: "weakref.WeakSet[ElasticBody]" = weakref.WeakSet()
_shared: list[tuple[weakref.ref, list[PETSc.Comm]]] = []  # by several ranks, with the communicators of each


def communicators(body: ElasticBody) -> list[PETSc.Comm]:
    """Those of its matrices and of its vectors: dolfinx duplicates the mesh's for each kind."""
    return [body.stiffness.comm, body.state.x.petsc_vec.comm]


def later(body: ElasticBody):
    """Free this body by ``earlier`` once it is not used any more. Collective."""
    _made.add(body)
    if body.mesh.comm.size > 1:
        _shared.append((weakref.ref(body), [comm.duplicate() for comm in communicators(body)]))


def between_steps(body: ElasticBody):
    """Free what iterations have made and dropped: across ranks vectors would pile up, 9 MB a load step. Collective."""
    for own in communicators(body):
        PETSc.garbage_cleanup(own)


def collect():
    """Python's collector, with Ctrl-C put off to its end: it drops what is raised in the finalizers that it calls."""
    handler = signal.getsignal(signal.SIGINT)
    if handler is None or threading.current_thread() is not threading.main_thread():  # then it is not Python's to set
        gc.collect()
        return
    interrupts: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: interrupts.append(number))
    try:
        gc.collect()
    finally:
        signal.signal(signal.SIGINT, handler)
    if interrupts:
        signal.raise_signal(signal.SIGINT)


def earlier(comm: MPI.Comm):
    """Free the bodies that nobody uses any more. Collective."""
    if _made or _shared:
        collect()
    for entry in [*_shared]:
        body, communicators_of_body = entry
        if MPI.Group.Compare(communicators_of_body[0].tompi4py().group, comm.group) != MPI.IDENT:
            continue  # of other ranks than those that ask
        for own in communicators_of_body:
            PETSc.garbage_cleanup(own)
        if not comm.allreduce(body() is not None, MPI.LOR):
            for own in communicators_of_body:
                own.destroy()
            _shared.remove(entry)
