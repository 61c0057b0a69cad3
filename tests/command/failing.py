"""A command that fails on one rank alone, the one that is named: run under mpirun by test_ending."""

from simulations.command.command import comm, run
from simulations.loading.stepping import SolveError


def main(arguments):
    """Fail on the rank of this number."""
    if comm.rank == int(arguments[0]):
        raise SolveError("on one rank")


if __name__ == "__main__":
    run(main)
