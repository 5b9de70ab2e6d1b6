"""Sweeps as tables: products of values, named numbers, records on disk, any executor."""

import gc
import itertools
import json
import math
import re
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from importlib import import_module

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import viscorod as vr
import viscorod.analyses.motion_start
import viscorod.analyses.sweep
from helpers.plain_text import flat
from helpers.quantities import ends_its_process_once, scaled_tip, times_tip, tip_at_end
from helpers.strip import content
from helpers.sweep_records import records_in
from viscorod.analyses.case_run import run_case
from viscorod.analyses.sweeps import member_work
from viscorod.analyses.sweeps.little_garbage import little_garbage
from viscorod.analyses.sweeps.rows import rows_of
from viscorod.casefile.case import case_from_dict
from viscorod.cli.app import app
from viscorod.results.data_schema import VARIABLES
from viscorod.results.function_record import function_record
from viscorod.results.quantity_values import FIELDS, unit_of
from viscorod.results.sweep_members import FoundMembers, Rows, SweepMembers
from viscorod.solve.transient.transient_solver import Transient

SHEAR = "materials.rubber.damping.shear_time"
FORCE = "loads[0].value[1]"
TIP = ("displacement", "beam.end", "y", "last")


@pytest.fixture
def held():
    return case_from_dict(content("equilibrium"))


@pytest.fixture
def swing():
    return case_from_dict(content("simulate", duration=0.1, time_step=0.01, output_interval=0.02))


def test_a_product_with_rows_and_constants(held):
    """Every combination, rows slowest; tips are those of the linear beam, F L^3 / 3 E I, while they are small."""
    sweep = vr.sweep(
        held,
        {FORCE: [1e-4, 2e-4]},
        grid={"materials.rubber.youngs_modulus": [1e6, 2e6], "sections.thin.height": [0.01, 0.02]},
        constants={"rods.beam.elements": 2},
        quantities={"tip": TIP, "twice": "displacement beam.end y max_abs", "mine": tip_at_end},
        workers=1,
    )
    table = sweep.table()
    assert list(table.columns[:7]) == [
        FORCE, "materials.rubber.youngs_modulus", "sections.thin.height", "rods.beam.elements", "tip", "twice", "mine",
    ]  # fmt: skip
    assert table[FORCE].tolist() == [1e-4] * 4 + [2e-4] * 4
    assert table["sections.thin.height"].tolist() == [0.01, 0.02] * 4
    inertia = 0.01 * table["sections.thin.height"] ** 3 / 12.0
    other = table["sections.thin.height"] * 0.01**3 / 12.0
    deflection = table[FORCE] * 0.3**3 / (3.0 * table["materials.rubber.youngs_modulus"])
    ratio = table["tip"] / deflection
    axis = inertia if abs(ratio[1] * inertia[1] - 1.0) < 0.1 else other
    np.testing.assert_allclose(ratio * axis, 1.0, rtol=0.02)  # and a little shear
    assert table["twice"].tolist() == table["tip"].tolist() == table["mine"].tolist()
    assert set(table["outcome"]) == {"completed"}
    assert sweep.members[0].result is None
    assert "position" not in sweep.data
    assert sweep.data["tip"].dims == ("member",)


def test_numbers_are_those_of_the_result_alone(swing):
    quantities = {
        "tip": TIP,
        "at": ("velocity", "beam@0.15", "y", 0.05),
        "moment": ("section_force", "beam.start", "bend_1", "max_abs"),
        "pull": ("reaction", "beam.start", "mz", "range"),
        "speed": ("velocity", "beam.end", "size", "rms"),
        "lost": ("energy", "viscous", "last"),
        "way": ("displacement", "beam.end", "y", "history"),
    }
    sweep = vr.sweep(swing, {SHEAR: [0.01, 0.02]}, quantities=quantities, workers=1)
    alone = run_case(swing)
    row = sweep.table().loc[1]
    there = alone.probe(["beam.end", "beam@0.15"], [0.05])
    assert row["at"] == there["velocity"].values[0, 1, 1]
    assert row["tip"] == alone.history("beam.end", "displacement").values[-1, 1]
    moments = alone.probe("beam.start")["section_force"].values[:, 0, 3]
    assert row["moment"] == np.abs(moments).max()
    assert row["lost"] == alone.energy.viscous[-1]
    reaction = alone.data["reaction"].sel(support="beam.start", motion="mz").values
    assert row["pull"] == reaction.max() - reaction.min()
    speed = np.linalg.norm(alone.history("beam.end", "velocity").values, axis=1)
    assert row["speed"] == np.sqrt(np.trapezoid(speed**2, alone.time) / 0.1)
    assert "way" not in row
    way = sweep.data["way"]
    assert way.dims == ("member", "instant")
    np.testing.assert_array_equal(
        way[1], alone.probe("beam.end", np.linspace(0.0, 0.1, 201))["displacement"].values[:, 0, 1]
    )


