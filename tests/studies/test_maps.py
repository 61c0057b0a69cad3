"""Energy maps: their points are loops, and one loop serves every depth."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpi4py import MPI
from running import run_command

from analytic import ContactNotConverged, GradedHalfPlane, ProfileContact
from simulations.studies import maps
from simulations.studies.mapping import pictures
from simulations.studies.mapping.answers import answer
from simulations.studies.mapping.loops import simulate
from simulations.studies.mapping.points import Point, by_simulation, by_theory, depth_factors, load, profile
from simulations.studies.paper import energies
from simulations.studies.paper.elements import Runs
from simulations.studies.paper.setting import MU, contact, own_units

POINT = Point(k=0.5, amplitude=0.6, m=2.0, nu=0.4, mu=0.3)  # at the Holl ratio


@pytest.mark.parametrize("k", [-0.5, 0.4])
@pytest.mark.parametrize("depth", [0.01, 10.0])
def test_depth_factor_of_the_energy(k, depth):
    """The map's theory is Figure 8's curve, which takes y0 directly."""
    found = by_theory(Point(k, 0.7, 2.0, 0.3, 0.3)).energy * depth_factors(k, 2.0, depth)[0]
    assert found == pytest.approx(float(energies.curve(k, depth, 0.7)), rel=1e-12)


@pytest.mark.parametrize("m", [1.5, 2.0, 4.0])
def test_profiles_share_the_homogeneous_half_width(m):
    solid = GradedHalfPlane(E0=1.0, nu=0.3, k=0.0, y0=1.0)
    assert ProfileContact.from_load(solid, profile(m, 0.3), load(0.3), 10.0).a == pytest.approx(1.0, rel=1e-12)


def test_depth_factors_hold_with_coupling():
    """The same loop at another y0, blunt profile, k < 0; the discretisation scales along."""
    k, m, depth = -0.3, 4.0, 20.0
    point = Point(k, 0.6, m, 0.3, 0.3)
    solid = GradedHalfPlane(E0=1.0, nu=0.3, k=k, y0=depth)
    loop = simulate(solid, profile(m, 0.3), load(0.3), 0.3, 0.6)
    unit = 0.3**2 * load(0.3)
    here, factors = by_simulation(point), depth_factors(k, m, depth)
    assert loop.dissipated_energy / (unit / 2) == pytest.approx(here.energy * factors[0], rel=1e-9)
    assert loop.peak_density() / unit == pytest.approx(here.density * factors[1], rel=1e-9)


def test_simulation_is_the_theory_where_that_is_exact():
    """At the Holl ratio, 100 nodes: energy and its peak density to 1e-3."""
    simulated, theory = by_simulation(POINT), by_theory(POINT)
    assert simulated.energy == pytest.approx(theory.energy, rel=1e-3)
    assert simulated.density == pytest.approx(theory.density, rel=1e-3)


def test_without_an_attempt_there_is_no_loop():
    with pytest.raises(ContactNotConverged, match="no attempt"):
        simulate(GradedHalfPlane(E0=1.0, nu=0.3, k=0.3, y0=1.0), profile(2.0, 0.3), load(0.3), 0.3, 0.9, attempts=())


def test_density_sums_up_to_the_energy():
    """1e-4: trapezoids between the states' nodes."""
    solid = GradedHalfPlane(E0=1.0, nu=0.3, k=0.3, y0=1.0)
    loop = simulate(solid, profile(2.0, 0.3), load(0.3), 0.3, 0.9)
    x = np.linspace(-2.5, 2.5, 4001)
    assert np.trapezoid(loop.energy_density(x), x) == pytest.approx(loop.dissipated_energy, rel=1e-4)


def test_coupling_takes_energy_at_a_stiff_surface():
    """k = -0.5, blunt, low load: less than half of what the theory says, as the coupling map shows."""
    point = Point(-0.5, 0.4, 4.0, 0.3, 0.3)
    assert by_simulation(point).energy < 0.5 * by_theory(point).energy


