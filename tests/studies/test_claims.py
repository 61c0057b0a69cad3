"""The checked table of the paper's sentences: what docs/claims.md says is what the code finds."""

import re

import pytest
from running import ROOT

from simulations.studies.paper.claim import minus_signs
from simulations.studies.paper.claims_coupling import TABLE_NU, cycle_claims, difference
from simulations.studies.paper.claims_theory import theory_claims

PAGE = (ROOT / "docs" / "claims.md").read_text(encoding="utf-8")


def without_round_off(text):
    """Only round-off depends on the machine."""
    return re.sub(r"\d+e-1\d", "round-off", text)


def test_page_holds_the_rows_found_now():
    """Every row of the closed forms and of the cycle, letter by letter, with its verdict."""
    claims = theory_claims()
    assert len(claims) == 15
    for claim in claims + cycle_claims():
        assert without_round_off(claim.row()) in without_round_off(PAGE)


@pytest.mark.parametrize("k, nu", [(0.5, 0.4), (0.3, 0.3)])
def test_cells_of_the_coupling_table(k, nu):
    """A cell regenerated: zero at the Holl ratio, slip 16 per cent at the paper's other pair."""
    found = difference(k, nu)
    cell = minus_signs(found.in_per_cent().replace("%", ""))
    (row,) = [line for line in PAGE.splitlines() if line.startswith(f"| {k:g} |") and " / " in line]
    assert row.split(" | ")[1 + TABLE_NU.index(nu)].strip(" |") == cell
    if nu == 0.4:
        assert max(found.slip, found.traction, abs(found.energy)) < 1e-8
    else:
        assert found.slip == pytest.approx(0.159, abs=1e-3)
