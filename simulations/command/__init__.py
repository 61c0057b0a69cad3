"""Shared by all commands: command line, progress lines, and the ways to end."""

from .stopping import stopping

stopping.listen_as_command()  # before the libraries are loaded, which takes seconds

# before PETSc, which would start an MPI that lets one thread in: ranks that share the runs of a sweep have two
import mpi4py.MPI  # noqa: E402, F401
