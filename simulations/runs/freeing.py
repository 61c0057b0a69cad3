"""Memory of bodies that nobody uses any more, given back before the next one is made.

A body refers to itself in places, and Python's collector, which counts objects and not bytes, lets dozens pile up.
Across ranks PETSc destroys what is freed only once every rank has freed it, and has to be asked on the body's own
communicator.
"""

import gc
import weakref

from mpi4py import MPI
from petsc4py import PETSc

from ..fem.body import ElasticBody

_made: "weakref.WeakSet[ElasticBody]" = weakref.WeakSet()
_shared: list[tuple[weakref.ref, PETSc.Comm]] = []  # by several ranks, with PETSc's communicator of each


def later(body: ElasticBody):
    """Free this body by ``earlier`` once it is not used any more. Collective."""
    _made.add(body)
    if body.mesh.comm.size > 1:
        _shared.append((weakref.ref(body), body.stiffness.comm.duplicate()))


def earlier(comm: MPI.Comm):
    """Free the bodies that nobody uses any more. Collective."""
    if _made or _shared:
        gc.collect()
    for entry in [*_shared]:
        body, own = entry
        if MPI.Group.Compare(own.tompi4py().group, comm.group) != MPI.IDENT:
            continue  # of other ranks than those that ask
        PETSc.garbage_cleanup(own)
        if not comm.allreduce(body() is not None, MPI.LOR):
            own.destroy()
            _shared.remove(entry)
