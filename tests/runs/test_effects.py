"""Only the effects that a scene calls for: what is on, what is off leaves no trace, and each against its reference."""

import json
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from running import ROOT, coarse_arguments, csv_rows, run_command
from solving import coarse_simulation, deviations, simulated, solved

from analytic import ContactNotConverged
from forms.contact import X, Y
from simulations import fretting
from simulations.indentation import DEFAULT_SCENE as INDENTATION
from simulations.runs import mesh_free, reference
from simulations.runs.comparison import compare, compare_state
from simulations.runs.explain import explain
from simulations.runs.mesh_free import MeshFree
from simulations.scene import SceneError, make_scene, parse
from simulations.scene.effects import Effects

FINE = {
    "mesh__facet": 0.0125,
    "mesh__edge_facet": 3e-4,
    "mesh__growth": 1.2,
    "mesh__first_layer": 1e-3,
    "mesh__layer_growth": 1.25,
    "solver__increments": 1,
}
UNCOUPLED = {"effects__coupling": "false", "solid__nu": 0.3}


@pytest.mark.slow
@pytest.mark.parametrize(
    "k, limit",
    [(0.0, 1e-4), (0.2, 1e-4), (0.5, 1e-4), (0.7, 1e-4), (0.9, 1e-4), (-0.1, 1e-3), (-0.3, 1e-3), (-0.5, 3e-3)],
)
def test_uncoupled_loops_match_the_closed_forms(k, limit):
    for name, deviation in deviations(solved(**(FINE | UNCOUPLED), solid__k=k)).items():
        assert abs(deviation) < limit, name


def test_at_the_holl_ratio_coupling_changes_nothing():
    on, off = solved(), solved(effects__coupling="false")
    for one, other in zip(on.history.entries, off.history.entries, strict=True):
        scale = one.surface.pressure.max()
        assert one.surface.traction == pytest.approx(other.surface.traction, abs=5e-3 * scale)
    assert on.history.dissipated_energy == pytest.approx(off.history.dissipated_energy, rel=2e-4)


@pytest.mark.parametrize(
    "changes, coupled",
    [
        ({}, False),
        ({"solid.nu": 0.3}, True),
        ({"solid.nu": 1 / 2.3 + 1e-6}, True),
        ({"solver.theta": 1.0}, True),
        ({"effects.friction_in_normal_stage": True}, True),
        ({"load.points": None, "load.P": 1e6, "load.amplitude": 0.5}, True),
    ],
)
def test_a_path_at_the_holl_ratio_has_no_coupling(changes, coupled):
    """Unless one system is asked for; a loop keeps it, as no edge of contact passes points there."""
    path = {"load.P": None, "load.amplitude": None, "load.cycles": None, "load.points": [[1e6, 0.0], [2e6, 1e5]]}
    assert ("coupling" in Effects(make_scene(path | changes))) is coupled


def test_without_coupling_the_pressure_of_the_normal_stage_stays():
    entries = solved(**UNCOUPLED).history.entries
    for entry in entries[1:]:
        assert entry.surface.pressure == pytest.approx(entries[0].surface.pressure, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("method", ["condensed", "full"])
def test_half_a_domain_gives_the_whole_contact(method):
    whole = next(coarse_simulation(solid__nu=0.3).run()).surface
    half_simulation = coarse_simulation(INDENTATION, solver__method=method)
    half = next(half_simulation.run()).surface
    assert half_simulation.body.is_half
    assert half.line_load(half.pressure) == pytest.approx(half_simulation.contact.P, rel=1e-8)
    # the whole mesh is also graded to the stick edges: compare where both are fine
    inside = np.abs(half.x) < 0.9
    pressure = np.interp(half.x[inside], whole.x, whole.pressure)
    assert half.pressure[inside] == pytest.approx(pressure, abs=1e-2 * whole.pressure.max())
    assert half.u[X] == pytest.approx(-half.u[X][::-1], abs=1e-12)


def test_frictionless_scene_leaves_no_trace_of_friction(tmp_path):
    simulation = coarse_simulation(INDENTATION)
    problem = simulation.stepping.problem
    assert simulation.stepping.frictional is None
    assert problem.directions == (Y,) and problem.memory is None and problem.safeguards is None
    done = run_command(*coarse_arguments(tmp_path), module="simulations.indentation")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "surface.h5") as file:
        assert not [name for name in file if name.startswith(("traction", "slip", "Q_", "frictional"))]
    columns = csv_rows(tmp_path / "history.csv")[0]
    assert not [name for name in columns if name.startswith(("Q", "delta_x", "c[", "dissipated"))]


