"""Fields of the body: against stresses that share nothing with the finite elements, and read back by other tools."""

import os
import runpy
import shutil
from types import SimpleNamespace

import h5py
import numpy as np
import pandas
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from running import coarse_arguments, csv_rows, run_command, surface
from solving import coarse_simulation

from simulations import fretting
from simulations.fem.body_sample import BodySampler
from simulations.loading.schedule import pressing, rocking
from simulations.output.body_quantities import from_stress
from simulations.output.body_states import body_functions
from simulations.output.field_index import local_nodes
from simulations.output.fields import FieldWriter, kept
from simulations.scene import SceneError, make_scene
from simulations.scene.output import FIELDS, Output

UNCOUPLED = {"effects__coupling": "false", "load__cycles": 0}
FINER = {"mesh__facet": 0.05, "mesh__growth": 1.3, "mesh__layer_growth": 1.3}


def gauss(low, high, count=200):
    """Nodes and weights on low ... high, close together at the ends, where tractions have roots and kinks."""
    t, weights = np.polynomial.legendre.leggauss(count)
    middle, half = (low + high) / 2, (high - low) / 2
    return middle + half * np.sin(np.pi / 2 * t), half * weights * np.pi / 2 * np.cos(np.pi / 2 * t)


def line_force_stress(solid, x, y, is_normal):
    """xx, yy, xy (3, ...) below a line force of 1 along +y or +x at 0; y is the depth.

    The stress is radial and ~ cos^k(theta) cos or sin(beta theta)/r; its size follows from equilibrium of a half circle
    alone, and beta is the only number of the solid.
    """
    k, beta, shape = solid.k, solid.beta, np.cos if is_normal else np.sin
    t, weights = gauss(-np.pi / 2, np.pi / 2)
    size = weights @ (np.cos(t) ** k * shape(beta * t) * (np.cos(t) if is_normal else np.sin(t)))
    r, theta = np.hypot(x, y), np.arctan2(x, y)
    radial = -(np.cos(theta) ** k) * shape(beta * theta) / (r * size)
    return np.stack([radial * np.sin(theta) ** 2, radial * np.cos(theta) ** 2, radial * np.sin(theta) * np.cos(theta)])


def stress_below(simulation, x, y):
    """xx, yy, xy, zz (n, 4) below the closed forms (44) and (47) of p and q at +Q_A."""
    loop, total = simulation.loop, 0.0
    for ends in ((-loop.a, -loop.c), (-loop.c, loop.c), (loop.c, loop.a)):
        xi, weights = gauss(*ends)
        for load, is_normal in ((loop.contact.pressure(xi), True), (loop.traction(xi, loop.Q_A, "initial"), False)):
            unit = line_force_stress(loop.contact.solid, x[:, None] - xi, y[:, None] + 0 * xi, is_normal)
            total = total + unit @ (load * weights)
    xx, yy, xy = total
    return np.stack([xx, yy, xy, simulation.scene.solid.nu * (xx + yy)], axis=1)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"solid__k": -0.3, "solid__nu": 0.3} | UNCOUPLED,
        {"solid__k": 0.7, "solid__nu": 0.2} | UNCOUPLED,
        {"solid__k": 0, "solid__nu": 0.5},
    ],
    ids=["Holl ratio", "k < 0", "k = 0.7", "mixed form"],
)
def test_stress_against_line_forces(changes):
    """Second order in the mesh: within 0.3 % of the largest stress with these cells, 1 % with twice as large ones."""
    simulation = coarse_simulation(**(FINER | changes | {"load__cycles": 0})).run_to_end()
    sample = BodySampler(simulation.numbering).sample()
    x, y = np.concatenate([[np.linspace(-2, 2, 21), np.full(21, 0.5)], [np.full(15, 0.3), np.linspace(0.1, 3, 15)]], 1)
    expected = stress_below(simulation, x, y)
    assert np.abs(sample.stress_at(x, y) - expected).max() < 4e-3 * np.abs(expected).max()


