"""What a result file promises: what was written is what is read, and nothing else of the machine is."""

import copy
import json
import pickle
import shutil
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from helpers.damaged_cases import CASES
from helpers.synthetic_results import rolled_up, swing
from viscorod.analyses.case_run import as_model
from viscorod.casefile.case import case_from_dict
from viscorod.results.files import storage
from viscorod.results.files.checked_array import CheckedArray, OpenFile
from viscorod.results.files.checksums import NAME
from viscorod.results.files.known_items import FileOfKnownItems
from viscorod.results.files.pieces_of_arrays import cuts, piece_shape


@pytest.fixture(scope="module")
def run():
    return vr.Run(swing(duration=4.0))


@pytest.fixture(scope="module")
def saved(run, tmp_path_factory):
    return run.save(tmp_path_factory.mktemp("saved") / "run.nc")


@pytest.fixture
def path(saved, tmp_path):
    """A file of one's own, to be damaged."""
    return Path(shutil.copy(saved, tmp_path))


def without_checksums(path, change=None):
    """The file as version 0.1.0 wrote it, after a change."""
    with h5py.File(path, "r+") as file:
        file.attrs.pop(NAME, None)
        if change is not None:
            change(file)
    return path


@pytest.mark.parametrize(
    ("name", "words"),
    [("run.csv", "to_csv"), ("RUN.CSV", "to_csv"), ("run.png", "plot"), ("run.vtkhdf", "save_paraview")],
)
def test_a_name_of_another_format_is_refused(name, words, run, tmp_path):
    """It would hold netCDF4 under that name."""
    with pytest.raises(vr.InputError, match=rf"end the name in \.nc\. .*{words}"):
        run.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_any_program_reads_the_file(run, path):
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert data.drop_attrs().equals(run.data.drop_attrs())


def test_all_numbers_have_checksums_of_hdf5(path):
    with h5py.File(path) as file:
        for name in ("position", "rotation", "time", "station_s", "kinetic", "iterations"):
            assert file[name].fletcher32
        sums = json.loads(file.attrs[NAME])
        position = file["position"]
        pieces = [position[cut] for cut in cuts(position.shape, position.chunks)]
        assert sums["values"]["/position"] == [zlib.crc32(piece.tobytes()) for piece in pieces]


def test_what_compresses_is_compressed(run, tmp_path):
    """Zeros and what repeats, not the noise of last digits; every number is read back as it was."""
    data = run.data.isel(time=np.zeros(300, dtype=int))
    data = data.assign_coords(time=np.arange(300.0))
    noise = np.random.default_rng(1).normal(size=data["position"].shape)
    data = data.assign(velocity=data["velocity"] * 0.0, position=data["position"] + noise)
    path = storage.write(data, tmp_path / "run.nc")
    with h5py.File(path) as file:
        assert file["velocity"].compression == "gzip"
        assert file["velocity"].id.get_storage_size() < 0.1 * data["velocity"].nbytes
        assert file["position"].compression is None
    found = storage.read(path)
    for name in ("velocity", "position", "strain"):
        np.testing.assert_array_equal(found[name].values, data[name].values)


def test_files_without_checksums_are_read(run, path):
    assert vr.load(without_checksums(path)).data.identical(run.data)


NUMBERS = ["position", "rotation", "time", "station_s", "kinetic", "iterations", "reference_rotation"]


@pytest.mark.parametrize("lazy", [False, True])
@pytest.mark.parametrize("name", NUMBERS)
def test_a_flipped_bit_in_numbers_is_refused(name, lazy, path, monkeypatch):
    with h5py.File(path) as file:
        place = file[name].id.get_chunk_info(0).byte_offset
    content = bytearray(path.read_bytes())
    content[place + 16] ^= 1
    path.write_bytes(content)
    if lazy:
        monkeypatch.setattr(storage, "LARGE", 0)
    with pytest.raises(vr.InputError, match=f"run.nc.*{name}"):
        vr.load(path).data[name].load()


