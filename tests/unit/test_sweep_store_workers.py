"""Stores of members written by workers: each reads its members from the folder and writes pieces of its own."""

import gc
import json
import shutil
import weakref
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import viscorod as vr
from helpers.strip import content
from viscorod.analyses.sweeps.executors import engine
from viscorod.casefile.case import case_from_dict
from viscorod.results.files import store_regions, sweep_store
from viscorod.results.files.packed_results import PackedResult
from viscorod.results.files.store_regions import quiet
from viscorod.results.stacked_members import difference, layout_of
from viscorod.results.sweep_members import READ
from viscorod.results.sweep_result import Sweep

SHEAR = "materials.rubber.damping.shear_time"
COUNT = 7
VALUES = {
    SHEAR: [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07],
    "rods.beam.elements": [1, 1, 1, 2, 1, 1, 2],  # two whose stations differ are files of their own
}


@pytest.fixture(autouse=True)
def packages(monkeypatch):
    pytest.importorskip("pyarrow")
    pytest.importorskip("zarr")
    monkeypatch.setattr(sweep_store, "MEMBERS", 2)
    monkeypatch.setattr(sweep_store, "FILES", 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    case = case_from_dict(content("simulate", duration=0.1, output_interval=0.02))
    place = tmp_path_factory.mktemp("sweep")
    vr.sweep(case, VALUES, fields=True, workers=1, folder=place)
    return place


def arrays_of(path):
    import zarr

    with quiet():  # of the table beside the arrays
        return {name: array[...] for name, array in zarr.open_group(path, mode="r").arrays()}


class Recording(Executor):
    """Computes at once, in this process, and knows who read what; loses the worker of some regions."""

    def __init__(self, lost=()):
        self.regions, self.lost, self.inside = [], lost, False

    def submit(self, work, region):
        future = Future()
        self.regions.append([number for number, _ in region.members])
        if len(self.regions) in self.lost:
            future.set_exception(OSError("no heartbeat"))
            return future
        self.inside = True
        future.set_result(work(region))
        self.inside = False
        return future


def test_workers_write_what_one_process_does(folder, tmp_path):
    """Array by array and member by member; each of two threads and processes has pieces of its own."""
    alone = vr.load(vr.load(folder, Sweep).save(tmp_path / "alone.zarr"), Sweep)
    expected = arrays_of(tmp_path / "alone.zarr")
    assert expected["position"].shape[0] == COUNT - 2
    for pool in (ThreadPoolExecutor(2), ProcessPoolExecutor(2, mp_context=get_context("spawn"))):
        with pool as workers:
            path = vr.load(folder, Sweep).save(tmp_path / "workers.zarr", executor=workers)
        found = arrays_of(path)
        assert found.keys() == expected.keys()
        for name, values in expected.items():
            np.testing.assert_array_equal(found[name], values)
        again = vr.load(path, Sweep)
        assert again.separate == alone.separate == "their numbers of stations differ (4 and 7)"
        for one, other in zip(vr.load(folder, Sweep).members, again.members, strict=True):
            assert other.result.data.identical(one.result.data)


def test_the_client_reads_the_first_block_and_what_differs(folder, tmp_path, monkeypatch):
    """Everything else of the arrays is read where it is written."""
    executor, own = Recording(), []
    read = PackedResult.data

    def told(self):
        if not executor.inside:
            own.append(self.offset)
        return read(self)

    monkeypatch.setattr(PackedResult, "data", told)
    sweep = vr.load(folder, Sweep)
    sweep.save(tmp_path / "sweep.zarr", executor=executor)
    assert executor.regions == [[2, 4], [5], [3], [6]]
    places = [sweep.members.stored(k).offset for k in range(COUNT)]
    assert set(own) == {places[0], places[1], places[3]}  # 3 tells why it is apart


def test_a_report_reads_one_result_of_each_layout(folder, monkeypatch):
    """Whether members are alike was found by reading all of them, which stayed in memory."""
    read, given = [], PackedResult.data
    monkeypatch.setattr(PackedResult, "data", lambda self: read.append(self.offset) or given(self))
    sweep = vr.load(folder, Sweep)
    assert "The members are kept apart: their numbers of stations differ" in " ".join(sweep.report().split())
    assert len(read) == 2


def test_folders_of_before_know_no_layouts_and_no_checksums(folder, tmp_path):
    """Lines of members without theirs are read by comparing results, to the same end."""
    place = shutil.copytree(folder, tmp_path / "sweep")
    for lines in (place / "members").glob("*.jsonl"):
        records = [json.loads(line) for line in lines.read_text().splitlines() if line]
        for record in records:
            record["result"] = record["result"][:3]
            del record["sum"]
        lines.write_text("".join(f"\n{json.dumps(record)}\n" for record in records))
    sweep = vr.load(place, Sweep)
    assert sweep.members.stored(0).layout == ""
    assert sweep.separate == vr.load(folder, Sweep).separate
    sweep.save(tmp_path / "before.zarr")
    vr.load(folder, Sweep).save(tmp_path / "now.zarr")
    expected = arrays_of(tmp_path / "now.zarr")
    for name, values in arrays_of(tmp_path / "before.zarr").items():
        np.testing.assert_array_equal(values, expected[name])


def test_results_that_were_read_do_not_stay(folder):
    """Of results on disk the last ones are kept, whatever is done with the members."""
    members = vr.load(folder, Sweep).members
    first = weakref.ref(members[0].result)
    assert members[0].result is first()
    for k in range(READ):
        members._read[-1 - k] = members[1]
    _ = members[2].result
    gc.collect()
    assert first() is None


@pytest.mark.parametrize("lost", [(1,), (1, 2, 3, 4)])
def test_a_region_whose_worker_is_lost_is_written_here(folder, tmp_path, lost):
    vr.load(folder, Sweep).save(tmp_path / "alone.zarr")
    path = vr.load(folder, Sweep).save(tmp_path / "sweep.zarr", executor=Recording(lost))
    expected = arrays_of(tmp_path / "alone.zarr")
    for name, values in arrays_of(path).items():
        np.testing.assert_array_equal(values, expected[name])
    assert all(member.result is not None for member in vr.load(path, Sweep).members)


def test_a_pool_that_breaks_costs_nothing(folder, tmp_path):
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    path = vr.load(folder, Sweep).save(tmp_path / "sweep.zarr", executor=pool)
    assert (
        vr.load(path, Sweep).members[5].result.data.identical(vr.load(folder, Sweep).members[5].result.data)
    )


def test_a_full_disk_is_one_message_and_leaves_nothing(folder, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(store_regions.RegionWork, "_write", full)
    with (
        ThreadPoolExecutor(2) as pool,
        pytest.raises(vr.InputError, match=r"sweep.zarr cannot be written .No space"),
    ):
        vr.load(folder, Sweep).save(tmp_path / "sweep.zarr", executor=pool)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "executor"), [("sweep.nc", ThreadPoolExecutor(1)), ("sweep.zarr", "dask")])
