"""Arrays that no data set was made of are written as xarray writes the data set; a run of a case file needs none.

Both files are compared as h5py reads them; what is right is xarray's.
"""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.casefile.set_values import with_values
from viscorod.results.files.storage import read, write
from viscorod.results.state_arrays import StateArrays

EXAMPLES = Path(__file__).parents[2] / "examples"
SHORT = {
    "cantilever_swing": {"simulate.duration": 0.02},
    "four_bar": {"simulate.duration": 0.08},
    "soft_arm": {"simulate.duration": 0.01},
    "comb_resonator": {"simulate.duration": 1e-6},
    "rubber_strip": {"simulate.duration": 0.01},
    "bend_45": {},
    "swept_blade": {},
}


def attributes(item):
    """Of a file or an array, in the order in which they were written, with their types; addresses left out."""
    return [
        (
            name,
            item.attrs.get_id(name).dtype,
            item.attrs.get_id(name).shape,
            np.asarray(item.attrs[name]).tolist(),
        )
        for name in item.attrs
        if name not in ("DIMENSION_LIST", "REFERENCE_LIST")
    ]


def dimensions(item):
    return [[scale.name for scale in side.values()] for side in item.dims]


def layout(item):
    return (item.dtype, item.shape, item.chunks, item.compression, item.compression_opts, item.shuffle,
            item.fletcher32, item.fillvalue, h5py.check_string_dtype(item.dtype))  # fmt: skip


@pytest.mark.parametrize("name", SHORT)
def test_the_file_is_that_of_xarray(name, tmp_path):
    case = with_values(vr.load_case(EXAMPLES / f"{name}.toml"), SHORT[name])
    result = run_case(case, errors=False)
    assert isinstance(result.stored, StateArrays)
    mine = write(result.stored, tmp_path / "arrays.nc")
    theirs = write(result.data, tmp_path / "data_set.nc")
    with h5py.File(mine) as one, h5py.File(theirs) as other:
        assert list(one) == list(other)
        assert attributes(one) == attributes(other)
        for key in one:
            assert layout(one[key]) == layout(other[key]), key
            assert attributes(one[key]) == attributes(other[key]), key
            assert dimensions(one[key]) == dimensions(other[key]), key
            np.testing.assert_array_equal(one[key][()], other[key][()])
    left, right = read(mine), read(theirs)
    assert left.identical(right)
    assert left.identical(result.data)
    assert {k: v.encoding for k, v in left.variables.items()} == {
        k: v.encoding for k, v in right.variables.items()
    }


def test_a_run_imports_neither_xarray_nor_pandas(tmp_path):
    """The two, and Dask where it is there, took a fifth of a warm run."""
    lines = f"""
import os, sys
from viscorod.cli.app import main
os._exit = lambda code: (_ for _ in ()).throw(SystemExit(code))
sys.argv = ["viscorod", "run", {str(EXAMPLES / "cantilever_swing.toml")!r}, "-o", {str(tmp_path)!r},
            "--set", "simulate.duration=0.1"]
try:
    main()
except SystemExit as end:
    assert not end.code
print(*sorted({{"xarray", "pandas", "dask"}} & sys.modules.keys()), "imported", file=sys.stderr)
"""
    told = subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True, check=True)
    assert told.stderr.splitlines()[-1].split() == ["imported"]
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", "motion.png", "energy.png"}
    assert isinstance(vr.load(tmp_path / "run.nc"), vr.Run)