def test_rows_of_tables_and_files(held, tmp_path):
    table = pd.DataFrame({FORCE: [1e-4, 3e-4], "rods.beam.elements": [1, 2]})
    path = tmp_path / "rows.csv"
    table.to_csv(path, index=False)
    vectors = tmp_path / "vectors.csv"
    pd.DataFrame(
        {"loads[0].value": ["[0, 1e-4, 0]", "[0.0, 3e-4, 0.0]"], "rods.beam.elements": [1, 2]}
    ).to_csv(vectors, index=False)
    tips = [
        vr.sweep(held, given, quantities={"tip": TIP}, workers=1).table()["tip"].tolist()
        for given in (table, path, vectors)
    ]
    assert tips[0] == tips[1] == tips[2]
    (tmp_path / "gap.csv").write_text(f"{FORCE},rods.beam.elements\n1e-4,\n")
    for wrong, words in (
        ("gap.csv", r"cells of rods.beam.elements \(first in row 0\) are empty"),
        ("none.csv", "cannot be read"),
    ):
        with pytest.raises(vr.InputError, match=words):
            vr.sweep(held, tmp_path / wrong, workers=1)


@pytest.mark.parametrize(
    ("column", "words"),
    [
        (
            pd.Series([1e-4, np.nan]),
            f"{FORCE.replace('[', '.').replace(']', '.')} in row 1: the table has no value",
        ),
        (pd.Series([None, 1], dtype="Int64"), "in row 0: the table has no value there"),
        (pd.Series([], dtype=float), "the table has no rows"),
    ],
)
def test_gaps_of_tables_are_told(held, column, words):
    with pytest.raises(vr.InputError, match=words):
        vr.sweep(held, pd.DataFrame({FORCE: column}), workers=1)


def test_ranges_are_lists_of_values():
    assert list(rows_of({"rods.beam.elements": range(1, 4)}).columns["rods.beam.elements"]) == [1, 2, 3]


WRONG = [
    ({"tip": ("displacment", "beam.end", "y", "max")}, "quantities.tip: displacment: no quantity"),
    ({"tip": ("displacement", "beam.end", "y")}, "more words are needed"),
    ({"tip": ("displacement", "beam.end", "w", "max")}, "w: no component; give one of x, y, z, size"),
    ({"tip": ("displacement", "beam.end", "y", "largest")}, "largest: no way to make a number"),
    ({"tip": ("displacement", "boom.end", "y", "max")}, "quantities.tip: boom.end"),
    ({"tip": ("frequency", 1)}, "a result of [simulate] has none; it goes with modes, response"),
    ({"tip": ("decrement", "beam.end", "y", "period", 0)}, "cycles are numbered from 1"),
    ({SHEAR: TIP}, "the table has a column or a variable 'materials.rubber.damping.shear_time' of its own"),
    (
        {"steps": TIP},
        "the table has a column or a variable 'steps' of its own; give another name, such as 'my_steps'",
    ),
    ({"tip": 3.0}, "no quantity"),
    ({"tip": ("energy",)}, "nothing: 2 more words are needed"),
]


@pytest.mark.parametrize(("quantities", "words"), WRONG)
def test_wrong_quantities_are_refused_before_anything_runs(swing, quantities, words, monkeypatch):
    monkeypatch.setattr(member_work, "run_case", lambda *_, **__: pytest.fail("computed"))
    with pytest.raises(vr.InputError) as caught:
        vr.sweep(swing, {SHEAR: [0.01, 0.02]}, quantities=quantities, workers=1)
    assert words in str(caught.value)


def test_a_number_that_cannot_be_had_is_missing_and_says_why(swing):
    def fails(run):
        raise ZeroDivisionError("nothing there")

    quantities = {
        "tip": TIP,
        "ratio": ("decrement", "beam.end", "y"),
        "mine": fails,
        "nan": lambda run: np.nan,
    }
    sweep = vr.sweep(swing, {SHEAR: [0.01]}, quantities=quantities, workers=1)
    row = sweep.table().loc[0]
    assert row["outcome"] == "completed"
    assert np.isfinite(row["tip"])
    assert np.isnan(
        row[["ratio", "mine", "nan"]].to_numpy(dtype=float)
    ).all()  # columns are there all the same
    for words in (
        "ratio: beam.end along y passes no complete maximum",
        "mine: ZeroDivisionError",
        "nan: nan is not one finite",
    ):
        assert words in row["message"]
        assert words in flat(sweep.report())