def test_explain_names_every_effect_and_writes_nothing(tmp_path):
    done = run_command("--explain", "--output", tmp_path / "results")
    assert done.returncode == 0
    names = ("grading", "friction", "symmetry", "coupling", "friction in normal stage", "incompressibility")
    for name in (*names, "load schedule", "indenter profile", "anchors of stick", "unknowns"):
        assert name in done.stdout
    assert "a = 0.001044 m, mean pressure P/(2a) = " in done.stdout  # a wrong unit is seen before the run
    assert not (tmp_path / "results").exists()


def test_explain_tells_why_the_full_method_is_taken():
    assert "solver.theta = 1 needs it" in explain(coarse_simulation(solver__theta=1))
    assert "solver.theta" not in explain(coarse_simulation(solver__method="full"))


# Measured differences of the coupled from the uncoupled problem, by finite elements and boundary elements that share no
# code with these: pressure, traction, energy.
@pytest.mark.parametrize(
    "k, nu, pressure, traction, energy",
    [(0.3, 0.3, 0.073, 0.085, -0.054), (0.0, 0.3, 0.11, 0.14, -0.125), (-0.5, 0.3, 0.20, 0.26, -0.275)],
)
def test_coupling_is_as_large_as_independent_solvers_find(k, nu, pressure, traction, energy):
    mesh = {"mesh__facet": 0.05, "mesh__edge_facet": 0.01, "mesh__first_layer": 0.01}
    found = deviations(solved(**mesh, solid__k=k, solid__nu=nu, solver__increments=4))
    assert found["pressure_l2"] == pytest.approx(pressure, abs=0.006)
    assert found["traction_l2"] == pytest.approx(traction, abs=0.006)
    assert found["dissipated_energy"] == pytest.approx(energy, abs=0.006)


@pytest.mark.parametrize("k, nu, friction_first", [(0.0, 0.3, False), (0.3, 0.3, True)])
def test_coupled_loops_match_the_half_plane_solver(k, nu, friction_first):
    """No mesh, weak form or truncation is shared."""
    simulation = solved(
        solid__k=k,
        solid__nu=nu,
        effects__friction_in_normal_stage=str(friction_first).lower(),
        mesh__facet=0.025,
        mesh__edge_facet=5e-3,
        mesh__layer_growth=1.4,
        mesh__first_layer=1e-3,
        solver__increments=6,  # each sums its dissipation over increments in its own way
    )
    found = compare(simulation.history, MeshFree(simulation))
    for name, limit in {"pressure_l2": 2e-3, "traction_l2": 3e-3, "a": 1e-3, "dissipated_energy": 2e-3}.items():
        assert abs(found[name]) < limit, (name, found[name])


def test_half_plane_solver_is_tried_with_fewer_nodes(monkeypatch):
    """What it ended with is said; where it fails with all, so is why it did with the most."""
    simulation = coarse_simulation(solid__nu=0.3, load__cycles=0, solver__increments=1)
    solver, most, least = mesh_free.half_plane_solver, mesh_free.NODES[0], mesh_free.NODES[-1]

    def failing_above(limit):
        def choose(scene, scaled, effects, nodes):
            if nodes > limit:
                raise ContactNotConverged(f"with {nodes} nodes")
            return solver(scene, scaled, effects, nodes)

        return choose

    monkeypatch.setattr(mesh_free, "half_plane_solver", failing_above(least))
    assert f"of {least} nodes" in reference.describe(MeshFree(simulation), simulation)
    monkeypatch.setattr(mesh_free, "half_plane_solver", failing_above(0))
    with pytest.raises(reference.NoReference, match=f"with {most} nodes"):
        MeshFree(simulation)


@pytest.mark.parametrize("error, kept", [(0.06, 8), (0.3, 2), (None, 2)])
def test_more_load_steps_of_the_reference_are_kept_only_where_they_help(monkeypatch, error, kept):
    """Its q is off by 25 % with two for one, where 10 % are allowed: so by four times as many on fewer nodes."""
    scene, errors = SimpleNamespace(effects=SimpleNamespace(elastic_slip=None)), {2: 0.25, 8: error}
    simulation = SimpleNamespace(history=None, schedule=[], scene=scene, effects=())

    def solution(simulation, tell, nodes=mesh_free.NODES, finer=2, estimated=True):
        assert nodes == {2: mesh_free.NODES, 8: mesh_free.FEWER_NODES}[finer]
        if errors[finer] is None:
            raise reference.NoReference("it does not converge")
        return SimpleNamespace(finer=finer)

    monkeypatch.setattr(reference, "MeshFree", solution)
    errors_of = {finer: SimpleNamespace(own={"traction_l2": one}) for finer, one in errors.items()}
    monkeypatch.setattr(reference, "compare_all", lambda history, found: errors_of[found.finer])
    assert reference._mesh_free(simulation, None).finer == kept


