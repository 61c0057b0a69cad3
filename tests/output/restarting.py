"""A short run, what is refused, and whether a run that was interrupted ended as if nothing had happened."""

import json

import meshio
import numpy as np
import pandas
import pytest
from running import csv_rows, surface

from simulations import fretting
from simulations.scene import SceneError

RUN = {"solid__nu": 0.3, "reference__kind": '"none"'}  # changes of the coarse scene
SAME = 1e-10  # relative to the largest value: what an interruption may change
QUANTITIES = ("pressure", "gap", "traction", "slip", "frictional_work", "frictional_work_of_cycle")
QUANTITIES += ("load_parameter", "P_prescribed", "P_carried", "Q_prescribed", "Q_carried")
COLUMNS = ("load_parameter", "P_prescribed[N/m]", "P_carried[N/m]", "delta_y[m]", "a[m]", "contact_left[m]")
COLUMNS += ("peak_pressure[Pa]", "Q_prescribed[N/m]", "delta_x[m]", "c[m]", "stick_left[m]", "dissipated_energy[J/m]")


def refusal(*arguments) -> str:
    """The line about a command that is refused."""
    with pytest.raises(SceneError) as error:
        fretting.main([str(word) for word in arguments])
    assert "\n" not in str(error.value)
    return str(error.value)


def assert_same(folder, expected):
    """Every number of every load step, and every file, as in the run that was not stopped."""
    mine, theirs = surface(folder), surface(expected)
    for name in QUANTITIES:
        if name in theirs:
            scale = np.abs(theirs[name]).max()
            assert mine[name].shape == theirs[name].shape
            assert np.abs(mine[name] - theirs[name]).max() <= SAME * scale, name
    histories = [csv_rows(place / "history.csv") for place in (folder, expected)]
    for one, other in zip(*histories, strict=True):
        for name in ("increment", "branch", "cycle", "state"):
            assert one[name] == other[name]
    for name in COLUMNS:
        if name in other:
            values = np.array([[float(row[name]) for row in rows] for rows in histories])
            assert values[0] == pytest.approx(values[1], rel=1e-9, abs=1e-9 * np.abs(values[1]).max()), name
    assert_same_fields(folder, expected)
    assert json.loads((folder / "summary.json").read_text())["converged"] is True
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in expected.iterdir())


def assert_same_fields(folder, expected):
    lines = [place / "lines.csv" for place in (folder, expected)]
    if lines[1].exists():
        one, other = (pandas.read_csv(path).replace(np.inf, 0.0) for path in lines)
        assert one.select_dtypes(object).equals(other.select_dtypes(object))
        mine, theirs = (table.select_dtypes(float).to_numpy() for table in (one, other))
        assert np.all(np.abs(mine - theirs) <= 1e-8 * np.abs(theirs).max(axis=0))
    with (
        meshio.xdmf.TimeSeriesReader(folder / "fields.xdmf") as one,
        meshio.xdmf.TimeSeriesReader(expected / "fields.xdmf") as other,
    ):
        points = [reader.read_points_cells()[0] for reader in (one, other)]
        assert np.array_equal(*points)
        assert one.num_steps == other.num_steps
        for i in range(one.num_steps):
            (time_1, u_1, stress_1), (time_2, u_2, stress_2) = one.read_data(i), other.read_data(i)
            assert time_1 == time_2
            for mine, theirs in ((u_1, u_2), (stress_1, stress_2)):
                for name in theirs:
                    a, b = np.asarray(mine[name]), np.asarray(theirs[name])
                    assert np.abs(a - b).max() <= 1e-9 * np.abs(b).max(), name