def test_errors_of_some_members(swing):
    """Estimates are made beside the motion: without them every other number is the same, bit for bit."""
    values, quantities = {SHEAR: [0.01, 0.02, 0.03]}, {"tip": TIP, "lost": ("energy", "viscous", "last")}
    whole = vr.sweep(swing, values, quantities=quantities, workers=1).table()
    some = vr.sweep(swing, values, quantities=quantities, workers=1, errors=2).table()
    assert some[["tip", "lost", "steps"]].equals(whole[["tip", "lost", "steps"]])
    for name in ("mesh_error", "step_error"):
        assert some[name].notna().tolist() == [True, False, True]
        assert some[name][[0, 2]].tolist() == whole[name][[0, 2]].tolist()
    with pytest.raises(vr.InputError, match="errors: -1: a number of members is needed"):
        vr.sweep(swing, values, workers=1, errors=-1)


def test_many_members_have_the_errors_of_some(held):
    """The first, the last and those evenly between; whole results have theirs in any case."""
    values, given = {FORCE: np.linspace(1e-4, 2e-4, 9)}, {"quantities": {"tip": TIP}, "workers": 1}
    estimated = viscorod.analyses.sweep._estimated
    assert sorted(estimated(127, None, False)) == list(range(0, 127, 2))
    assert estimated(127, None, True) == set(range(127))
    assert estimated(60, None, False) == estimated(60, 100, False) == set(range(60))
    assert estimated(60, 0, False) == set()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(viscorod.analyses.sweep, "MOST_ERRORS", 3)
        some, all_of_them = vr.sweep(held, values, **given), vr.sweep(held, values, **given, errors=9)
    assert some.table()["mesh_error"].notna().to_numpy().nonzero()[0].tolist() == [0, 4, 8]
    assert "errors are estimated for 3 of 9 members" in some.report()
    assert all_of_them.table()["mesh_error"].notna().all()
    assert all_of_them.table()["tip"].equals(some.table()["tip"])


def test_members_take_steps_as_runs_by_themselves_do(swing, monkeypatch):
    """Many at once where they can, and without small motions about the start where nothing asks for them."""
    asked, run = [], Transient.run

    def watched(self, *args, **given):
        asked.append(given["patient"])
        return run(self, *args, **given)

    def refused(*_args, **_given):
        raise AssertionError

    monkeypatch.setattr(Transient, "run", watched)
    values, given = {SHEAR: [0.01, 0.02]}, {"quantities": {"tip": TIP}, "workers": 1}
    for constants in ({"simulate.tolerance": 1e-4}, {"simulate.tolerance": 1e-4, "simulate.duration": 0.05}):
        whole = vr.sweep(swing, values, constants=constants, **given).table()
        with monkeypatch.context() as patch:
            patch.setattr(viscorod.analyses.motion_start, "linearise", refused)
            bare = vr.sweep(swing, values, constants=constants, errors=0, **given).table()
        assert bare["outcome"].tolist() == 2 * ["completed"]
        assert bare[["tip", "steps"]].equals(whole[["tip", "steps"]])
    assert asked == 8 * [True]


@pytest.mark.parametrize("fields", [False, True])
def test_what_is_on_disk_is_not_computed_again(swing, fields, tmp_path, monkeypatch):
    """A call that stopped half-way: the next one computes the rest, bit for bit what one call gives."""
    values, folder = {SHEAR: [0.01, 0.02, 0.03]}, tmp_path / "sweep"
    given = {"quantities": {"tip": TIP}, "fields": fields, "workers": 1}
    whole = vr.sweep(swing, values, **given)
    first = vr.sweep(swing, values, **given, folder=folder, members=slice(0, 2))
    assert [member.outcome for member in first.members] == ["completed", "completed", "not run"]
    assert vr.load(folder).report() == first.report()
    lines = next((folder / "members").glob("*.jsonl"))
    lines.write_text(lines.read_text()[:-20])  # the process was killed while it wrote the second
    done = []

    def counted(case, **options):
        done.append(case.content["materials"]["rubber"]["damping"]["shear_time"])
        return run_case(case, **options)

    monkeypatch.setattr(member_work, "run_case", counted)
    second = vr.sweep(swing, values, **given, folder=folder)
    assert done == [0.02, 0.03]
    assert second.table()["tip"].tolist() == whole.table()["tip"].tolist()
    again = vr.sweep(swing, values, **given, folder=folder)
    assert len(done) == 2
    for sweep in (again, vr.load(folder)):
        assert sweep.table().equals(second.table())
        if fields:
            assert np.array_equal(sweep.data["position"], whole.data["position"])
    vr.sweep(
        swing,
        values,
        **given | {"quantities": {"tip": ("displacement", "beam.end", "y", "max")}},
        folder=folder,
    )
    assert len(done) == 5  # other numbers are other members