@pytest.mark.slow
def test_finite_elements_find_the_same_energy():
    """Where coupling takes a third of the theory's energy; the solver's work is of first order in its load steps."""
    k, nu, amplitude = -0.5, 0.3, 0.6
    normal = contact(k, 1.0, nu)
    mesh_free = simulate(normal.solid, profile(2.0, nu), normal.P, MU, amplitude, cycles=1, attempts=((24, 150),))
    elements = Runs(MPI.COMM_SELF).loop(k, nu, amplitude, coupling=True).energy * own_units(normal).energy
    assert elements == pytest.approx(mesh_free.dissipated_energy, rel=1.5e-3)
    theory = normal.fretting(MU, z=1 - amplitude).dissipated_energy
    assert elements == pytest.approx(0.637 * theory, rel=2e-3)


def test_answers():
    """Thick grading: the stiffer surface loses least. Thin: it loses most."""
    found = {p: by_theory(p) for p in (Point(k, 0.6, 2.0, 0.3, 0.3) for k in (-0.5, 0.0, 0.5))}
    thick, thin = answer(found, "energy", 2.0, 0.6, 10.0), answer(found, "energy", 2.0, 0.6, 0.01)
    assert (thick["least"][0], thick["most"][0]) == (-0.5, 0.5)
    assert (thin["least"][0], thin["most"][0]) == (0.5, -0.5)
    homogeneous = float(energies.curve(0.0, 1.0, 0.6))
    assert thick["most"][1] == pytest.approx(float(energies.curve(0.5, 10.0, 0.6)) / homogeneous, rel=1e-9)


def test_the_line_of_equal_energy_crosses_the_homogeneous_contact():
    """On it y0 = (W_0/W_k)^((m + k)/(k m)) by ``depth_factors``, 1 % for the contour; one curve, through k = 0 too."""
    k, m = [-0.4, -0.2, 0.0, 0.2, 0.4], 2.0
    found = {p: by_theory(p) for p in (Point(one, 0.6, m, 0.3, 0.3) for one in k)}
    energies_by_k = {p.k: e.energy for p, e in found.items()}
    figure = pictures.over_depth(found, [(m, 0.6)], "", "")
    (curve,) = [c for c in figure.axes[0].collections if c.get_linewidth()[0] > 2]
    plt.close(figure)
    (line,) = curve.get_paths()
    x, y0 = line.vertices[line.vertices[:, 0].argsort()].T
    expected = [(energies_by_k[0.0] / energies_by_k[one]) ** ((m + one) / (one * m)) for one in k if one]
    assert np.interp([one for one in k if one], x, y0) == pytest.approx(expected, rel=1e-2)


def test_only_loops_that_converged_are_drawn(tmp_path, monkeypatch):
    """A profile without any is left out, then all are; the page shows no map of an earlier call."""
    grid = ["--k", "-0.2", "0.2", "--amplitudes", "0.4", "0.8", "--profiles", "2", "4", "--output", str(tmp_path)]
    monkeypatch.setattr(maps, "save", lambda figure, *_: plt.close(figure))
    for converged, drawn in ((2.0, ["theory", "profiles", "loads", "coupling"]), (None, ["theory"])):

        def loop(values, converged=converged):
            if values["m"] != converged:
                raise ContactNotConverged("not found")
            return vars(by_theory(Point(**values)))

        monkeypatch.setattr(maps, "_loop", loop)
        maps.main(grid)
        page = (tmp_path / "maps.md").read_text()
        assert re.findall(r"map_(\w+)\.png", page) == drawn and "nan" not in page
        (tmp_path / "loops.jsonl").unlink(missing_ok=True)


@pytest.mark.slow
def test_the_command_draws_its_maps_and_says_what_they_tell(tmp_path):
    grid = ["--k", "-0.2", "0.2", "--amplitudes", "0.4", "0.8", "--profiles", "2"]
    done = run_command(*grid, "--output", tmp_path, module="simulations.studies.maps", ranks=2)
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "loops.jsonl").read_text().splitlines()) == 3 * 2  # k = 0 is added
    for name in ("map_theory", "map_profiles", "map_loads", "map_coupling"):
        assert (tmp_path / f"{name}.png").stat().st_size > 1e4
        assert (tmp_path / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    assert "least energy" in (tmp_path / "maps.md").read_text()
