"""Sweeps: values land where they should, members are the single runs, failures stay where they are."""

import copy
import math
import multiprocessing
import os
import signal
import subprocess
import sys
import time
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.plain_text import flat
from helpers.quantities import as_the_environment_says
from viscorod.analyses.case_run import run_case
from viscorod.analyses.sweeps import member_work, process_start
from viscorod.casefile.case import case_from_dict
from viscorod.cli.app import app
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run
from viscorod.results.told_members import told_members

SWING = """
title = "A swing"

[materials.rubber]
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0
damping = { shear_time = 0.02, bulk_time = 0.02 }

[sections.thin]
shape = "rectangle"
width = 0.01
height = 0.01

[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.3, 0.0, 0.0]
section = "thin"
material = "rubber"
elements = 1
order = 3

[[supports]]
kind = "clamp"
at = "beam.start"

[[loads]]
kind = "force"
at = "beam.end"
value = [0.0, 0.02, 0.0]
until = 0.0

[simulate]
duration = 0.2
time_step = 0.01
"""
HELD = SWING.split("[simulate]", maxsplit=1)[0] + "[equilibrium]\n"
SHEAR = "materials.rubber.damping.shear_time"
IN_ONE_AND_TWO = pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
"""In this process, and in two more that have to start."""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "swing.toml"
    path.write_text(SWING)
    return path


@pytest.fixture
def held(tmp_path):
    path = tmp_path / "held.toml"
    path.write_text(HELD)
    return path


def single(text, output_interval=0.001, **values):
    """The run of one member, computed alone."""
    content = tomllib.loads(text)
    content["materials"]["rubber"]["damping"]["shear_time"] = values["shear_time"]
    content["loads"][0]["value"] = values["force"]
    content["simulate"]["output_interval"] = output_interval
    return run_case(case_from_dict(content))


def without_times(data):
    """Without what took time, and without the text of the case file, which is not that of a member."""
    return data.assign_attrs(wall_time_s=0.0, loop_time_s=0.0, case_text="", case_file="", case_hash="")


@IN_ONE_AND_TWO
def test_members_are_exactly_the_single_runs(case, workers):
    times, forces = [0.01, 0.04], [[0.0, 0.02, 0.0], [0.0, 0.0, 0.01]]
    done = []
    sweep = vr.sweep(case, {SHEAR: times, "loads[0].value": forces}, workers=workers, progress=done.append)
    assert [member.completed for member in sweep.members] == [True, True]
    for member, shear_time, force in zip(sweep.members, times, forces, strict=True):
        alone = single(SWING, shear_time=shear_time, force=force)
        assert without_times(member.result.data).identical(without_times(alone.data))
        stacked = sweep.data["position"].sel(member=member.number)
        assert np.array_equal(stacked, alone.data["position"])
    assert done[-1] == pytest.approx(2.0)
    assert sweep.data[SHEAR].values.tolist() == times
    assert sweep.data["loads[0].value"].values.tolist() == [str(force) for force in forces]
    assert sweep.data["time"].values == pytest.approx(0.001 * np.arange(201), abs=1e-15)
    assert "output_interval = 0.001 s" in flat(sweep.report())


def test_one_value_inside_a_list_and_rows_instead_of_columns(case):
    rows = [
        {"loads[0].value[1]": force, "simulate.output_interval": 0.05} for force in np.array([0.01, 0.02])
    ]
    sweep = vr.sweep(vr.load_case(case), rows, workers=1)
    tips = sweep.data["position"].isel(time=0, station=-1).sel(axis="y")
    linear = np.array([0.01, 0.02]) * 0.3**3 / (3.0 * 1e6 * 0.01**4 / 12.0)
    assert tips.values == pytest.approx(linear, rel=0.3)
    assert tips.values[1] < 2.0 * tips.values[0]
    assert sweep.data.sizes["time"] == 5
    assert sweep.notes == ()