@pytest.mark.filterwarnings("ignore")  # those of the runs alone are looked at
def test_what_members_warn_of_is_in_the_table(swing, tmp_path):
    """What each member's run alone warns of, whether its errors are estimated or not, wherever it was computed."""
    other = content("simulate", duration=0.1, time_step=0.01, output_interval=0.02)
    other["materials"]["rubber"]["damping"]["shear_time"] = 0.03
    alone = [run_case(swing).warnings, run_case(case_from_dict(other), errors=False).warnings]
    assert any("section forces may be off" in text for text in alone[0])
    given = {"quantities": {"tip": TIP}, "executor": "threads:2", "errors": 1, "folder": tmp_path}
    found = vr.sweep(swing, {SHEAR: [0.02, 0.03]}, **given)
    for sweep in (found, vr.load(tmp_path)):
        table = sweep.table()
        assert table["outcome"].tolist() == ["completed", "completed"]
        told = ["; ".join(f"warning: {text}" for text in texts) for texts in alone]
        assert table["message"].tolist() == told
        assert flat(f"member 0: warning: {alone[0][0]}") in flat(sweep.report())


def test_doubts_of_a_member_whose_errors_are_not_estimated_are_told(held):
    """A force of 1000 N strains the rubber far beyond its law; one of 0.2 mN does not."""
    found = vr.sweep(held, {FORCE: [2e-4, 1e3]}, quantities={"tip": TIP}, workers=1, errors=0)
    first, second = found.table()["message"]
    assert not first
    assert "the material law is linear and meant for strains well below 1" in second


def test_failures_are_data_on_disk_too(swing, tmp_path, monkeypatch):
    def fails(case, **options):
        if case.content["materials"]["rubber"]["damping"]["shear_time"] == 0.02:
            raise vr.SolveError("it broke")
        return run_case(case, **options)

    monkeypatch.setattr(member_work, "run_case", fails)
    given = {"quantities": {"tip": TIP}, "workers": 1, "folder": tmp_path, "errors": 0}
    vr.sweep(swing, {SHEAR: [0.01, 0.02]}, **given)
    monkeypatch.setattr(member_work, "run_case", lambda *_, **__: pytest.fail("computed again"))
    table = vr.sweep(swing, {SHEAR: [0.01, 0.02]}, **given).table()
    assert table["outcome"].tolist() == ["completed", "failed"]
    assert table["message"].tolist() == ["", "it broke"]
    assert np.isnan(table["tip"][1])


def test_a_saved_sweep_keeps_its_numbers(swing, tmp_path):
    quantities = {"tip": TIP, "way": ("displacement", "beam.end", "y", "history")}
    for fields in (False, True):
        sweep = vr.sweep(swing, {SHEAR: [0.01, 0.02]}, quantities=quantities, fields=fields, workers=1)
        loaded = vr.load(sweep.save(tmp_path / "sweep.nc"))
        assert loaded.table().equals(sweep.table())
        assert loaded.data["way"].equals(sweep.data["way"])
        if fields:
            for one, other in zip(sweep.members, loaded.members, strict=True):
                assert other.result.data.identical(one.result.data)


@pytest.mark.parametrize("name", ["sweep.nc", "sweep.parquet", "folder"])
def test_a_number_that_no_member_has_keeps_its_column(held, tmp_path, name):
    """A script that reads a column of numbers does not break where none of the members has one."""
    if name == "sweep.parquet":
        pytest.importorskip("pyarrow")
    quantities = {"never": lambda _: math.nan, "tip": TIP}
    folder = tmp_path / "folder"
    sweep = vr.sweep(held, {FORCE: [1e-4, 2e-4]}, quantities=quantities, folder=folder, workers=1)
    table = sweep.table()
    assert list(table.columns[1:3]) == ["never", "tip"]
    assert table["never"].isna().all()
    assert sweep.quantities == ("never", "tip")
    assert "never" not in sweep.data
    again = vr.load(folder if name == "folder" else sweep.save(tmp_path / name))
    assert again.table().equals(table)
    assert again.report() == sweep.report()