def test_a_gap_is_refused_with_its_checksum(path):
    """A piece whose bytes are all zero, as a copy of a file with holes leaves it, has the right Fletcher-32."""
    with h5py.File(path) as file:
        piece = file["kinetic"].id.get_chunk_info(0)  # of those that are not compressed
    content = bytearray(path.read_bytes())
    content[piece.byte_offset : piece.byte_offset + piece.size] = bytes(piece.size)
    path.write_bytes(content)
    with h5py.File(path) as file:
        assert not file["kinetic"][:].any()
    with pytest.raises(vr.InputError, match="kinetic are not those that were written"):
        vr.load(path)


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_a_short_file_is_refused(part, path):
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(vr.InputError, match=r"run\.nc"):
        vr.load(path)


def test_a_file_that_another_program_opened_to_write_is_read(run, path):
    """HDF5 cuts off what follows its own end; all else is as it was."""
    size = path.stat().st_size
    with h5py.File(path, "r+") as file:
        file.flush()
    assert path.stat().st_size < size
    assert vr.load(path).data.identical(run.data)


def test_bytes_that_are_no_numbers_are_compared_before_hdf5_reads_them(path, monkeypatch):
    """Damaged tables of texts sent HDF5 into an endless loop."""
    content = bytearray(path.read_bytes())
    heap = content.index(b"GCOL")
    content[heap + 16] ^= 0xFF
    path.write_bytes(content)
    monkeypatch.setattr(h5py, "File", lambda *_, **__: pytest.fail("HDF5 was asked"))
    with pytest.raises(vr.InputError, match="is damaged: bytes"):
        vr.load(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda file: file.attrs.__setitem__("title", "another"), "the attribute title is another one"),
        (lambda file: file.attrs.__delitem__("steps"), "the attribute steps is missing"),
        (lambda file: file["position"].attrs.__setitem__("units", "mm"), "units of position is another one"),
        (lambda file: file.__delitem__("strain"), "strain is missing"),
        (lambda file: file.create_dataset("more", data=1.0), "more was not there"),
        (lambda file: file["station_rod"].__setitem__(0, "other"), "values of station_rod are others"),
        (
            lambda file: file["position"].__setitem__((0, 0, 0), 1.0),
            "position are not those that were written",
        ),
    ],
)
def test_what_another_program_changed_is_named(change, words, path):
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(vr.InputError, match=words):
        vr.load(path)


def secret(tmp_path):
    place = tmp_path / "secret.bin"
    place.write_bytes(np.full(10_000, 31415.9265).tobytes())
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["position"] = np.full((201, 11, 3), 31415.9265)
    return place


def _external_values(file, tmp_path):
    shape = file["position"].shape
    del file["position"]
    where = [(str(tmp_path / "secret.bin"), 0, h5py.h5f.UNLIMITED)]
    file.create_dataset("position", shape, "f8", external=where)


def _external_link(file, tmp_path):
    file["more"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "/position")


def _deep_external_link(file, tmp_path):
    file.create_group("a/b/c")["more"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "/position")


def _virtual(file, tmp_path):
    layout = h5py.VirtualLayout((201, 11, 3), "f8")
    layout[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "position", (201, 11, 3))
    file.create_virtual_dataset("more", layout)


def _soft_link(file, _):
    file["more"] = h5py.SoftLink("/position")


def _second_name(file, _):
    file["more"] = file["position"]


def _circle(file, _):
    file.create_group("a")["back"] = file["/"]


def _objects(file, _):
    file.create_dataset("more", data=np.array([file["position"].ref], dtype=h5py.ref_dtype))


def _compound(file, _):
    file["more"] = np.zeros(3, dtype=[("a", "f8"), ("b", "i4")])


def _named_type(file, _):
    file["more"] = np.dtype("f8")


def _filter(file, _):
    file.create_dataset("more", data=np.arange(100.0), compression="lzf")


def _gap(file, _):
    shape = file["velocity"].shape
    del file["velocity"]
    file.create_dataset("velocity", shape, "f8", chunks=(10, *shape[1:]))[0] = 0.0


