"""The study of hard cases: a part of them, the command, the draw, and its table."""

import re

import pytest
from running import run_command

from simulations.runs import checks
from simulations.scene import make_scene
from simulations.studies import stability
from simulations.studies.stability_report import FAILED, FAILING, GREEN, REFUSED, UNJUDGED, WRONG, action, table


def test_a_part_of_the_matrix():
    cases = list(stability.read_cases().items())[12::14]  # from here on as many studies as from 0 on, in half the time
    ended = {name: stability.solve(values)["outcome"] for name, values in cases}
    assert set(ended.values()) <= {GREEN, REFUSED}, ended
    refused = [name for name, outcome in ended.items() if outcome == REFUSED]
    assert [name.split(":")[0] for name in refused] == ["box pressure", "small amplitude", "absurd meshes"], refused


def test_the_command_writes_and_resumes(tmp_path):
    arguments = ["--output", str(tmp_path), "--only", "units"]
    first = run_command(*arguments, module="simulations.studies.stability", ranks=2)
    assert first.returncode == 0, first.stderr
    assert "4 cases: 4 converged" in first.stdout
    for name in ("stability.csv", "stability.md", "stability.png"):
        assert (tmp_path / name).stat().st_size > 0
    again = run_command(*arguments, module="simulations.studies.stability")
    assert "units:" not in again.stdout and "4 cases: 4 converged" in again.stdout


def test_the_draw_is_seeded_and_admissible():
    cases = stability.drawn_cases(20)
    assert list(cases) == list(stability.drawn_cases(40))[:20] and len(cases) == 20
    for values in cases.values():
        make_scene({key: value for key, value in values.items() if key != stability.EVERY_STATE}, base=None)


@pytest.mark.parametrize(
    "outcome, why, what",
    [
        (REFUSED, "mesh.edge_facet = 0.02 is too coarse: 0.01 or less would do", "the reason names"),
        (FAILING, "traction zigzags 8.0e-02; mu = 2 is above 1.4: less of it may help", "less of it"),
        (FAILED, "no equilibrium: Newton cycles", "increments"),
        (UNJUDGED, f"error of traction 5.1e-01; {checks.UNKNOWN.format(0.35)}", "more solver.increments"),
        (WRONG, f"error of traction 5.1e-01; {checks.LARGE}", "mesh.layer_growth"),
    ],
)
def test_table_tells_what_a_user_can_do(outcome, why, what):
    assert what in action({"outcome": outcome, "why": why})


def test_a_check_of_absolute_values_makes_no_cells_of_its_own():
    row = {"name": "load: P 1.0", "outcome": FAILING, "why": "|q| <= mu p 1.0e-03", "friction": "below"}
    line = table([row]).splitlines()[-1]
    cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
    assert cells[:4] == [row["name"], FAILING, r"\|q\| <= mu p 1.0e-03", "below"] and len(cells) == 5


@pytest.mark.parametrize("own, outcome", [(0.4, UNJUDGED), (0.05, WRONG)])
def test_a_reference_that_is_hardly_known_calls_no_run_wrong(own, outcome, monkeypatch):
    errors = {"traction_l2": 0.9}
    found = errors, checks.check_errors(errors, {"traction_l2": own})
    monkeypatch.setattr(stability, "_errors", lambda *_: found)
    row = stability.solve(next(iter(stability.read_cases(["Holl ratio"]).values())))
    assert row["outcome"] == outcome and "error of traction" in row["why"]