def test_threads_give_the_same_bits(swing, tmp_path):
    values, quantities = {SHEAR: [0.01, 0.02, 0.03, 0.04, 0.05]}, {"tip": TIP}
    alone = vr.sweep(swing, values, quantities=quantities, workers=1).table()["tip"].tolist()
    assert (
        vr.sweep(swing, values, quantities=quantities, executor="threads:2").table()["tip"].tolist() == alone
    )
    with ThreadPoolExecutor(2) as threads:
        done = []
        sweep = vr.sweep(swing, values, quantities=quantities, executor=threads, progress=done.append)
    assert sweep.table()["tip"].tolist() == alone
    assert done[-1] == 5.0


def test_a_task_that_its_engine_gave_up_is_not_tried_again(swing):
    """Dask tells of a worker that was lost after four of them; members of larger batches have another try."""
    kind = type("KilledWorker", (Exception,), {})

    class Giving(Losing):
        def submit(self, work, jobs):
            future = super().submit(work, jobs)
            if future.exception() is not None:
                future = Future()
                future.set_exception(kind("on 4 workers"))
            return future

    executor = Giving(after=False)
    table = vr.sweep(swing, {SHEAR: [0.02]}, executor=executor, quantities={"tip": TIP}).table()
    assert executor.lost == 1
    assert table["message"][0] == "its worker was lost 3 times (KilledWorker: on 4 workers)"


class Losing(Executor):
    """Loses the worker of one member, before it computes or after that; all else is computed at once."""

    def __init__(self, after):
        self.after, self.lost = after, 0

    def submit(self, work, jobs):
        future = Future()
        if any(row[SHEAR] == 0.02 for row, *_ in jobs):
            self.lost += 1
            if self.after:
                work(jobs)
            future.set_exception(OSError("no heartbeat"))
        else:
            future.set_result(work(jobs))
        return future

    def shutdown(self, *_, **__):
        return


@pytest.mark.parametrize("after", [False, True])
def test_a_member_that_loses_its_worker_is_tried_three_times(swing, after, tmp_path):
    """What it left on disk counts; a member that never gets so far is reported, and costs no other anything."""
    executor = Losing(after)
    given = {"quantities": {"tip": TIP}, "errors": 0}
    values = {SHEAR: [0.01, 0.02, 0.03]}
    table = vr.sweep(swing, values, executor=executor, folder=tmp_path, **given).table()
    assert executor.lost == (1 if after else 3)
    assert table["outcome"].tolist() == ["completed", "completed" if after else "failed", "completed"]
    if after:
        assert table["tip"].tolist() == vr.sweep(swing, values, workers=1, **given).table()["tip"].tolist()
    else:
        assert table["message"][1] == "its worker was lost 3 times (OSError: no heartbeat)"


@pytest.mark.parametrize("executor", ["fork", "processes:0", "threads:x", 3])
def test_what_is_no_executor_is_refused(swing, executor):
    with pytest.raises(vr.InputError, match="executor"):
        vr.sweep(swing, {SHEAR: [0.01]}, executor=executor)


@pytest.mark.slow
def test_a_worker_of_any_executor_that_is_killed_loses_nothing(swing, tmp_path, monkeypatch):
    """The pool breaks; what was done stays, and the next call computes the rest, each member once."""
    monkeypatch.setenv("ENDS_ONCE", str(tmp_path / "ended"))
    values, quantities = {SHEAR: [0.01, 0.02, 0.03]}, {"tip": TIP, "mine": ends_its_process_once}
    given = {"quantities": quantities, "folder": tmp_path / "sweep"}
    with ProcessPoolExecutor(1) as pool, pytest.raises(vr.SolveError, match="the executor gave up") as caught:
        vr.sweep(swing, values, executor=pool, **given)
    assert caught.value.run.members[2].outcome == "not run"
    with ProcessPoolExecutor(1) as pool:
        sweep = vr.sweep(swing, values, executor=pool, **given)
    assert (tmp_path / "ended").exists()
    assert set(sweep.table()["outcome"]) == {"completed"}
    names = [record["name"] for record in records_in(tmp_path / "sweep")]
    assert len(names) == len(set(names)) == 3
    alone = vr.sweep(swing, values, quantities={"tip": TIP}, workers=1)
    assert sweep.table()["tip"].tolist() == alone.table()["tip"].tolist()


