"""The study of stated and true errors."""

from types import SimpleNamespace

import pytest

from simulations.runs.comparison import NoReference
from simulations.studies import campaign

COARSE = {"mesh.facet": 0.2, "mesh.edge_facet": 0.02, "mesh.first_layer": 0.02, "solver.increments": 1}


def test_two_drawn_scenes(monkeypatch):
    """Each judged by its own reference, the coupled one by that without load steps; the stated errors are true."""
    monkeypatch.setattr(campaign, "ORDERS", (4, 6))
    scenes = {
        name: values | COARSE | {"solid.k": 0.3, "load.cycles": 0} for name, values in campaign.drawn(2).items()
    }
    found = [campaign.solve(values) for values in scenes.values()]
    assert [row["reference"] for row in found] == ["closed form", "half-plane solver without load steps"]
    rows = campaign.flat(scenes, found)
    assert {row["quantity"] for row in rows} == {"p", "q", "slip", "energy"}
    assert {row["verdict"] for row in rows} == {"holds"}
    assert all(0 < float(row["true"]) < 0.2 for row in rows if row["quantity"] in "pq")


STAGES = [("run", "Simulation"), ("reference", "of_same_physics"), ("truth", "truths")]


@pytest.mark.parametrize("missing, fails", STAGES)
def test_what_is_missing_is_named(monkeypatch, missing, fails):
    """A run whose truth is not found has not failed."""

    class Ended:
        def run_to_end(self):
            return self

    def none(*_):
        raise NoReference("not found")

    for name, does in {"Simulation": lambda *_: Ended(), "of_same_physics": lambda *_: None, fails: none}.items():
        monkeypatch.setattr(campaign, name, does)
    scenes = campaign.drawn(1)
    (row,) = campaign.flat(scenes, [campaign.solve(values) for values in scenes.values()])
    assert row["verdict"] == f"no {missing}: not found"


@pytest.mark.parametrize(
    "stated, true, doubt, said",
    [
        (1e-3, 1.9e-3, 0.0, "holds"),
        (1e-3, 2.1e-3, 0.0, "too small"),
        (1e-3, 1e-3, 4e-4, "truth not known"),
        (1e-3, 1e-2, 3e-3, "too small"),
    ],
)
def test_verdict(stated, true, doubt, said):
    assert campaign.verdict({"stated": stated, "true": true, "doubt": doubt}) == said


@pytest.mark.parametrize("stated, rows", [({}, 0), ({campaign.ENERGY: 0.2}, 1)])
def test_an_energy_for_which_no_error_is_stated_is_not_judged(monkeypatch, stated, rows):
    """An error that is not a number would count as one that holds."""
    for name, found in {"compare": stated, "compare_state": {}, "apart": {}}.items():
        monkeypatch.setattr(campaign, name, lambda *_, found=found: found)
    monkeypatch.setattr(campaign, "all_states", lambda history: history.entries)
    entry = SimpleNamespace(step=SimpleNamespace(P=1.0, Q=0.1), number=3)
    truth = SimpleNamespace(dissipated_energy=lambda: 1.0)
    history = SimpleNamespace(entries=[entry], dissipated_energy=1.1)
    judged = campaign.judged(SimpleNamespace(history=history, mu=0.3), None, truth, truth)
    assert [row["true"] for row in judged] == pytest.approx([0.1] * rows)


def test_the_draw_is_seeded_and_the_kinds_take_turns():
    scenes = campaign.drawn(20)
    assert list(scenes.items()) == list(campaign.drawn(40).items())[:20]
    only = campaign.drawn(20, ["nested loops"])
    assert len(only) == 4 and only.items() <= scenes.items()