def _many_large(file, _):
    for k in range(20):
        file.create_dataset(f"more_{k}", (10**7,), "f8", chunks=(10**6,))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_external_values, "position are in another file"),
        (_external_link, "more is a link to another place"),
        (_deep_external_link, "a/b/c/more is a link to another place"),
        (_virtual, "more is put together from other files"),
        (_soft_link, "more is a link to another place"),
        (_second_name, "second name"),
        (_circle, "second name"),
        (_objects, "neither numbers nor texts"),
        (_compound, "neither numbers nor texts"),
        (_named_type, "neither a group nor an array"),
        (_filter, "needs a filter"),
        (_gap, "velocity is not complete"),
        (_many_large, "all arrays up to more_.* claim"),
    ],
)
def test_nothing_is_read_from_elsewhere(change, words, path, tmp_path):
    secret(tmp_path)
    without_checksums(path, lambda file: change(file, tmp_path))
    with pytest.raises(vr.InputError, match=words) as caught:
        vr.load(path)
    assert str(path) in str(caught.value)
    assert "31415" not in str(caught.value)


def _set(name, index, value):
    return lambda file: file[name].__setitem__(index, value)


def _attribute(name, value):
    return lambda file: file.attrs.__setitem__(name, value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_set("time", 5, 0.0), "time does not increase"),
        (_set("time", 5, np.nan), "time holds nan"),
        (_set("position", (0, 0, 0), np.inf), "position holds inf"),
        (_set("rotation", (3, 0), [2.0, 0.0, 0.0, 0.0]), "rotation holds a quaternion whose length"),
        (_set("station_s", 3, -1.0), "station_s holds -1"),
        (_set("station_s", 3, 0.0), "at the same arc length"),
        (_set("station_order", slice(None), 3), "make no elements of order 3"),
        (_set("station_order", 2, -1), "station_order holds -1"),
        (_set("point_rod", 0, "other"), "Gauss points are on 'other'"),
        (_set("point_s", 0, 0.25), "not within its elements"),
        (_set("quaternion", 0, "v"), "quaternion is not w, x, y, z"),
        (_attribute("kind", "nothing"), "kind = 'nothing'"),
        (_attribute("kind", [1.0, 2.0]), "holds no viscorod result"),
        (_attribute("kind", "steady"), "spin is missing"),
        (_attribute("warnings", "[1"), "the attribute warnings is"),
        (_attribute("warnings", "[1]"), "the attribute warnings.0 is"),
        (_attribute("events", '[{"time": "x", "event": "y"}]'), "the attribute events.0.time"),
        (_attribute("damping_laws", '{"beam": {}}'), "the attribute damping_laws.beam.times"),
        (_attribute("mesh_motion_error", 0.1), "mesh_errors is missing"),
        (_attribute("steps", -3), "the attribute steps is -3"),
        (_attribute("wall_time_s", np.nan), "the attribute wall_time_s is nan"),
        (_attribute("formulation", "other"), "the attribute formulation is 'other'"),
        (lambda file: file.__delitem__("velocity"), "velocity is missing"),
        (lambda file: file.__delitem__("section_force"), "section_force is missing, which belongs to strain"),
        (lambda file: file["position"].attrs.__setitem__("units", "mm"), "position is in 'mm'"),
    ],
)
def test_what_no_result_has_is_named(change, words, path):
    without_checksums(path, change)
    with pytest.raises(vr.InputError, match=words) as caught:
        vr.load(path)
    assert str(path) in str(caught.value)


def test_nothing_in_the_file_scales_its_numbers(run, path):
    def scale(file):
        file["position"].attrs.update({"scale_factor": 2.0, "add_offset": 1.0, "_FillValue": 0.0})
        file["time"].attrs["units"] = "s"

    loaded = vr.load(without_checksums(path, scale))
    assert np.array_equal(loaded.data["position"].values, run.data["position"].values)


def test_points_of_a_path_are_states(tmp_path):
    path = vr.Equilibrium(rolled_up()).save(tmp_path / "path.nc")
    without_checksums(path, _attribute("stage_ends", "[0, 7]"))
    with pytest.raises(vr.InputError, match="stage_ends names state 7 of 4"):
        vr.load(path)