def test_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shape = json.dumps([0.0, 1e-3, 0.0])
    (tmp_path / "strip.toml").write_text(
        f"""title = "Strip"
[materials.rubber]
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0
damping = {{ shear_time = 0.02, bulk_time = 0.02 }}
[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.3, 0.0, 0.0]
section = {{ shape = "rectangle", width = 0.01, height = 0.01 }}
material = "rubber"
elements = 1
order = 3
[[supports]]
kind = "clamp"
at = "beam.start"
[[loads]]
kind = "force"
at = "beam.end"
value = {shape}
[equilibrium]
"""
    )
    grid = [
        "--grid",
        f"{FORCE}=1e-4:3e-4:3",
        "--grid",
        "rods.beam.elements=1,2",
        "--set",
        "rods.beam.order=2",
    ]
    asked = ["--quantity", "tip=displacement beam.end y"]
    for part in ("0:2", "2:6"):
        found = CliRunner().invoke(
            app, ["sweep", "strip.toml", *grid, *asked, "--members", part, "--workers", "1"]
        )
        assert found.exit_code == 0, found.output
    found = CliRunner().invoke(app, ["sweep", "strip.toml", *grid, *asked, "--workers", "1"])
    assert found.exit_code == 0, found.output
    assert "6 members, 6 completed" in found.stdout
    table = pd.read_csv(tmp_path / "out" / "strip" / "sweep.csv")
    assert table[FORCE].tolist() == pytest.approx([1e-4, 1e-4, 2e-4, 2e-4, 3e-4, 3e-4], rel=1e-15)
    assert table["rods.beam.order"].tolist() == [2] * 6
    run = CliRunner().invoke(app, ["run", "strip.toml", "--set", f"{FORCE}=3e-4", "--set", "rods.beam.elements=2",
                                   "--set", "rods.beam.order=2"])  # fmt: skip
    assert run.exit_code == 0, run.output
    result = vr.load(tmp_path / "out" / "strip" / "run.nc")
    assert result.displacement("beam.end")[1] == table["tip"].iloc[-1]
    assert json.loads(result.data.attrs["case_changes"]) == {
        FORCE: 3e-4, "rods.beam.elements": 2, "rods.beam.order": 2,
    }  # fmt: skip
    for wrong in (["--grid", "a=1:2:x"], ["--quantity", "tip"], ["--members", "1-2"], ["--scheduler", "x"],
                  ["--executor", "none"]):  # fmt: skip
        refused = CliRunner().invoke(app, ["sweep", "strip.toml", "--set", f"{FORCE}=1e-4", *wrong])
        assert refused.exit_code == 2, refused.output


def test_a_table_as_people_write_it(tmp_path):
    """Comments, spaces after commas, units in heads, numbers to the last bit."""
    path = tmp_path / "rows.csv"
    path.write_text(
        "\ufeff# measured on Monday\nsections.thin.height [mm], loads[0].value[1],loads[0].value\n"
        '10, 0.1000000000000000055,"[0.0, 1e-4, 0.0]"\n12.5,0.30000000000000004,"[0.0, 2e-4, 0.0]"\n',
        encoding="utf-8",
    )
    rows = rows_of(path)
    assert list(rows.columns) == ["sections.thin.height", FORCE, "loads[0].value"]
    assert rows[1] == {
        "sections.thin.height": "12.5 mm", FORCE: 0.30000000000000004, "loads[0].value": [0.0, 2e-4, 0.0]
    }  # fmt: skip
    assert [row[FORCE] for row in rows[:2]] == [0.1, 0.30000000000000004]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (",a\n0,1.0\n", "column 1 has no head; it may be the index"),
        ("a,a\n1.0,2.0\n", "two columns are called a"),
        ("a [mm],a\n1.0,2.0\n", "two columns are called a"),
        ("a\n", "has no rows"),
        ("", "cannot be read as a table"),
        ("a,b\n1.0,2.0\n1.0,\n", r"cells of b \(first in row 1\) are empty"),
        ("a;b\n1,5;2\n", "with commas between its cells"),
    ],
)
def test_tables_that_are_none(tmp_path, text, message):
    path = tmp_path / "rows.csv"
    path.write_text(text)
    with pytest.raises(vr.InputError, match=message):
        rows_of(path)


