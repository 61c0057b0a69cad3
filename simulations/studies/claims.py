"""Check the paper's sentences on its results one by one:  python -m simulations.studies.claims [--page FILE.md]."""

import math

from ..command.command import comm, on_root, run, say
from ..output.files import write_text
from .commandline import make_folders, study_parser
from .paper.claim import minus_signs, table
from .paper.claims_coupling import AGREES_WELL, coupling_claims, cycle_claims, difference, difference_table, differences
from .paper.claims_theory import theory_claims
from .paper.comparisons import COUPLED
from .paper.elements import Runs
from .paper.setting import AMPLITUDE, MU, NU

FRICTION = (0.1, 0.3, 0.6)  # coefficients for which the paper's coupled pair is tried

INTRODUCTION = f"""\
# The paper's sentences, checked

Sentences of Sections 4 and 5 of Heß, Giesa, Riechert, Wilhayn, Appl. Sci. 2026, 16(1), 473 that a number can
decide. Made by

    ./docker/run python -m simulations.studies.claims --page docs/claims.md

The paper gives no ν for Figures 4–9 and no μ: ν = {NU:g} and μ = {MU:g} unless said otherwise. "Well", "minor",
"marginal" and "can be neglected" are taken as a difference of at most {AGREES_WELL:.0%}.

## By the closed forms, and through the cycle

"""
COUPLING = "\n## Coupling, by simulation\n\n"
OVER_NU = f"""
## How much the neglected coupling matters

Difference of a simulation with coupling from the closed forms, in per cent: slip since loading began (L2 over the
contact, at the first +Q_A) / traction (likewise) / energy of the second cycle (signed). Q_A = {AMPLITUDE:g} μP,
μ = {MU:g}; y0 does not matter, as a power law has no length of its own. Half-plane solver without
load steps, `analytic/coupled/`; finite elements agree at the paper's pairs, above. A dash: no convergence. The
difference vanishes at the Holl ratio, ν = 1/(2+k): 0.5 at k = 0, 0.43 at 0.3, 0.4 at 0.5.

"""


def main(arguments: list[str]):
    """Check every sentence, print the table, and write it as a page where one is asked for."""
    parser = study_parser("claims", __doc__, page="the table")
    page = on_root(lambda: make_folders(parser.parse_args(arguments))).page
    say("closed forms and loops of the half-plane")
    found = differences(comm)
    say("finite elements at the paper's pairs")
    coupled = coupling_claims(Runs(comm), found)
    if comm.rank == 0:
        text = INTRODUCTION + table(theory_claims() + cycle_claims()) + COUPLING + table(coupled)
        text += OVER_NU + difference_table(found) + friction_line()
        say(text)
        if page is not None:
            write_text(page, text)
            say(f"written to {page}")


def friction_line() -> str:
    """How the difference of the paper's coupled pair depends on mu."""
    found = {mu: difference(COUPLED.k, COUPLED.nu, mu) for mu in FRICTION}
    words = [f"μ = {mu:g}: {one.in_per_cent()}" for mu, one in found.items() if not math.isnan(one.slip)]
    text = f"\nThe difference in slip and traction grows with μ, that in energy hardly does: at {COUPLED.name}, "
    elsewhere = "[coupling.md](coupling.md) takes other measures of slip and energy."
    return minus_signs(f"{text}{'; '.join(words)}.\n{elsewhere}\n")


if __name__ == "__main__":
    run(main)
