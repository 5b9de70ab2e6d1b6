"""Arrays that are computed when they are read have the numbers of NumPy's indexing, once, and survive pickling."""

import pickle

import numpy as np
import xarray as xr

from viscorod.results.deferred_array import defer


def _deferred(values: np.ndarray) -> tuple[xr.Dataset, list[int]]:
    made: list[int] = []

    def make() -> np.ndarray:
        made.append(1)
        return values

    data = xr.Dataset({"load": (("time", "axis"), np.zeros(values.shape), {"units": "N"})})
    defer(data.variables["load"], make)
    return data, made


def test_numbers_are_made_once_when_they_are_read() -> None:
    values = np.arange(12.0).reshape(4, 3)
    data, made = _deferred(values)
    assert data["load"].shape == (4, 3)
    assert data["load"].attrs["units"] == "N"
    assert not made
    np.testing.assert_array_equal(data["load"].values, values)
    np.testing.assert_array_equal(data["load"].isel(time=-1, axis=[2, 0]).values, values[-1, [2, 0]])
    np.testing.assert_array_equal(data["load"][1:3, 0].values, values[1:3, 0])
    assert float((2.0 * data["load"]).sum()) == 2.0 * values.sum()
    assert len(made) == 1


def test_copies_in_files_and_processes_hold_the_numbers() -> None:
    values = np.arange(6.0).reshape(2, 3)
    data, _ = _deferred(values)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(data))["load"].values, values)
    np.testing.assert_array_equal(data.copy(deep=True)["load"].values, values)