def test_columns_are_rows_and_products():
    """Against the product of the standard library; the last key varies fastest."""
    grid = {"b": [1, 2], "c": ["x", "y", "z"]}
    rows = rows_of({"a": [0.5, 1.5]}, grid, {"d": [0.0, 1.0]})
    expected = [
        {"a": a, "b": b, "c": c, "d": [0.0, 1.0]} for a, b, c in itertools.product([0.5, 1.5], *grid.values())
    ]
    assert list(rows) == rows[:] == expected
    assert rows[-1] == expected[-1]
    with pytest.raises(IndexError):
        rows[12]
    twice = pd.DataFrame([[1.0, 2.0]], columns=["a", "a"])
    with pytest.raises(vr.InputError, match="the table has this column twice"):
        rows_of(twice)


@pytest.mark.parametrize(
    ("members", "message"),
    [(2, "a slice is needed"), (slice(7, 9), "none of the 3 members"), (slice("a"), "no numbers of members")],
)
def test_members_that_are_none(held, members, message):
    with pytest.raises(vr.InputError, match=message):
        vr.sweep(held, {FORCE: 3 * [1e-4]}, quantities={"tip": TIP}, workers=1, members=members)


def test_a_part_is_reported_by_itself(held):
    """An array job lists the members that it computed, however many come before them."""
    values = {FORCE: np.linspace(1e-4, 2e-4, 90)}
    given = {"quantities": {"tip": TIP}, "workers": 1, "errors": 0}
    told = []
    sweep = vr.sweep(held, values, **given, members=slice(80, 83), progress=told.append)
    assert told[-1] == 3.0, "three members of this call are done, and not the 87 that others compute"
    report = sweep.report()
    assert [line.split()[0] for line in report.splitlines() if line.startswith("  8")][:3] == [
        "80",
        "81",
        "82",
    ]
    assert "87 members were not run and are not listed" in report
    with pytest.raises(vr.InputError, match="members: 170:: none of the 90 members"):
        vr.sweep(held, values, quantities={"tip": TIP}, workers=1, members=slice(170, None))


def test_what_all_members_share_has_no_lines_of_its_own(held):
    """The axis is the parameter that varies, and a constant stands in no legend."""
    values = {"rods.beam.order": [3, 3], FORCE: [1e-4, 2e-4]}
    constants = {"materials.rubber.density": 900.0}
    sweep = vr.sweep(held, values, constants=constants, quantities={"tip": TIP}, workers=1)
    (axes,) = sweep.plot().axes
    assert axes.get_xlabel() == f"{FORCE} [µN]"
    assert re.fullmatch(r"tip \[[µnm]?m\]", axes.get_ylabel())  # what the words of a quantity read has a unit
    assert sweep.data["tip"].attrs["units"] == "m"
    assert axes.get_legend() is None
    (line,) = (line for line in axes.lines if len(line.get_xdata()) == 2 and line.get_marker() == "o")
    assert list(line.get_xdata()) == [1e-4, 2e-4]
    assert sweep.plot(x="rods.beam.order").axes[0].get_xlabel() == "rods.beam.order"


def test_functions_count_with_what_they_take_from_around_them(held, tmp_path):
    """A folder holds numbers of another function of the same words: they are not those that are asked for now."""
    given = {"workers": 1, "folder": tmp_path, "errors": 0}
    found = [
        vr.sweep(held, {FORCE: [1e-4]}, quantities={"tip": quantity}, **given).table()["tip"][0]
        for quantity in (times_tip(1.0), times_tip(2.0), partial(scaled_tip, 3.0), partial(scaled_tip, 4.0))
    ]
    assert [value / found[0] for value in found] == pytest.approx([1.0, 2.0, 3.0, 4.0], rel=1e-12)
    assert function_record(times_tip(2.0)) == function_record(times_tip(2.0))
    assert function_record(sum) != function_record(max)  # which have no source


def test_wrong_values_among_many_members_are_found_before_any_is_computed(held, monkeypatch):
    """Those that are not looked at one by one: the least and the largest of every key are."""
    monkeypatch.setattr(import_module("viscorod.analyses.sweep"), "LOOKED_AT", 4)
    widths = np.linspace(0.01, 0.011, 20).tolist()
    given = {"quantities": {"tip": TIP}, "workers": 1, "errors": 0}
    for wrong, text in ((-0.01, "-0.01"), (math.nan, "nan"), ("-3 mm", "-0.003")):
        changed = [*widths[:11], wrong, *widths[12:]]
        with pytest.raises(vr.InputError, match=rf"sections.thin.width: {text}.*member 11"):
            vr.sweep(held, {"sections.thin.width": changed, FORCE: [1e-4] * 20}, **given)
    changed = [*widths[:11], "wide", *widths[12:]]
    table = vr.sweep(held, {"sections.thin.width": changed}, **given).table()
    assert table["outcome"].tolist() == ["completed"] * 11 + ["refused"] + ["completed"] * 8