def worst_of_states(simulation, other) -> dict[str, float]:
    """Largest errors at the first +Q_A and at A to E of the cycles."""
    states = [compare_state(entry, other) for entry in simulation.history.entries if entry.step.state]
    assert len(states) == 1 + 5 * simulation.scene.load.cycles
    return {name: max(state[name] for state in states) for name in ("pressure_l2", "traction_l2")}


@pytest.mark.slow
@pytest.mark.parametrize(
    "k, nu, mu, cycles",
    [(0.3, 0.3, 0.6, 2), (0.0, 0.3, 0.3, 1), (0.0, 0.3, 0.6, 1), (-0.1, 0.495, 0.3, 1), (-0.1, 0.495, 0.6, 1)],
)
def test_coupled_loop_is_accurate_at_every_state(k, nu, mu, cycles):
    """The paper's pairs, on a mesh graded to the edges of all states; one, on the usual mesh, is the next test."""
    keys = {"solid.k": k, "solid.nu": nu, "load.mu": mu, "load.cycles": cycles, "mesh.edges": "states"}
    simulation = simulated(keys)
    worst = worst_of_states(simulation, MeshFree(simulation))
    assert worst["pressure_l2"] < 5e-4 and worst["traction_l2"] < 1e-3


@pytest.mark.slow
def test_what_edges_after_every_load_step_gain():
    """The usual mesh is graded to them: more accurate than one that is graded to a rough solution's edges."""
    scene = {"solid.k": 0.0, "solid.nu": 0.3}
    simulation = simulated(scene)
    other = MeshFree(simulation)
    fine = worst_of_states(simulation, other)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("simulations.runs.plan.grades", lambda *_: False)
        rough = worst_of_states(simulated(scene), other)
    assert fine["pressure_l2"] < 5e-4 and fine["traction_l2"] < 1e-3
    assert fine["traction_l2"] < rough["traction_l2"] / 2


def test_friction_in_the_normal_stage_starts_with_locked_in_traction():
    """Pressed on with friction away from the Holl ratio, a self-equilibrated traction is there before Q is."""
    simulation = coarse_simulation(solid__nu=0.3, effects__friction_in_normal_stage="true", solver__normal_increments=8)
    for entry in simulation.run():
        if entry.step.branch != "normal":
            break
        assert not np.any(entry.slip)  # which counts from the end of this stage
        pressed = entry.surface
    mu = simulation.mu
    assert np.abs(pressed.traction).max() > 0.05 * mu * pressed.pressure.max()
    assert pressed.line_load(pressed.traction) == pytest.approx(0.0, abs=1e-8)
    # self-similar up to the mesh: antisymmetric, and towards the middle, where the pressure drags the surface to
    assert pressed.traction == pytest.approx(-pressed.traction[::-1], abs=2e-2 * mu * pressed.pressure.max())


def test_pressing_starts_from_the_contact_of_its_first_load():
    """From that of the last load 54 iterations led there, by a facet at each edge every time; on finer meshes none."""
    early = {"effects__friction_in_normal_stage": "true", "solver__normal_increments": 20, "load__cycles": 0}
    mesh = {"mesh__first_layer": 0.01, "mesh__edge_facet": 0.005}
    first = next(iter(coarse_simulation(solid__k=-0.7, solid__nu=0.3, **early, **mesh).run()))
    assert first.iterations <= 15 and first.cuts == 0


def test_friction_follows_from_the_scene():
    assert parse(INDENTATION).effects.friction is False
    with pytest.raises(SceneError, match="load.mu is missing"):
        parse(INDENTATION, ("load.amplitude=0.5",))
    with pytest.raises(SceneError, match="friction_in_normal_stage"):
        parse((ROOT / "scenes" / "uncoupled.toml").read_text(), ("effects.friction_in_normal_stage=true",))


# Their references are tested where their effects are, and take longer than the runs.
UNREFERENCED = {
    "coating", "formula", "linear_coating", "locked_in", "measured_modulus", "negative_grading", "path", "rounded_flat"
}


@pytest.mark.parametrize("scene", sorted((ROOT / "scenes").glob("*.toml")), ids=lambda path: path.stem)
def test_ready_scenes_run(scene, tmp_path):
    more = {"reference__kind": '"none"'} if scene.stem in UNREFERENCED else {}
    fretting.main([str(scene), *coarse_arguments(tmp_path, **more)])
    assert json.loads((tmp_path / "summary.json").read_text())["converged"] is True