def test_times_are_common_whatever_the_steps(case):
    sweep = vr.sweep(
        case, {"simulate.time_step": [0.01, 0.0037], "simulate.output_interval": [0.03, 0.03]}, workers=1
    )
    assert not sweep.separate
    assert sweep.data["time"].values == pytest.approx([0, 0.03, 0.06, 0.09, 0.12, 0.15, 0.18, 0.2], abs=1e-12)
    assert sweep.data["steps"].values[1] > sweep.data["steps"].values[0]
    assert sweep.table()["steps"].dtype.kind == "i"  # 105 steps, not 105.0


def test_different_meshes_are_kept_apart(case, tmp_path):
    sweep = vr.sweep(case, {"rods.beam.elements": [1, 2]}, workers=1)
    assert sweep.separate == "their numbers of stations differ (4 and 7)"
    assert "kept apart" in flat(sweep.report())
    assert "position" not in sweep.data
    assert sweep.data["steps"].dims == ("member",)
    again = vr.load(sweep.save(tmp_path / "sweep.nc"))
    assert again.report() == sweep.report()
    for member, other in zip(sweep.members, again.members, strict=True):
        assert other.result.data.identical(member.result.data)


def test_equilibria(held, tmp_path):
    sweep = vr.sweep(held, {"loads[0].value": [[0, 0.001, 0], [0, 0.002, 0]]}, workers=1)
    assert all(isinstance(member.result, Equilibrium) for member in sweep.members)
    assert sweep.data["position"].dims == ("member", "load_factor", "station", "axis")
    assert vr.load(sweep.save(tmp_path / "sweep.nc")).data.identical(sweep.data)


def test_a_failing_member_leaves_the_others_alone(case, monkeypatch, tmp_path):
    def fails_in_the_middle(case, **given):
        run = run_case(case, **given)
        damping = case.description.rods["beam"].material.damping
        if damping.shear_time == 0.02:
            raise vr.SolveError(
                "it broke at 0.1 s", Run(run.data.isel(time=slice(0, 100)).assign_attrs(outcome="slow"))
            )
        if damping.shear_time == 0.03:
            raise vr.InputError("not like this")
        if damping.shear_time == 0.04:
            raise ZeroDivisionError("a defect")
        return run

    monkeypatch.setattr(member_work, "run_case", fails_in_the_middle)
    fresh = vr.sweep(case, {SHEAR: [0.01, 0.02, 0.03, 0.04, 0.05]}, workers=1)
    for sweep in (fresh, vr.load(fresh.save(tmp_path / "sweep.nc"))):
        assert [m.outcome for m in sweep.members] == ["completed", "slow", "refused", "failed", "completed"]
        assert sweep.data["member"].values.tolist() == [0, 4]
        assert sweep.data[SHEAR].values.tolist() == [0.01, 0.05]
        assert sweep.members[1].result.time.size == 100
        assert sweep.members[2].result is None
        assert sweep.report() == fresh.report()
    for words in (
        "5 members, 2 completed",
        "member 1: it broke at 0.1 s",
        "member 3: ZeroDivisionError: a defect",
    ):
        assert words in flat(fresh.report())
    for member, other in zip(fresh.members, sweep.members, strict=True):
        assert (other.result is None) == (member.result is None)
        if member.result is not None:
            assert other.result.data.identical(member.result.data)


@pytest.mark.slow
def test_a_member_that_no_mesh_fits_fails_in_its_process(case):
    text = SWING.replace('at = "beam.start"', 'at = "beam@0.1"').replace("elements = 1", "elements = 2")
    case.write_text(text)
    sweep = vr.sweep(case, {"rods.beam.elements": [1, 2]}, workers=2)
    assert [member.outcome for member in sweep.members] == ["refused", "completed"]
    assert "give at least 2" in sweep.members[0].message


