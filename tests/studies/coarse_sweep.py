"""A coarse sweep: its command line, and the rows of its table."""

from running import COARSE, csv_rows

COARSE_SETS = tuple(f"{key}={value}" for key, value in {**COARSE, "effects.coupling": "false"}.items())
VARY = ("solid.k=0:0.6:3", "load.mu=0.2,0.5")


def arguments(folder, vary=VARY, *more):
    """Command line of a coarse sweep."""
    options = [word for one in vary for word in ("--vary", one)]
    return [*options, *(word for one in COARSE_SETS for word in ("--set", one)), "--output", str(folder), *more]


def rows_of(folder):
    """Rows of its table."""
    return csv_rows(folder / "sweep.csv")