@pytest.mark.parametrize("k", [-0.5, -0.3, 0.3])
def test_the_uppermost_cells_carry_the_tractions(k):
    """Cells of a thousandth of a carry p at each place and all of P and Q, though E is 0 or infinite."""
    changes = {"solid__k": k, "solid__nu": 0.3, "mesh__first_layer": 1e-3}
    simulation = coarse_simulation(**(FINER | UNCOUPLED | changes)).run_to_end()
    sample, loop = BodySampler(simulation.numbering).sample(), simulation.loop
    _, yy, xy, _ = sample.mean_stress()[0].T
    x = (sample.x[1:] + sample.x[:-1]) / 2
    inside = np.abs(x) < 0.8
    assert yy[inside] == pytest.approx(-loop.contact.pressure(x[inside]), rel=5e-3)
    near, wide = (np.diff(sample.x) * (np.abs(x) < end) for end in (2.0, 10.0))
    assert near @ yy == pytest.approx(-loop.contact.P, rel=2e-3)
    assert wide @ xy == pytest.approx(-loop.Q_A, rel=1e-2)  # some of Q comes in along x, where the surface is stiff


def test_what_follows_from_the_stress():
    """Against eigenvalues, the deviator and half of stress times strain, for stresses of any sign."""
    rng = np.random.default_rng(1)
    nu, young = 0.3, 2e11
    stress = rng.normal(size=(50, 4)) * 1e8
    stress[:, 3] = nu * (stress[:, 0] + stress[:, 1])
    found = from_stress(stress, young, nu)
    assert set(found) == set(FIELDS) - {"displacement"}
    for i, (xx, yy, xy, zz) in enumerate(stress):
        tensor = np.array([[xx, xy, 0], [xy, yy, 0], [0, 0, zz]])
        low, middle, high = np.linalg.eigvalsh(tensor)
        values = [found[f"principal_{n}"][i] for n in (1, 2, 3)]
        assert values == pytest.approx([high, middle, low], abs=1e-6)
        assert found["max_shear"][i] == pytest.approx((high - low) / 2)
        deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
        assert found["von_mises"][i] == pytest.approx(np.sqrt(1.5 * np.sum(deviator**2)))
        strain = ((1 + nu) * tensor - nu * np.trace(tensor) * np.eye(3)) / young
        assert abs(strain[2, 2]) < 1e-12  # plane strain
        assert found["energy_density"][i] == pytest.approx(np.sum(tensor * strain) / 2)


