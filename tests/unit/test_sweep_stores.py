"""Sweeps as Parquet tables and zarr stores: what comes back is what went in, whatever the members are."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.strip import content
from viscorod.casefile.case import case_from_dict
from viscorod.cli import sweep_command
from viscorod.cli.app import app
from viscorod.results.files import parquet, store_regions, sweep_store
from viscorod.results.sweep_result import Sweep

SHEAR = "materials.rubber.damping.shear_time"
VALUES = {
    SHEAR: [0.01, 0.02, 0.03, "40 ms", 0.05, 0.06, 0.07],
    "loads[0].value": [[0.0, 0.001 * k, 0.0] for k in range(7)],
    "simulate.time_step": [0.02, 0.02, 0.02, 0.02, 0.025, 0.02, 0.02],
}
QUANTITIES = {
    "tip": ("displacement", "beam.end", "y", "last"),
    "path": ("displacement", "beam.end", "y", "history"),
    "decay": ("decrement", "beam.end", "y"),  # too short a motion for one
}


def computed(**constants):
    case = case_from_dict(content("simulate", duration=0.1, output_interval=0.02))
    given = {"quantities": QUANTITIES, "fields": True, "workers": 1, "constants": constants}
    return vr.sweep(case, VALUES, **given)


@pytest.fixture(scope="module")
def sweep():
    """Seven members, of which the sixth is made one that failed on its way."""
    members = list(computed().members)
    result = members[5].result
    run = type(result)(result.data.isel(time=slice(0, 3)).assign_attrs(outcome="slow"))
    members[5] = replace(members[5], stored=run, outcome="slow", message="it broke", quantities={})
    return Sweep(members, "Strip", ["a note"])


@pytest.fixture(autouse=True)
def packages():
    pytest.importorskip("pyarrow")
    pytest.importorskip("zarr")


def test_a_table_gives_back_all_but_whole_results(sweep, tmp_path):
    again = vr.load(sweep.save(tmp_path / "sweep.parquet"), Sweep)
    assert again.table().equals(sweep.table())
    assert dict(again.members.rows.columns) == VALUES  # "40 ms" and vectors are what was given
    assert again.notes == sweep.notes
    assert again.members[2].quantities == sweep.members[2].quantities
    assert len(again.members[2].quantities["path"]) == 201
    assert again.members[5].quantities == {}
    assert again.members[5].message == "it broke"
    assert again.members[2].result is None
    assert again.report() == sweep.report()


def test_pandas_reads_the_table(sweep, tmp_path):
    pandas = pytest.importorskip("pandas")
    table = pandas.read_parquet(sweep.save(tmp_path / "sweep.parquet"))
    assert table.index.name == "member"
    np.testing.assert_array_equal(table["tip"], sweep.table()["tip"])
    assert table["simulate.time_step"].dtype == float


@pytest.mark.parametrize("block", [64, 4, 1])
def test_a_store_gives_back_everything(sweep, tmp_path, monkeypatch, block):
    """Members in pieces of any size are the same, bit for bit, attributes and the one that failed too."""
    monkeypatch.setattr(sweep_store, "MEMBERS", block)
    again = vr.load(sweep.save(tmp_path / "sweep.zarr"), Sweep)
    assert again.table().equals(sweep.table())
    assert again.report() == sweep.report()
    assert again.separate == sweep.separate == ""
    for member, other in zip(sweep.members, again.members, strict=True):
        assert other.result.data.identical(member.result.data)
        assert type(other.result) is type(member.result)
    assert again.members[5].result.time.size == 3
    own, stored = sweep.data, again.data
    assert stored["member"].values.tolist() == [0, 1, 2, 3, 4, 6]
    assert stored["position"].dims == own["position"].dims
    assert set(own.variables) <= set(stored.variables)
    for name in own.variables:
        np.testing.assert_array_equal(
            np.broadcast_to(own[name].values, stored[name].shape), stored[name].values
        )


def test_a_store_replaces_a_store_and_nothing_else(sweep, tmp_path):
    path = sweep.save(tmp_path / "sweep.zarr")
    sweep.save(path)
    assert [one.name for one in tmp_path.iterdir()] == ["sweep.zarr"]
    other = tmp_path / "other.zarr"
    other.mkdir()
    with pytest.raises(vr.InputError, match="is no store of a sweep"):
        sweep.save(other)


@pytest.mark.parametrize("way", [KeyboardInterrupt, PermissionError])
def test_a_store_that_is_not_replaced_stays(sweep, tmp_path, monkeypatch, way):
    """The earlier store is moved aside, and comes back if the new one cannot take its place."""
    path = sweep.save(tmp_path / "sweep.zarr")
    rename = Path.rename

    def stopped(self, target):
        if self.name.startswith("new-"):
            raise way(13, "no")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", stopped)
    with pytest.raises((KeyboardInterrupt, vr.InputError)):
        sweep.save(path)
    assert [file.name for file in tmp_path.iterdir()] == ["sweep.zarr"]
    assert vr.load(path, Sweep).table().equals(sweep.table())


def test_members_that_differ_are_apart(tmp_path):
    sweep = computed()
    members = [replace(member) for member in sweep.members]
    members[3] = replace(members[3], stored=computed(**{"rods.beam.elements": 2}).members[3].result)
    mixed = Sweep(members, "Strip")
    again = vr.load(mixed.save(tmp_path / "sweep.zarr"), Sweep)
    assert again.separate == mixed.separate == "their numbers of stations differ (4 and 7)"
    assert "position" not in again.data
    for member, other in zip(mixed.members, again.members, strict=True):
        assert other.result.data.identical(member.result.data)


def test_a_missing_piece_is_told_and_not_read_as_zeros(sweep, tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_store, "MEMBERS", 2)
    path = sweep.save(tmp_path / "sweep.zarr")
    shutil.rmtree(path / "position" / "c" / "1")
    again = vr.load(path)
    assert again.table().equals(sweep.table())
    with pytest.raises(vr.InputError, match="1 of 3 pieces of position are missing"):
        _ = again.members[0].result


def test_a_changed_piece_is_told(sweep, tmp_path):
    path = sweep.save(tmp_path / "sweep.zarr")
    piece = next(one for one in (path / "position" / "c").rglob("*") if one.is_file())
    content = bytearray(piece.read_bytes())
    content[len(content) // 2] ^= 1
    piece.write_bytes(content)
    with pytest.raises(vr.InputError, match="is damaged"):
        _ = vr.load(path).members[0].result


def test_an_ensemble_stays_one(tmp_path):
    import scipy.stats as st

    case = case_from_dict(content("equilibrium"))
    found = vr.ensemble(
        case,
        {"materials.rubber.youngs_modulus": st.norm(1e6, 5e4)},
        8,
        quantities={"tip": QUANTITIES["tip"]},
        workers=1,
        fields=True,
    )
    for name in ("sweep.parquet", "sweep.zarr"):
        again = vr.load(found.save(tmp_path / name), vr.Ensemble)
        assert again.quantiles().equals(found.quantiles())


@pytest.mark.parametrize("text", [b"", b"PAR1 nothing PAR1"])
def test_a_damaged_table_is_one_message(tmp_path, text):
    path = tmp_path / "sweep.parquet"
    path.write_bytes(text)
    with pytest.raises(vr.InputError, match="is no table that viscorod wrote, or a damaged one"):
        vr.load(path)


def test_a_table_of_something_else_is_refused(tmp_path):
    pandas = pytest.importorskip("pandas")
    path = tmp_path / "other.parquet"
    pandas.DataFrame({"a": [1]}).to_parquet(path)
    with pytest.raises(vr.InputError, match="is no table that viscorod wrote"):
        vr.load(path)


def test_missing_packages_are_one_message(sweep, tmp_path, monkeypatch):
    monkeypatch.setattr(store_regions, "find_spec", lambda _: None)
    with pytest.raises(vr.InputError, match=r"pip install 'viscorod\[store\]'"):
        sweep.save(tmp_path / "sweep.zarr")
    monkeypatch.setattr(parquet, "import_module", lambda name: (_ for _ in ()).throw(ImportError(name)))
    with pytest.raises(vr.InputError, match=r"pip install 'viscorod\[store\]'"):
        sweep.save(tmp_path / "sweep.parquet")


@pytest.mark.parametrize(
    ("asked", "name"), [([], "sweep.zarr"), (["--quantity", "tip=displacement beam.end y"], "sweep.parquet")]
)
def test_the_command_writes_large_sweeps_so(tmp_path, monkeypatch, asked, name):
    """With whole results a store, with quantities alone a table; members are on disk while it runs."""
    monkeypatch.setattr(sweep_command, "LARGEST_FILE", 2)
    path = tmp_path / "strip.toml"
    path.write_text(case_from_dict(content("equilibrium")).model(vr.Model).to_toml(None, "equilibrium"))
    widths = [
        "--set",
        "rods.beam.section.width=9 mm,10 mm,11 mm",
        "--workers",
        "1",
        "-o",
        str(tmp_path / "out"),
    ]
    done = CliRunner().invoke(app, ["sweep", str(path), *widths, *asked])
    assert done.exit_code == 0, done.output
    found = vr.load(tmp_path / "out" / name)
    assert found.table()["rods.beam.section.width"].tolist() == [0.009, 0.01, 0.011]
    assert found.table(as_given=True)["rods.beam.section.width"].tolist() == ["9 mm", "10 mm", "11 mm"]
    assert (found.members[2].result is None) == bool(asked)
    assert vr.load(tmp_path / "out" / "sweep").count_completed == 3
