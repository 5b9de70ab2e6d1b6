"""Files from elsewhere: nothing in them is executed, and what asks for too much is refused before it is allocated."""

import copy
import io
import json
import pickle
import tracemalloc

import h5py
import numpy as np
import pytest

from helpers.damaged_cases import CASES
from helpers.effort import counted_calls
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import case_from_dict, load_case
from viscorod.errors import InputError, SolveError
from viscorod.limits import DEEPEST_NESTING
from viscorod.model.materials.dma_table import read_dma_table
from viscorod.results.files.sealed_file import IDENTITY, write_sealed
from viscorod.results.files.storage import load
from viscorod.results.files.stored_journal import checkpoint, contents


@pytest.fixture
def case():
    content = copy.deepcopy(CASES["cantilever_swing"])
    for key in ("output_interval", "time_step"):
        content["simulate"].pop(key, None)
    return content


def rod_of(case):
    return next(iter(case["rods"].values()))


class Bomb:
    def __reduce__(self):
        return (exec, ("raise SystemExit('executed')",))


def refused_at_once(content, where, *words):
    tracemalloc.start()
    with pytest.raises(InputError) as caught, counted_calls() as effort:
        case_from_dict(content)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert effort.calls < 500_000  # less than a second
    assert peak < 50e6
    (problem,) = caught.value.problems
    assert problem.where == where
    assert problem.instead
    for word in words:
        assert word in str(problem)


def test_too_many_nodes_of_a_rod(case):
    rod_of(case).update(elements=100_000, order=10)
    name = next(iter(case["rods"]))
    # 10^6 nodes of 75 kB
    refused_at_once(case, f"rods.{name}.elements", "100000", "1000001 nodes", "75 GB", "10 s for every step")


def test_too_many_rods(case):
    rod = rod_of(case) | {"elements": 1000, "order": 10}
    case["rods"] |= {f"rod_{k}": rod for k in range(60)}
    refused_at_once(case, "rods", "61 rods", "nodes")


def test_a_coil_of_a_million_turns(case):
    name = next(iter(case["rods"]))
    rod = {
        key: value for key, value in rod_of(case).items() if key not in ("start", "end", "elements", "shape")
    }
    case["rods"][name] = rod | {"shape": "helix", "radius": 1.0, "pitch": 0.1, "turns": 1e6}
    refused_at_once(case, f"rods.{name}", "turns so often", "3e+06 elements")


def test_a_ribbon_of_a_million_turns(case):
    name = next(iter(case["rods"]))
    rod_of(case).pop("elements", None)
    rod_of(case)["twist"] = 2e6 * np.pi
    refused_at_once(case, f"rods.{name}", "turns so often", "3e+06 elements")


def test_too_many_states_and_steps(case):
    rod_of(case).update(elements=100, order=5)
    case["simulate"] |= {"duration": 1.0, "output_interval": 1e-7}
    # 10^7 states of 501 nodes at 210 bytes
    refused_at_once(case, "simulate.output_interval", "1e-07", "1.05e+03 GB")
    del case["simulate"]["output_interval"]
    case["simulate"] |= {"duration": 1e6, "time_step": 1e-6}
    refused_at_once(case, "simulate.time_step", "1e+12 steps", "days")


def test_a_long_path_of_many_nodes():
    content = copy.deepcopy(CASES["cantilever_swing"])
    del content["simulate"]
    rod_of(content).update(elements=10_000, order=10)
    content["path"] = {"points": 100_000}
    with pytest.raises(InputError, match=r"path\.points: 100000: .*GB"):
        case_from_dict(content)


def test_a_case_of_a_usual_size_passes(case):
    rod_of(case).update(elements=1000, order=5)
    case["simulate"] |= {"duration": 10.0, "output_interval": 1e-2, "time_step": 1e-3}
    assert case_from_dict(case)


def test_deep_nesting_and_large_files(case, tmp_path, monkeypatch):
    nested: object = 1.0
    for _ in range(DEEPEST_NESTING + 1):
        nested = [nested]
    case["loads"][0]["value"] = nested
    with pytest.raises(InputError, match=r"loads\[0\]\.value.*nested"):
        case_from_dict(case)
    path = tmp_path / "large.toml"
    path.write_text("a = 1\n" * 20, encoding="utf-8")
    monkeypatch.setattr("viscorod.casefile.case.LARGEST_CASE", 100)
    with pytest.raises(InputError, match="larger than any case file"):
        load_case(path)


@pytest.mark.parametrize("read", [load_case, load, read_dma_table])
def test_pickles_are_not_read(read, tmp_path):
    path = tmp_path / "file.bin"
    path.write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(InputError):
        read(path)


def test_checkpoints_hold_no_objects(tmp_path):
    file = io.BytesIO()
    np.savez(file, text=np.array([Bomb()], dtype=object))
    write_sealed(tmp_path / "checkpoint.npz", file.getvalue(), bytes(IDENTITY))
    with pytest.raises(InputError):
        checkpoint(tmp_path)


@pytest.mark.parametrize("fields", [[["a", "O", []]], [], [["a", "not a type", []]], 3])
def test_journals_hold_no_objects(fields, tmp_path):
    told = {"fields": fields, "variables": {"a": {}} if fields else {}}
    write_sealed(tmp_path / "states.json", json.dumps(told).encode(), bytes(IDENTITY))
    with pytest.raises(InputError, match="plain numbers"):
        contents(tmp_path)


def test_absurd_dimensions_are_refused_before_they_are_allocated(tmp_path):
    path = tmp_path / "run.nc"
    with h5py.File(path, "w") as file:
        file.create_dataset("position", shape=(10**9, 10**3, 3), dtype="f8", chunks=(1000, 10, 3))
    assert path.stat().st_size < 1e5
    tracemalloc.start()
    with pytest.raises(InputError, match="position claims"):
        load(path)
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()


def test_results_with_objects_or_of_nothing_are_refused(tmp_path):
    path = tmp_path / "run.nc"
    with h5py.File(path, "w") as file:
        file.attrs["kind"] = "unknown"
        file.create_dataset("x", data=np.void(pickle.dumps(Bomb())))
    with pytest.raises(InputError):
        load(path)


@pytest.mark.parametrize("length", [3e7, 1e50])
def test_vibrations_beyond_double_precision_are_one_message(length):
    """Damaged cases that ended in errors of the linear algebra: rods of absurd length next to usual ones."""
    name = "prestressed_bridge" if length < 1e10 else "four_bar"
    content = copy.deepcopy(CASES[name])
    rod = content["rods"]["beam" if length < 1e10 else "crank"]
    rod["end"][0 if length < 1e10 else 2] = length
    case = case_from_dict(content)
    try:
        report = check(DiscreteModel.of(case.description), case.settings)
    except (InputError, SolveError) as error:
        told = str(error)
    else:
        told = "finite" if np.isfinite(report.frequencies).all() else ""
    assert told
