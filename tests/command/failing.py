"""A command that fails on one rank alone, the one that is named: run under mpirun by test_ending."""

from simulations.command import command
from simulations.command.command import comm, run
from simulations.loading.stepping import SolveError
from simulations.studies.engine import workers


def main(arguments):
    """Fail on the rank of this number; with another word the others wait to work for rank 0."""
    if comm.rank == int(arguments[0]):
        raise SolveError("on one rank")
    if len(arguments) > 1:
        with workers(comm):
            pass


if __name__ == "__main__":
    command.LONGEST_WAIT = 1.0
    run(main)
