"""Sweeps that cannot go on, or not with every member: what is finished stays, and one message says what to do."""

import json
import os
import resource
import subprocess
import sys
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from itertools import count
from threading import Lock

import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.plain_text import flat
from helpers.quantities import ends_its_process
from helpers.strip import content
from viscorod.analyses.sweeps import member_work
from viscorod.analyses.sweeps.executors import opened
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.toml_text import toml_text
from viscorod.cli.app import app
from viscorod.results.files.sweep_folder import SweepFolder

FORCE = "loads[0].value[1]"
TIP = {"tip": ("displacement", "beam.end", "y")}
FORCES = [1e-5 * k for k in range(1, 41)]


@pytest.fixture
def held():
    return case_from_dict(content("equilibrium"))


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "strip.toml").write_text(toml_text(content("equilibrium")))
    return ["sweep", "strip.toml", "--grid"]


def records(folder):
    """The records of all members on disk, by their names; the last of each. A line that was cut off has no end."""
    lines = [
        line for path in (folder / "members").glob("*.jsonl") for line in path.read_text().splitlines(True)
    ]
    return {record["name"]: record for line in lines if line.endswith("}\n") and (record := json.loads(line))}


@pytest.mark.parametrize("how", ["alone", "threads", "other"])
def test_a_full_disk_stops_a_sweep(held, tmp_path, monkeypatch, how):
    """Of 40 members ten find room: the others are not computed for nothing, and the next call computes 30."""
    asked, one_at_a_time, add = count(), Lock(), SweepFolder.add

    def until_full(self, *given):
        with one_at_a_time:
            full = next(asked) >= 10
        if full:
            raise OSError(28, "No space left on device")
        return add(self, *given)

    given = {"quantities": TIP, "errors": 0, "folder": tmp_path / "sweep"}
    ways = {"alone": {"workers": 1}, "threads": {"executor": "threads:2"}, "other": {"executor": Here()}}
    with monkeypatch.context() as patch:
        patch.setattr(SweepFolder, "add", until_full)
        with pytest.raises(vr.SolveError) as caught:
            vr.sweep(held, {FORCE: FORCES}, **ways[how], **given)
    text = str(caught.value)
    assert f"it cannot be kept in {tmp_path / 'sweep'} (No space left on device; " in text
    assert "put that right and call again; 10 of 40 members are done" in text
    stopped = caught.value.run
    outcomes = stopped.table()["outcome"].tolist()
    assert outcomes.count("completed") == 10
    assert set(outcomes) <= {"completed", "interrupted", "not run", "not kept"}
    assert 1 <= outcomes.count("not kept") <= 4
    lost = stopped.members.found.first_of("not kept")
    alone = vr.sweep(held, {FORCE: FORCES}, quantities=TIP, workers=1, errors=0).table()
    assert stopped.members[lost].quantities["tip"] == alone["tip"][lost]  # it was computed
    assert len(records(tmp_path / "sweep")) == 10
    assert vr.load(tmp_path / "sweep").count_completed == 10
    again = vr.sweep(held, {FORCE: FORCES}, workers=1, **given).table()
    assert again["tip"].tolist() == alone["tip"].tolist()
    assert len(records(tmp_path / "sweep")) == 40