def test_numbers_of_a_large_file_are_judged_when_they_are_read(path, monkeypatch):
    without_checksums(path, _set("strain", (150, 3, 4), np.nan))
    monkeypatch.setattr(storage, "LARGE", 0)
    loaded = vr.load(path)
    assert loaded.history("beam.end").shape == (201, 3)
    with pytest.raises(vr.InputError, match=r"run\.nc.*strain holds nan"):
        loaded.report()


def test_a_large_file_can_go_to_another_process(run, path, monkeypatch):
    monkeypatch.setattr(storage, "LARGE", 0)
    loaded = vr.load(path)
    assert not loaded.data["position"]._in_memory
    again = pickle.loads(pickle.dumps(loaded))
    assert np.array_equal(again.data["position"].values, run.data["position"].values)


@pytest.mark.parametrize("shape", [(7,), (40, 3), (5, 6, 7), (2, 3, 4, 5)])
def test_parts_of_an_array_are_those_of_the_whole(shape, tmp_path, monkeypatch):
    """Whatever is asked for, pieces however small: as NumPy takes it from the whole array."""
    monkeypatch.setattr("viscorod.results.files.pieces_of_arrays.PIECE", 80)
    values = np.random.default_rng(1).normal(size=shape)
    data = xr.Dataset({"user": ([f"d{k}" for k in range(len(shape))], values)})
    path = storage.write(data, tmp_path / "file.nc")
    with h5py.File(path) as file:
        assert file["user"].chunks == piece_shape(shape, 8)
        sums = json.loads(file.attrs[NAME])["values"]["/user"]
    array = CheckedArray(OpenFile(path), "/user", shape, values.dtype, sums)
    lazy = xr.Variable(data["user"].dims, xr.core.indexing.LazilyIndexedArray(array))
    rng = np.random.default_rng(2)
    for _ in range(40):
        key = tuple(
            [
                int(rng.integers(n)),
                slice(int(rng.integers(n)), None),
                rng.integers(n, size=3),
                slice(None, None, 2),
            ][rng.integers(4)]
            for n in shape
        )
        expected = xr.Variable(data["user"].dims, values)[key].values
        assert np.array_equal(lazy[key].values, expected)


def test_a_run_that_went_to_disk_has_checksums_too(tmp_path, monkeypatch):
    """Written in many pieces, which are not those of the arrays."""
    monkeypatch.setattr("viscorod.results.files.stored_journal.CHUNK", 2e4)
    monkeypatch.setattr("viscorod.results.files.pieces_of_arrays.PIECE", 3000)
    case = copy.deepcopy(CASES["cantilever_swing"])
    for rod in case["rods"].values():
        rod |= {"elements": 2, "order": 2}
    model = as_model(case_from_dict(case).description)
    run = model.simulate(0.2, output_interval=0.002, folder=tmp_path)
    with h5py.File(tmp_path / "run.nc") as file:
        assert file["position"].id.get_num_chunks() > 3
        assert NAME in file.attrs
    loaded = vr.load(tmp_path / "run.nc")
    assert loaded.data.identical(run.data)
    assert NAME not in loaded.data.attrs
    assert np.array_equal(loaded.time, 0.002 * np.arange(101))


def test_a_file_that_knows_its_arrays_forgets_what_is_deleted(tmp_path):
    """Identity: an array that takes the name of a deleted one is found, at the top and in a group."""
    with FileOfKnownItems(tmp_path / "arrays.h5", "w") as file:
        file["x"] = [1.0]
        assert file["x"] is file["/x"]
        assert file["/"]["x"] == file["x"]
        del file["/"]["x"]
        file["x"] = [2.0]
        assert file["x"][0] == 2.0
        del file["x"]
        assert "x" not in file
        group = file.create_group("part")
        for value in (1.0, 2.0):
            group["y"] = [value]
            assert file["part/y"][0] == file["/part/y"][0] == value
            del group["y"]
