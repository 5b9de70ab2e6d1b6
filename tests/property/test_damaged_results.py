"""Damaged result files: one message that names the file, or the data that were written; never a traceback or others.

Files of every kind are damaged byte by byte, and through h5py, where the file stays a valid one. ``make fuzz`` does it
a thousand times for each; here a few times, the same ones each time.
"""

import faulthandler
from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import viscorod as vr
from helpers.damaged_files import damage_bytes, damage_contents, unsealed
from helpers.small_results import KINDS, identical, small_results, use

LONG = settings.default.max_examples > 1000
EXAMPLES = settings(
    max_examples=1000 if LONG else 4,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
LIMIT = 120
"""Seconds after which an example that hangs within HDF5 ends everything, with a traceback."""
SEEDS = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    return {kind: (result.save(folder / f"{kind}.nc"), result) for kind, result in small_results().items()}


@pytest.fixture(autouse=True)
def _end_what_hangs():
    faulthandler.dump_traceback_later(LIMIT * (50 if LONG else 1), exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


def refused_or(path, judge):
    try:
        result = vr.load(path)
        judge(result)
    except vr.InputError as error:
        message = str(error)
    else:
        return
    assert str(path) in message, message
    assert len(message) < 3000


def require_identical(result, found):
    assert identical(found, result)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=SEEDS)
@EXAMPLES
def test_damaged_bytes(kind, files, tmp_path, seed):
    source, result = files[kind]
    path = tmp_path / "damaged.nc"
    path.write_bytes(damage_bytes(source.read_bytes(), np.random.default_rng(seed)))
    refused_or(path, partial(require_identical, result))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=SEEDS)
@EXAMPLES
def test_changed_contents(kind, files, tmp_path, seed):
    """Through h5py: variables and attributes that are gone, renamed, of other types, shapes or values."""
    source, result = files[kind]
    path = tmp_path / "changed.nc"
    path.write_bytes(source.read_bytes())
    damage_contents(path, np.random.default_rng(seed))
    refused_or(path, partial(require_identical, result))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=SEEDS)
@EXAMPLES
def test_changed_contents_without_checksums(kind, files, tmp_path, seed):
    """As of version 0.1.0: what is no result is refused, and what could be one is reported, asked and drawn."""
    source, _ = files[kind]
    path = tmp_path / "changed.nc"
    path.write_bytes(source.read_bytes())
    rng = np.random.default_rng(seed)
    damage_contents(path, rng)
    unsealed(path)
    refused_or(path, lambda found: use(found, tmp_path, pictures=rng.random() < 0.2))