WRONG = [
    (
        {"rods.beam.elments": [1, 2]},
        "rods.beam.elments: 1: no such key; did you mean elements? The keys here are shape",
    ),
    ({"rods.bean.elements": [1]}, "rods.bean: no such key; did you mean beam? The keys here are beam"),
    ({"materials.gum": [1]}, "materials.gum: no such key; the keys here are rubber"),
    ({"rod.beam.elements": [1]}, "rod: no such key; did you mean rods? The keys here are title, materials"),
    ({"rods.beam.elements": [1, 0]}, "rods.beam.elements: 0: a whole number is needed here"),
    (
        {"rods.beam.section": ["thin", "thik"]},
        "there is no section of this name (member 1); did you mean 'thin'?",
    ),
    (
        {"loads[1].value": [[0, 0, 1]]},
        "loads[1]: a list of 1: there is no such entry; give a number from 0 to 0",
    ),
    ({"loads.value": [[0, 0, 1]]}, "this has no keys of its own; name an entry, the first is [0]"),
    ({"rods.beam.elements.more": [1]}, "rods.beam.elements.more: 1: this has no keys of its own"),
    ({"rods..elements": [1]}, "this is not a key of a case file"),
    ({"rods.beam.elements": 3}, "a list of values is needed here"),
    ({"rods.beam.elements": [1, 2], SHEAR: [0.1]}, "vary together; give every key one value per member"),
    ([{SHEAR: 0.1}, {"rods.beam.elements": 1}], "give all members the same keys"),
    ({}, "there is nothing to vary"),
]


@pytest.mark.parametrize(("values", "words"), WRONG)
def test_wrong_keys_and_values_are_refused_before_anything_runs(case, values, words, monkeypatch):
    monkeypatch.setattr(member_work, "run_case", lambda *_, **__: pytest.fail("computed"))
    given = copy.deepcopy(values)
    with pytest.raises(vr.InputError) as caught:
        vr.sweep(case, values, workers=1)
    assert words in str(caught.value)
    assert len(caught.value.problems) == 1
    assert values == given


def test_processes_look_at_values_as_one_process_does(case, tmp_path):
    """Values far down the table are looked at by the processes: what is refused, and of which members, is the same."""
    heights = [0.01] * 30 + [-0.01, -0.02] + [0.01] * 120 + [-0.03]
    values = {"sections.thin.height": heights, "rods.beam.elements": [1] * 100 + [0] + [1] * 52}
    told = []
    for workers in (1, 2):
        with pytest.raises(vr.InputError) as caught:
            vr.sweep(case, values, workers=workers, folder=tmp_path / str(workers))
        told.append(str(caught.value))
        assert not (tmp_path / str(workers)).exists()
    assert told[0] == told[1]
    assert "member 30 and 2 more" in told[0]
    assert "member 100" in told[0]


def test_a_member_that_is_left_over_does_not_run_in_the_process_that_asks(case, tmp_path, monkeypatch):
    """It may be the one that killed its processes, and would take that of the user with it."""
    given = {
        "quantities": {"tip": ("displacement", "beam.end", "y", "last")},
        "folder": tmp_path,
        "errors": 0,
    }
    vr.sweep(case, {SHEAR: [0.01, 0.02]}, workers=1, members=slice(0, 1), **given)
    monkeypatch.setattr("viscorod.analyses.sweep._alone", lambda *_: pytest.fail("computed here"))
    assert vr.sweep(case, {SHEAR: [0.01, 0.02]}, workers=2, **given).count_completed == 2


def test_wrong_number_of_workers(case):
    with pytest.raises(vr.InputError, match="workers: 0: a whole number of at least 1"):
        vr.sweep(case, {SHEAR: [0.1]}, workers=0)


@IN_ONE_AND_TWO
def test_interruption_keeps_what_there_is(case, workers):
    case.write_text(SWING.replace("duration = 0.2", "duration = 2000.0"))

    def interrupt(done):
        if done > 0.0:
            os.kill(os.getpid(), signal.SIGINT)

    handler = signal.getsignal(signal.SIGINT)
    times = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06]
    once = iter([interrupt])
    with pytest.raises(vr.SolveError, match="0 of 6 members are done") as caught:
        vr.sweep(
            case, {SHEAR: times}, workers=workers, progress=lambda d: d > 0 and next(once, lambda _: None)(d)
        )
    sweep = caught.value.run
    # of two processes the first may have been given its member and not have begun it
    begun = [member for member in sweep.members if member.result is not None]
    assert 1 <= len(begun) <= workers
    assert {member.outcome for member in begun} == {"interrupted"}
    assert all(member.result.time.size >= 1 for member in begun)
    assert sweep.members[-1].outcome == "not run"
    assert signal.getsignal(signal.SIGINT) is handler


