"""A short run, what is refused, and whether a run that was interrupted ended as if nothing had happened."""

import json

import meshio
import numpy as np
import pandas
import pytest
from running import surface

from simulations import fretting
from simulations.scene import SceneError

RUN = {"solid__nu": 0.3, "reference__kind": '"none"'}  # changes of the coarse scene
TOOK = ("iterations", "cuts", "unsettled", "states_changed", "residual", "seconds")  # of history.csv
SAME = 1e-10  # relative to the largest value: what an interruption may change


def refusal(*arguments) -> str:
    """The line about a command that is refused."""
    with pytest.raises(SceneError) as error:
        fretting.main([str(word) for word in arguments])
    assert "\n" not in str(error.value)
    return str(error.value)


def assert_same(folder, expected):
    """Every number of every load step, and every file, as in the run that was not stopped."""
    mine, theirs = surface(folder), surface(expected)
    for name in (name for name, values in theirs.items() if values.dtype.kind == "f"):
        scale = np.abs(theirs[name]).max()
        assert mine[name].shape == theirs[name].shape
        assert np.abs(mine[name] - theirs[name]).max() <= SAME * scale, name
    assert_same_table("history.csv", folder, expected, 1e-9, without=TOOK)
    if (expected / "lines.csv").exists():
        assert_same_table("lines.csv", folder, expected, 1e-8)
    assert_same_fields(folder, expected)
    assert json.loads((folder / "summary.json").read_text())["converged"] is True
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in expected.iterdir())


def assert_same_table(name, folder, expected, share, without=()):
    """Words are the same, and numbers to this share of the largest of their column."""
    tables = [pandas.read_csv(place / name, keep_default_na=False) for place in (folder, expected)]
    tables = [table.drop(columns=[*without]).replace(np.inf, 0.0) for table in tables]
    mine, theirs = (table.select_dtypes("number") for table in tables)
    assert mine.columns.equals(theirs.columns) and len(mine) == len(theirs)
    assert np.all(np.abs(mine - theirs) <= share * np.abs(theirs).max()), name
    words, others = (table.select_dtypes(exclude="number") for table in tables)
    assert words.equals(others)


def assert_same_fields(folder, expected):
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