def test_an_executor_is_for_stores(folder, tmp_path, name, executor):
    with pytest.raises(vr.InputError, match="executor"):
        vr.load(folder, Sweep).save(tmp_path / name, executor=executor)


def test_layouts_are_equal_where_nothing_keeps_results_apart(folder):
    """The digest against the comparison that it stands for, of results changed in one thing each."""
    data = vr.load(folder, Sweep).members[0].result.data
    changed = [
        data,
        data.assign(position=2.0 * data["position"]),
        data.assign_attrs(steps=7),
        data.assign_coords(time=data["time"] + 1e-12),
        data.isel(time=slice(0, 3)),
        data.drop_vars("position"),
        data.assign_attrs(kind="equilibrium"),
        data.assign_coords(time=-0.0 * data["time"] + data["time"]),
        data.assign(extra=data["time"]),
    ]
    words = [name for name in data.variables if data[name].dtype.kind not in "fi"]
    changed += [data.assign_coords({name: data[name].copy(data=np.roll(data[name], 1))}) for name in words]
    alike = [difference(data, one) == "" for one in changed]
    assert alike[:3] == [True] * 3
    assert not any(alike[3:7])
    assert [layout_of(one) == layout_of(data) for one in changed] == alike


@pytest.mark.parametrize(
    ("executor", "workers", "kind"),
    [(None, 1, type(None)), ("threads:2", None, ThreadPoolExecutor), (None, 2, ProcessPoolExecutor)],
)
def test_what_computes_members_writes_their_store(executor, workers, kind):
    with engine(executor, workers) as found:
        assert isinstance(found, kind)