def test_a_line_of_which_a_bit_flipped_does_not_count(held, tmp_path):
    """Every bit of every byte of a member's line: it is read as it was, or computed again; never another number."""
    given = {"quantities": {"tip": TIP, "sum": TIP}, "workers": 1, "errors": 0, "folder": tmp_path}
    expected = vr.sweep(held, {FORCE: [1e-4]}, **given).table().drop(columns="wall_time_s")
    (file,) = (tmp_path / "members").glob("*.jsonl")
    content_of_it = file.read_bytes()
    missing = 0
    for at in range(len(content_of_it)):
        changed = bytearray(content_of_it)
        changed[at] ^= 1 << at % 8
        file.write_bytes(changed)
        table = vr.load(tmp_path).table()
        if table["outcome"][0] == "not run":
            missing += 1
        else:
            assert table.drop(columns="wall_time_s").equals(expected)
    assert missing > 0.9 * len(content_of_it)
    assert vr.sweep(held, {FORCE: [1e-4]}, **given).table()["tip"].tolist() == expected["tip"].tolist()


def test_a_line_of_before_has_no_checksum(held, tmp_path):
    given = {"quantities": {"tip": TIP, "sum": TIP}, "workers": 1, "errors": 0, "folder": tmp_path}
    expected = vr.sweep(held, {FORCE: [1e-4]}, **given).table()
    (file,) = (tmp_path / "members").glob("*.jsonl")
    record = json.loads(file.read_text())
    record.pop("sum")
    file.write_text(f"\n{json.dumps(record)}\n")
    assert vr.load(tmp_path).table().equals(expected)


def test_histories_are_numbers_in_memory():
    """A history of 201 values takes their bytes, not those of objects."""
    found = FoundMembers(2, ())
    found[0] = None, "", "completed", {"path": [0.5 * k for k in range(201)]}, {}
    assert found.history(0, "path").nbytes == 201 * 8
    assert found[0][3] == {"path": [0.5 * k for k in range(201)]}
    assert found.history(1, "path") is None
    assert found.completed().tolist() == [True, False]
    assert found.with_results() == []


def test_members_are_columns():
    """What is put in comes out, missing numbers are missing, and what is kept of many does not grow with words."""
    found = FoundMembers(4)
    found[2] = None, "", "completed", {"a": 1.5, "way": [0.0, 1.0]}, {"steps": 3.0}
    found[0] = None, "it broke", "failed"
    assert (len(found), list(found), 1 in found, "x" in found) == (2, [0, 2], False, False)
    assert found[2] == (None, "", "completed", {"a": 1.5, "way": [0.0, 1.0]}, {"steps": 3.0})
    assert found[0] == (None, "it broke", "failed", {}, {})
    found[2] = None, "", "completed", {"b": 2.0}, {}
    assert found[2][3:] == ({"b": 2.0}, {})
    del found[2]
    with pytest.raises(KeyError):
        found[2]
    members = SweepMembers(Rows({"x": [1.0, 2.0, 3.0, 4.0]}, 4), found)
    assert [member.outcome for member in members] == ["failed", "not run", "not run", "not run"]
    assert members[-1].values == {"x": 4.0}
    assert len(members[1:3]) == 2


@pytest.fixture
def nothing_left_out():
    """No object that the search for garbage leaves out: those of before the first test are left out in conftest.py."""
    gc.unfreeze()
    yield
    gc.freeze()


@pytest.mark.usefixtures("nothing_left_out")
def test_what_the_search_for_garbage_leaves_out_comes_back():
    assert gc.get_freeze_count() == 0
    with little_garbage(), little_garbage():
        assert gc.get_freeze_count() > 0
    assert gc.get_freeze_count() == 0
    gc.freeze()  # as a program may do for itself
    try:
        with little_garbage():
            pass
        assert gc.get_freeze_count() > 0
    finally:
        gc.unfreeze()


@pytest.mark.parametrize("head", sorted(FIELDS.keys() & VARIABLES.keys()))
def test_quantities_have_the_units_of_the_fields_that_they_read(head):
    """Values: the units of the variables of a stored result."""
    units = VARIABLES[head][0].split(", ")
    parts = FIELDS[head] or ("",)
    for k, part in enumerate(parts):
        unit = units[k * len(units) // len(parts)]
        assert unit_of((head, "beam.end", part, "max")) == ("" if unit == "1" else unit)