class Here(Executor):
    """Computes at once what other executors hand to two workers."""

    _max_workers = 2

    def submit(self, work, *given):
        future = Future()
        future.set_result(work(*given))
        return future


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_limit_of_the_system_stops_the_command(case, tmp_path, workers):
    """Files may have 5 kB: one message, exit code 1, no table of half a sweep; without the limit it goes on."""
    command = [
        *case,
        f"{FORCE}=1e-5:4e-4:40",
        "--quantity",
        "tip=displacement beam.end y",
        "--workers",
        str(workers),
    ]
    script = f"import sys; from viscorod.cli.app import main; sys.argv = ['viscorod', *{command!r}]; main()"

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))

    found = subprocess.run(
        [sys.executable, "-B", "-c", script],  # byte code that is cut off would be read by others
        preexec_fn=limited,
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 1, found.stdout + found.stderr
    assert found.stderr.count("error: ") == 1
    assert "cannot be kept" in found.stderr
    assert "File too large" in found.stderr
    assert "Traceback" not in found.stderr
    folder = tmp_path / "out" / "strip"
    assert not (folder / "sweep.csv").exists()
    kept = len(records(folder / "sweep"))
    assert 5 < kept < 40
    again = CliRunner().invoke(app, command)
    assert again.exit_code == 0, again.output
    assert "40 members, 40 completed" in again.stdout
    assert len(records(folder / "sweep")) == 40


@pytest.mark.slow
def test_a_member_that_killed_its_workers_is_tried_again_when_that_is_asked(held, tmp_path, monkeypatch):
    """It is on disk like every other that failed; with ``retry`` it has another chance, and is completed then."""
    deaths = tmp_path / "deaths"
    monkeypatch.setenv("ENDS_WHILE", str(deaths))
    deaths.write_text("x")
    values, quantities = {FORCE: [1e-4, 2e-4, 3e-4]}, TIP | {"mine": ends_its_process}
    given = {"quantities": quantities, "folder": tmp_path / "sweep", "errors": 0}
    first = vr.sweep(held, values, workers=2, **given).table()
    assert first["outcome"].tolist() == ["completed", "failed", "completed"]
    assert first["message"][1] == "its process ended with exit code 9; it was tried 3 times"
    assert len(deaths.read_text()) == 4
    for again in (vr.sweep(held, values, workers=2, **given), vr.load(tmp_path / "sweep")):
        assert again.table()["outcome"].tolist() == first["outcome"].tolist()
        assert again.table()["message"].tolist() == first["message"].tolist()
    assert len(deaths.read_text()) == 4
    deaths.unlink()
    for found in (vr.sweep(held, values, workers=2, retry=True, **given), vr.load(tmp_path / "sweep")):
        assert found.table()["outcome"].tolist() == ["completed"] * 3
        assert found.table()["message"].tolist() == [""] * 3


class Losing(Executor):
    """Loses every task."""

    _max_workers = 1

    def submit(self, *_):
        future = Future()
        future.set_exception(OSError("no heartbeat"))
        return future


def test_members_whose_worker_was_lost_are_on_disk(held, tmp_path):
    given = {"quantities": TIP, "folder": tmp_path, "errors": 0}
    lost = vr.sweep(held, {FORCE: [1e-4, 2e-4]}, executor=Losing(), **given).table()
    assert set(lost["message"]) == {"its worker was lost 3 times (OSError: no heartbeat)"}
    with ThreadPoolExecutor(1) as threads:
        kept = vr.sweep(held, {FORCE: [1e-4, 2e-4]}, executor=threads, **given).table()
        assert kept["outcome"].tolist() == ["failed", "failed"]
        done = vr.sweep(held, {FORCE: [1e-4, 2e-4]}, executor=threads, retry=True, **given).table()
    assert done["outcome"].tolist() == ["completed", "completed"]


def test_of_members_that_failed_again_the_last_word_counts(held, tmp_path, monkeypatch):
    """A writer that was begun later has the newer lines, whatever it is called."""
    given = {"quantities": TIP, "folder": tmp_path, "workers": 1}
    for number in (1, 2):

        def broken(*_, number=number, **__):
            raise vr.SolveError(f"trial {number}")

        monkeypatch.setattr(member_work, "run_case", broken)
        monkeypatch.setattr("viscorod.results.files.sweep_folder._writer_name", lambda n=number: f"{9 - n}")
        vr.sweep(held, {FORCE: [1e-4]}, retry=number > 1, **given)
    assert vr.load(tmp_path).table()["message"].tolist() == ["trial 2"]
    assert len(list((tmp_path / "members").glob("*.jsonl"))) == 2


def test_retry_without_a_folder_is_refused(held):
    with pytest.raises(vr.InputError, match="there is no folder with members that failed"):
        vr.sweep(held, {FORCE: [1e-4]}, quantities=TIP, retry=True)


@pytest.mark.parametrize(
    "wrong",
    [
        ["--executor", "fork"],
        ["--executor", "processes:0"],
        ["--executor", "threads:2", "--workers", "2"],
        ["--scheduler", "tcp://127.0.0.1:1"],
        ["--executor", "dask:tcp://127.0.0.1:1"],
        ["--members", "90:95"],
        ["--quantity", "tip=sideways beam.end y"],
        ["--quantity", "tip=displacement rod.end y"],
        ["--set", "rods.beam.lenght=1"],
        ["--set", "sections.thin.width=-1"],
    ],
)
def test_what_is_refused_replaces_nothing_and_does_not_say_so(case, tmp_path, monkeypatch, wrong):
    monkeypatch.setattr("viscorod.analyses.sweeps.executors.PATIENCE", 0.3)
    first = [*case, f"{FORCE}=1e-5:3e-5:3", "--workers", "1"]
    assert CliRunner().invoke(app, first).exit_code == 0
    folder = tmp_path / "out" / "strip"
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    refused = CliRunner().invoke(app, [*case, f"{FORCE}=1e-5:4e-5:3", *wrong])
    assert refused.exit_code == 2, refused.output
    assert "replaced" not in refused.stderr
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    again = CliRunner().invoke(app, first)
    assert again.exit_code == 0
    assert f"{folder.relative_to(tmp_path) / 'sweep.nc'} of " in flat(again.stderr)
    assert "is replaced when this is done; name another folder" in flat(again.stderr)


def test_an_executor_of_threads_is_opened_and_shut_down():
    with opened("threads:2") as pool:
        assert pool.submit(abs, -2).result() == 2
    with pytest.raises(RuntimeError):
        pool.submit(abs, -2)