@pytest.mark.skipif(not process_start.COPIED, reason="processes start by themselves there")
def test_ctrl_c_is_nothing_to_processes_that_load():
    """A terminal sends it to all; the client alone answers, and the process that workers are copies of ends with it."""
    code = (  # where tests run in the background Ctrl-C is ignored, which processes inherit
        "import signal, time; signal.signal(signal.SIGINT, signal.default_int_handler);"
        "from viscorod.analyses.sweeps.process_start import prepare; prepare();"
        "print('begun', flush=True); time.sleep(60)"
    )
    client = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert client.stdout.readline() == "begun\n"
    time.sleep(0.3)
    os.killpg(client.pid, signal.SIGINT)
    told = client.communicate(timeout=120)[1]  # until the last process that writes there has ended
    assert told.count("Traceback") == 1  # the client's own
    assert told.endswith("KeyboardInterrupt\n")


@pytest.mark.slow
def test_a_process_that_is_killed_costs_nothing(case):
    """As where memory runs out: the system kills one process of a sweep that runs."""
    killed = []

    def kill_once(done):
        if done > 0.0 and not killed:
            killed.append(multiprocessing.active_children()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    sweep = vr.sweep(case, {SHEAR: [0.01, 0.02, 0.03]}, workers=2, progress=kill_once)
    assert killed
    assert [member.outcome for member in sweep.members] == ["completed"] * 3


def test_command_line(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments = ["sweep", str(case), "--set", f"{SHEAR}=0.01, 0.02", "--workers", "1"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "A swing: 2 members, 2 completed" in result.stdout
    assert "2 of 2 members" in result.stderr
    assert vr.load(tmp_path / "out" / "swing" / "sweep.nc").data[SHEAR].values.tolist() == [0.01, 0.02]
    for wrong in ("rods.beam.elements", "rods.beam.elements=", "rods.beam.section=thin"):
        refused = CliRunner().invoke(app, ["sweep", str(case), "--set", wrong])
        assert refused.exit_code == 2
        assert "give a key and values as in a case file" in refused.stderr
    unknown = CliRunner().invoke(app, ["sweep", str(case), "--set", "rods.beam.lenght=1"])
    assert unknown.exit_code == 2
    assert "no such key" in unknown.stderr


BENT = SWING.split("[[loads]]", maxsplit=1)[0]
SMALL = {
    "modes": BENT + "[modes]\ncount = 2\n",
    "response": BENT
    + '[response]\ninputs = ["beam.end fz"]\noutputs = ["beam.end uz"]\nfrequencies = [0.5, 1.0, 2.0]\n',
}


@pytest.mark.parametrize("kind", list(SMALL))
def test_modes_and_responses_are_swept(kind, tmp_path):
    """Each member is the single analysis; figures are in data and table, and a file gives all back."""
    case = case_from_dict(tomllib.loads(SMALL[kind]))
    swept = vr.sweep(case, {"rods.beam.end[0]": [0.2, 0.3], SHEAR: [0.01, 0.02]}, workers=1)
    assert [member.outcome for member in swept.members] == ["completed"] * 2
    alone = run_case(case)
    last = swept.members[1].result
    quantity = {"modes": "eigenvalues", "response": "values"}[kind]
    np.testing.assert_array_equal(getattr(last, quantity), getattr(alone, quantity))
    assert "first frequency [Hz]" in flat(swept.report())
    # the error by the mesh is the difference to twice as many elements
    errs = swept.members[1].figures()["frequency_error"]
    assert "mesh error" in flat(swept.report())
    if kind == "modes":
        finer = tomllib.loads(SMALL[kind])
        finer["rods"]["beam"]["elements"] *= 2
        better = run_case(case_from_dict(finer)).frequencies
        assert errs == pytest.approx(np.max(np.abs(alone.frequencies - better) / better), rel=1e-6)
    # a beam of 0.2 m instead of 0.3 m: (3/2)^2 (closed form of Euler and Bernoulli; shear takes a little)
    first = swept.data["first_frequency"].values
    assert first[0] / first[1] == pytest.approx(2.25, rel=5e-3)
    loaded = vr.load(swept.save(tmp_path / "sweep.nc"))
    assert loaded.report() == swept.report()
    found = loaded.members[0].result
    assert type(found) is type(alone)
    np.testing.assert_array_equal(getattr(found, quantity), getattr(swept.members[0].result, quantity))
    if kind == "response":
        peak, at = (float(swept.data[name][1]) for name in ("peak", "peak_frequency"))
        assert 0.5 < at < 1.0
        there = tomllib.loads(SMALL[kind])
        there["response"]["frequencies"] = [at]  # solved there, without poles
        assert peak == pytest.approx(run_case(case_from_dict(there)).amplification()[0], rel=1e-3)
        assert peak > 3.0 * alone.amplification().max()


def test_no_damping_is_no_minus_zero():
    """The damping ratio of what is not damped reads 0 in tables."""
    case = case_from_dict(tomllib.loads(SMALL["modes"]))
    content = {**case.content, "materials": {"rubber": {**case.content["materials"]["rubber"]}}}
    del content["materials"]["rubber"]["damping"]
    swept = vr.sweep(case_from_dict(content), {"rods.beam.end[0]": [0.2]}, workers=1)
    ratio = swept.table().loc[0, "first_damping_ratio"]
    assert ratio == 0.0
    assert math.copysign(1.0, ratio) == 1.0
    assert " -0 " not in swept.report()


@pytest.mark.slow
def test_processes_see_the_environment_of_now(case, monkeypatch):
    """Processes may be copies of one that started with an earlier sweep: what changed since then reaches them."""
    tips = []
    for told in (3.0, 4.0):
        monkeypatch.setenv("TOLD_TO_WORKERS", str(told))
        given = {"tip": ("displacement", "beam.end", "y", "last"), "told": as_the_environment_says}
        table = vr.sweep(case, {SHEAR: [0.01, 0.02, 0.03]}, quantities=given, workers=2).table()
        assert table["told"].tolist() == [told] * 3
        tips.append(table["tip"].tolist())
    alone = vr.sweep(case, {SHEAR: [0.01, 0.02, 0.03]}, quantities=given, workers=1).table()
    assert tips[0] == tips[1] == alone["tip"].tolist()


def test_members_of_whom_the_same_is_told_share_a_line():
    told = dict.fromkeys([*range(3, 9), 11, 13, 14], "stopped") | {20: "broke"}
    assert told_members(told, 5) == ["9 members (3 to 8, 11, 13, 14): stopped", "member 20: broke"]
    assert told_members(told, 1) == [
        "9 members (3 to 8, 11, 13, 14): stopped",
        "and 1 more message in the table",
    ]
    assert told_members(dict.fromkeys(range(0, 40, 2), "slow"), 5) == [
        "20 members (0, 2, 4, 6, 8, 10, 12, 14, ...): slow"
    ]
    assert told_members({}, 5) == []


def test_what_is_said_of_members_with_other_numbers_is_one_line_with_ranges():
    warned = "warning: bend 2 is off by {} % at beam@0.5; use more; warning: loads[1] is large"
    told = {k: warned.format(size) for k, size in enumerate(("22", "5.1", "9e-1"))}
    told[3] = "warning: bend 1 is off by 7 % at beam@0.5; use more"
    assert told_members(told, 5) == [
        "3 members (0 to 2): warning: bend 2 is off by 9e-1 to 22 % at beam@0.5; use more",
        "3 members (0 to 2): warning: loads[1] is large",
        "member 3: warning: bend 1 is off by 7 % at beam@0.5; use more",
    ]
    assert told_members(told, 1)[1:] == ["and 2 more messages in the table"]