LINES = {"output__lines": "[[0, 0, 0, 2e-3, 5], [-1e-3, 1e-4, 1e-3, 1e-4, 7]]", "output__points": "[[1e-4, 2e-4]]"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    fretting.main([*coarse_arguments(folder, **LINES), "--quiet"])
    return folder


def test_functions_of_dolfinx(folder):
    """The gradient of the displacement that is given back, times E, is in the mean of each cell the stress: to 2 % as
    the file's mean is over Gauss points; both are where they belong.
    """
    fields = body_functions(folder, "A")
    u, mesh = fields["displacement"], fields["displacement"].function_space.mesh
    assert u.function_space.element.basix_element.degree == 2
    y, nu = ufl.SpatialCoordinate(mesh)[1], 1 / 2.3
    E = 210e9 * (-y / make_scene().solid.y0) ** 0.3
    strain = ufl.sym(ufl.grad(u))
    stress = E / (1 + nu) * (strain + nu / (1 - 2 * nu) * ufl.tr(strain) * ufl.Identity(2))
    constants = fields["stress_xx"].function_space
    test, dx = ufl.TestFunction(constants), ufl.dx(metadata={"quadrature_degree": 6})
    area = fem.assemble_vector(fem.form(test * dx)).array
    depth = -fem.assemble_vector(fem.form(y * test * dx)).array / area
    inside = area * ((depth > 2e-4) & (depth < 3e-3))
    for name, component in (("stress_xx", stress[0, 0]), ("stress_yy", stress[1, 1]), ("stress_xy", stress[0, 1])):
        mean, written = fem.assemble_vector(fem.form(component * test * dx)).array / area, fields[name].x.array
        assert inside @ (mean - written) ** 2 < 0.02**2 * (inside @ written**2), name


def test_the_gap_is_that_of_the_fields(folder):
    """f(x) - u_y - delta_y with u_y upwards, at every node of the surface and far from the middle too.

    This run is without coupling: after pressing, its gap is no longer that of the displacement, which has the u_y of q.
    """
    pressed = pandas.read_csv(folder / "history.csv").iloc[0]
    with h5py.File(folder / "fields" / f"{pressed['increment']:06d}.h5") as state, h5py.File(
        folder / "fields" / "mesh.h5"
    ) as mesh:
        points, u = mesh["points"][...], state["displacement"][...]
    with h5py.File(folder / "surface.h5") as file:
        x, gap, meaning = file["x"][...], file["gap"][0], file["gap"].attrs["meaning"]
    assert meaning.startswith("f(x) - u_y - delta_y with u_y upwards")
    top = points[:, 1] == 0
    order = np.argsort(points[top, 0])
    u_y = np.interp(x, points[top, 0][order], u[top, 1][order])
    assert gap == pytest.approx(x**2 / (2 * 0.1) - u_y - pressed["delta_y[m]"], abs=1e-9 * np.abs(u_y).max())


@pytest.mark.parametrize("k", [0.9, 0.6, 0.3, 0.0, -0.5, -0.8])
def test_the_energy_density_sums_to_the_energy(k, tmp_path):
    """Of the finite elements, u·K u/2, but for what stresses vary in cells, though E varies by many orders there."""
    simulation = coarse_simulation(**(FINER | UNCOUPLED), solid__k=k, solid__nu=0.3).run_to_end()
    last = len(simulation.schedule) - 1
    FieldWriter(tmp_path, simulation).write(last)
    with h5py.File(tmp_path / "fields" / f"{last:06d}.h5") as state, h5py.File(tmp_path / "fields" / "mesh.h5") as mesh:
        area = np.outer(np.diff(mesh["depth"][...]), np.diff(mesh["x"][...]))
        found = np.sum(area.ravel() * state["energy_density"][...])
    u, Ku = simulation.body.state.x.petsc_vec, simulation.body.state.x.petsc_vec.duplicate()
    simulation.body.stiffness.mult(u, Ku)
    assert found == pytest.approx(u.dot(Ku) / 2 * simulation.scaled.scales.energy, rel=1e-2)


def test_the_gap_without_coupling_is_that_of_the_pressure():
    """Under Q it stays what it was after pressing: closed in contact, open beside it; f(a) = 0.5 in these units."""
    simulation = coarse_simulation(solid__k=-0.5, solid__nu=0.0, **UNCOUPLED).run_to_end()
    height = simulation.scaled.indenter.height
    gaps = [height(e.surface.x) + e.surface.approach for e in simulation.history.entries]
    assert np.abs(simulation.history.entries[-1].surface.neglected).max() > 0.1
    for gap, entry in zip(gaps, simulation.history.entries, strict=True):
        assert gap == pytest.approx(gaps[0], abs=1e-9)
        closed = entry.surface.pressure > 0
        assert np.abs(gap[closed]).max() < 1e-3 and gap[~closed].min() > -1e-3


INTEGRALS = """
import sys, ufl
from dolfinx import fem
from mpi4py import MPI
from simulations.output.body_states import body_functions
fields = body_functions(sys.argv[1], "E", MPI.COMM_WORLD)
u = fields["displacement"]
for value in (u[0] ** 2, u[1], fields["stress_xy"] ** 2):
    total = MPI.COMM_WORLD.allreduce(fem.assemble_scalar(fem.form(value * ufl.dx)))
    MPI.COMM_WORLD.rank or print(total)
"""


def test_functions_on_more_ranks(folder, tmp_path, monkeypatch, capsys):
    """The same integrals on three ranks as on one."""
    program = tmp_path / "integrals.py"
    program.write_text(INTEGRALS)
    on_three = run_command(folder, ranks=3, cwd=tmp_path, module="integrals").stdout
    monkeypatch.setattr("sys.argv", [str(program), str(folder)])
    runpy.run_path(str(program), run_name="__main__")
    one, three = (np.array(text.split(), float) for text in (capsys.readouterr().out, on_three))
    assert len(one) == 3 and three == pytest.approx(one, rel=1e-10)


def test_vtkhdf_has_what_the_states_have(folder):
    """Its links lead to the data of every state, in the order of the XDMF series."""
    with h5py.File(folder / "fields.vtkhdf") as file:
        vtk = file["VTKHDF"]
        times, points = vtk["Steps/Values"][...], vtk["NumberOfPoints"][0]
        assert vtk.attrs["Type"] == b"UnstructuredGrid" and vtk["Points"].shape == (points, 3)
        assert vtk["Offsets"][-1] == vtk["Connectivity"].size == 9 * vtk["NumberOfCells"][0]
        for name in FIELDS:
            centre = "PointData" if name == "displacement" else "CellData"
            offsets = [*vtk[f"Steps/{centre}Offsets/{name}"][...], None]
            for path, start, stop in zip(sorted((folder / "fields").glob("0*.h5")), offsets, offsets[1:]):
                with h5py.File(path) as state:
                    assert np.array_equal(vtk[f"{centre}/{name}"][start:stop], state[name][...])
    assert times == pytest.approx([1, 2, 2.5, 3, 3.5, 4, 6])


def test_each_state_has_its_loads(folder):
    loads = surface(folder)
    for path in (folder / "fields").glob("0*.h5"):
        with h5py.File(path) as state:
            for name in ("P", "Q"):
                assert state.attrs[name] == pytest.approx(loads[f"{name}_prescribed"][int(path.stem)])


def test_nodes_of_a_cubic_cell_are_in_the_order_of_vtk():
    """Corners, then bottom, right, top and left edge, each in the direction of x or y, then row by row."""
    edges = [(1, 0), (2, 0), (3, 1), (3, 2), (1, 3), (2, 3), (0, 1), (0, 2)]
    inside = [(1, 1), (2, 1), (1, 2), (2, 2)]
    assert local_nodes(3) == [(0, 0), (3, 0), (3, 3), (0, 3), *edges, *inside]


def test_cells_have_their_nodes_in_place(folder):
    """Each node of a cell lies at its share of the straight sides: nothing is folded or exchanged."""
    with h5py.File(folder / "fields" / "mesh.h5") as file:
        points, cells = file["points"][...], file["cells"][...]
    low, high = points[cells[:, :1]], points[cells[:, 2:3]]
    assert np.all(high[..., :2] > low[..., :2])
    share = (points[cells] - low)[..., :2] / (high - low)[..., :2]
    assert share == pytest.approx(np.broadcast_to(np.array(local_nodes(2)) / 2, share.shape), abs=1e-9)


def test_lines(folder):
    """A row a point and state; stresses at a point are near those of its cell; sigma_yy = -p, sigma_xy = q at y = 0."""
    table = pandas.read_csv(folder / "lines.csv")
    assert list(table["along"].unique()) == ["line 1", "line 2", "point 1"]
    assert len(table) == 7 * (5 + 7 + 1) and list(table["state"].unique()) == ["normal", "A", "B", "C", "D", "E"]
    assert {f"{name}[Pa]" for name in FIELDS[1:-1]} < set(table.columns)
    top = table[(table["depth[m]"] == 0) & (table["increment"] == 2)]
    data = surface(folder)
    middle = np.abs(data["x"]).argmin()
    pressure, traction = data["pressure"][2, middle], data["traction"][2, middle]
    assert top["stress_yy[Pa]"].item() == pytest.approx(-pressure, rel=5e-3)
    assert top["stress_xy[Pa]"].item() == pytest.approx(traction, rel=5e-3)
    along = table[(table["along"] == "line 2") & (table["increment"] == 0)]
    with h5py.File(folder / "fields" / "000000.h5") as state, h5py.File(folder / "fields" / "mesh.h5") as mesh:
        points, u = mesh["points"][...], state["displacement"][:, 1]
    depth = np.unique(points[:, 1])[np.abs(np.unique(points[:, 1]) + 1e-4).argmin()]
    order = np.argsort(points[points[:, 1] == depth, 0])
    beside = [values[points[:, 1] == depth][order] for values in (points[:, 0], u)]
    assert along["displacement_y[m]"].to_numpy() == pytest.approx(np.interp(along["x[m]"], *beside), rel=0.02)


@pytest.mark.parametrize("degree", [1, 3])
def test_other_degrees(degree, tmp_path):
    changes = {"mesh__degree": degree, "load__cycles": 0, "output__fields": '["displacement", "stress_yy"]'}
    fretting.main([*coarse_arguments(tmp_path, **changes), "--quiet"])
    fields = body_functions(tmp_path, "A")
    assert set(fields) == {"displacement", "stress_yy"}
    assert fields["displacement"].function_space.element.basix_element.degree == degree
    y = fields["displacement"].function_space.mesh.geometry.x[:, 1]
    assert y.max() == 0.0
    delta = float(csv_rows(tmp_path / "history.csv")[-1]["delta_y[m]"])
    assert fields["displacement"].x.array[1::2].min() == pytest.approx(-delta, rel=1e-4)


def test_half_a_body_is_mirrored():
    """Without a tangential load the mesh is the half x > 0; points at x < 0 are answered all the same."""
    text = "solid.E0 = 2e11\nsolid.k = 0.3\nsolid.nu = 0.3\nsolid.y0 = 0.01\nindenter.R = 0.1\nload.P = 1e6\n"
    sample = BodySampler(coarse_simulation(text).run_to_end().numbering).sample()
    assert sample.is_half
    x, y = np.array([0.4, -0.4]), np.array([0.3, 0.3])
    (xx, yy, xy, zz), left = sample.stress_at(x, y)
    assert left == pytest.approx([xx, yy, -xy, zz]) and xy != 0
    right, left = sample.displacement_at(x, y)
    assert left == pytest.approx(right * [-1, 1])


@pytest.mark.parametrize("states, found", [('"all"', list(range(7))), ('["C"]', [4]), ('["normal", "A"]', [0, 2, 10])])
def test_states_that_are_asked_for(states, found, tmp_path):
    fretting.main([*coarse_arguments(tmp_path, output__states=states, reference__kind='"none"'), "--quiet"])
    there = [int(path.stem) for path in sorted((tmp_path / "fields").glob("0*.h5"))]
    assert there[: len(found)] == found and (len(there) == 11 or there == found)
    with pytest.raises(SceneError, match="no fields of state 'F': there are '"):
        body_functions(tmp_path, "F", MPI.COMM_SELF)
    one, same = (body_functions(tmp_path, number)["von_mises"].x.array for number in (there[-1], np.int64(there[-1])))
    assert (one == same).all()


def test_of_many_load_steps_of_pressing_the_last_is_the_normal_state():
    schedule = pressing(1.0, 3) + rocking(1.0, 0.1, cycles=0, quarter=2)
    assert kept(schedule, Output()) == {2: "normal", 4: "A"}


def test_a_state_of_which_there_are_several_is_the_last(folder, tmp_path):
    """A is reached at the end of the first loading, whose stress is made another one here, and at that of the cycle."""
    again = shutil.copytree(folder, tmp_path / "run")
    with h5py.File(again / "fields" / "000002.h5", "r+") as state:
        assert state.attrs["state"] == "A"
        state["von_mises"][...] *= 2.0
    found, last, first = (body_functions(again, state)["von_mises"].x.array for state in ("A", 10, 2))
    assert np.array_equal(found, last) and first == pytest.approx(2.0 * last, rel=1e-6)
    os.truncate(again / "fields" / "000002.h5", 1000)
    with pytest.raises(ValueError, match="000002.h5: "):
        body_functions(again, 10)


def test_indices_and_lines_are_of_the_states_that_are_kept_so_far():
    """Of a run in its third load step that keeps the first, the fourth and the last: of the first alone."""
    written = []
    writer = SimpleNamespace(_kept={0: "normal", 3: "B", 5: "A"}, times=np.arange(6.0))
    writer._index = SimpleNamespace(write=lambda numbers, times: written.append((numbers, times)))
    writer._lines = SimpleNamespace(write=written.append)
    FieldWriter.write_series(writer, 3)
    assert written == [([0], [0.0]), [0]]


def test_a_folder_without_a_run_has_no_functions(tmp_path):
    with pytest.raises(SceneError, match="holds no results of a run"):
        body_functions(tmp_path)
