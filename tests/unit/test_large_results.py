"""Results larger than memory should be: the same answers as from memory, and never a whole field at once."""

import json
import tracemalloc

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from helpers import viewer_pages
from viscorod.pictures.viewer import view
from viscorod.results import array_pieces as pieces
from viscorod.results.array_pieces import blocks, in_states
from viscorod.results.files import storage
from viscorod.results.run import Run

FRAMES, STATIONS = 2000, 201
FIELD = FRAMES * STATIONS * 3 * 8
"""Bytes of the positions; the file holds seven such fields and larger ones."""


def beating(frames=FRAMES):
    """A run with Kelvin-Voigt damping, some 84 MB."""
    data = viewer_pages.beating(frames=frames)
    law = {"times": [1e-3] * 6, "maxwell": False}
    points = data.sizes["point"]
    return Run(
        data.assign(
            angular_velocity=0.1 * data["velocity"], point_weight=("point", np.full(points, 1.0 / points))
        ).assign_attrs(damping_laws=json.dumps({"beam": law}))
    )


@pytest.fixture(scope="module")
def fresh():
    return beating()


@pytest.fixture(scope="module")
def path(fresh, tmp_path_factory):
    return fresh.save(tmp_path_factory.mktemp("large") / "run.nc")


@pytest.fixture(scope="module")
def shorter(tmp_path_factory):
    """A run of the same kind, for what is loaded or cached once."""
    return beating(frames=100).save(tmp_path_factory.mktemp("shorter") / "run.nc")


@pytest.fixture
def lazy(path, monkeypatch):
    """The same run, left on disk; pieces are smaller as the file is."""
    monkeypatch.setattr(storage, "LARGE", 1e6)
    monkeypatch.setattr(pieces, "_BLOCK", 100_000)
    return vr.load(path)


def peak(call):
    """Largest memory while something is done [bytes]; what is loaded or cached once is there before."""
    tracemalloc.start()
    try:
        call()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


READINGS = {
    "report": lambda run, _: run.report(),
    "main motion": lambda run, _: (run.main_motion, run.displacement_range),
    "decay": lambda run, _: run.free_decay("beam.end", "y"),
    "history": lambda run, _: run.history("beam@0.333", "velocity").values,
    "validity": lambda run, _: str(run.damping_validity()),
    "snapshot": lambda run, _: run.snapshot(3.3),
    "times far apart": lambda run, _: run.probe("beam", [0.1, 10.0, 19.9], s=[0.2, 0.7]),
    "picture": lambda run, folder: run.plot(folder / "motion.png"),
    "page": lambda run, folder: view(run, folder / "page.html", frames=20).read_text(),
}


@pytest.mark.parametrize("what", READINGS)
def test_no_field_is_read_whole(what, shorter, lazy, tmp_path):
    READINGS[what](vr.load(shorter), tmp_path)  # imports and caches
    assert peak(lambda: READINGS[what](lazy, tmp_path)) < FIELD


def test_reading_a_field_whole_would_be_seen(lazy):
    assert peak(lambda: lazy.field("position")) > FIELD


@pytest.mark.parametrize("what", ["report", "history", "validity", "snapshot", "page"])
def test_answers_are_those_from_memory(what, fresh, lazy, tmp_path):
    found, expected = READINGS[what](lazy, tmp_path), READINGS[what](fresh, tmp_path)
    if what in ("report", "validity", "page"):
        assert found == expected
    elif what == "snapshot":
        assert found["beam"] == pytest.approx(expected["beam"], abs=1e-15)
    else:
        assert np.array_equal(found, expected)


def test_range_of_displacements_is_that_of_the_field(fresh, lazy):
    moved = fresh.field("displacement")
    for run in (fresh, lazy):
        low, high = run.displacement_range
        assert low == pytest.approx(moved.min(axis=0), abs=1e-15)
        assert high == pytest.approx(moved.max(axis=0), abs=1e-15)


@pytest.mark.parametrize("block", [1, 60, 1000, 10**6])
def test_pieces_make_the_whole(block, monkeypatch):
    """Any choice of states, near and far apart, however small the pieces are."""
    monkeypatch.setattr(pieces, "_BLOCK", block)
    rng = np.random.default_rng(3)
    values = rng.normal(size=(300, 7, 3))
    variable = xr.DataArray(values, dims=("time", "station", "axis"))
    for chosen in ([0], [299], [5, 6, 7, 80, 81, 299], range(300), np.flatnonzero(rng.random(300) < 0.2)):
        states = np.array(chosen)
        assert np.array_equal(in_states(variable, "time", states), values[states])
    run = Run(viewer_pages.beating(frames=50, elements=2))
    assert np.array_equal(np.concatenate(list(blocks(run, "strain"))), run.data["strain"].values)
