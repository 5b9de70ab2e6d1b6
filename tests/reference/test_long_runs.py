"""Runs that are killed, stopped, resumed and watched: results are those of one run, memory stays bounded."""

from __future__ import annotations

import functools
import itertools
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.plain_text import flat
from viscorod.analyses.case_run import as_model
from viscorod.casefile.shipped import shipped_case
from viscorod.cli import run_commands
from viscorod.cli.app import app
from viscorod.cli.polite_stop import polite_stop
from viscorod.results.files import checkpoint_file, storage, stored_journal
from viscorod.results.files import stream as streaming
from viscorod.results.files.journal import Journal
from viscorod.results.files.journal_folder import FOLDER
from viscorod.results.files.stored_journal import checkpoint, contents
from viscorod.solve.transient import many_steps, transient_solver

from .cases import cantilever


def swing(**more):
    C, _, M = vr.Rectangle(0.01, 0.01).matrices(vr.Material(1e6, poissons_ratio=0.3, density=1000.0))
    section = vr.StiffnessSection(C, M, **({"damping": 0.02 * C} | more))
    model = cantilever(section, 0.3, elements=2, order=4)
    model.force("beam.end", (0, 0.035, 0.01), until=0.0)
    return model


def maxwell():
    C, _, _ = vr.Rectangle(0.01, 0.01).matrices(vr.Material(1e6, poissons_ratio=0.3, density=1000.0))
    return swing(branches=[vr.MaxwellBranch(time=0.1, stiffness=C)])


def shipped(name, **more):
    case = vr.load_case(shipped_case(name))
    given = {key: getattr(case.settings, key) for key in case.settings.model_fields_set}
    return as_model(case.description), given | more


RUNS = {
    "radau": lambda: (swing(), {"duration": 0.8}),
    "loads that jump": lambda: (pushed(), {"duration": 0.3, "output_interval": 0.01}),
    "midpoint": lambda: (swing(), {"duration": 0.16, "integrator": "midpoint", "time_step": 0.01}),
    "generalised-alpha": lambda: (
        swing(),
        {"duration": 0.09, "integrator": "generalized_alpha", "time_step": 0.003},
    ),
    "intrinsic": lambda: (swing(), {"duration": 0.4, "formulation": "intrinsic"}),
    "Maxwell": lambda: (maxwell(), {"duration": 0.3}),
    "joints": lambda: shipped("four_bar", duration=0.15),
    "drag": lambda: (in_water(), {"duration": 0.15}),
}


def in_water():
    model = swing()
    flow = {"density": 1000.0, "width": 0.01, "velocity": (0, 0, 0.05)}
    model.drag("beam", coefficient_across=1.2, linear_along=0.1, time=vr.Ramp(0.05, 0.1), **flow)
    return model


def pushed():
    model = swing()
    model.force("beam.end", (0, 0, 0.02), time=vr.TimeTable([0, 0.1, 0.1, 0.2, 0.2, 0.4], [0, 0, 1, 1, 0, 0]))
    return model


@functools.cache
def whole(name):
    """The run that is neither written nor stopped."""
    model, given = RUNS[name]()
    return model.simulate(**given)


def difference(found, expected):
    """Largest difference of any variable over its size; names, times and counts have to be the same."""
    assert set(found.data.variables) == set(expected.data.variables)
    worst = 0.0
    for name, variable in expected.data.variables.items():
        a, b = variable.values, found.data[name].values
        assert a.shape == b.shape, name
        if a.dtype.kind == "f":
            worst = max(worst, float(np.abs(a - b).max(initial=0.0)) / (np.abs(a).max(initial=0.0) or 1.0))
        else:
            assert (a == b).all(), name
    for name in ("steps", "iterations", "rejected", "outcome", "events"):
        assert found.data.attrs.get(name) == expected.data.attrs.get(name), name
    return worst


def after(steps):
    """A reason to stop after so many steps."""
    count = itertools.count(1)
    return lambda: "enough" if next(count) >= steps else ""


@pytest.fixture
def eager(monkeypatch):
    """Write and make checkpoints as often as possible, few steps at once, without waiting for the disk."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)
    monkeypatch.setattr(streaming, "SHARE", 1.0)
    monkeypatch.setattr(streaming, "FLUSH", 0.0)
    monkeypatch.setattr(streaming, "CHECKPOINT", 0.0)
    for module in (many_steps, transient_solver):
        monkeypatch.setattr(module, "MOST_STEPS", 4)


# --- what is written as it comes


@pytest.mark.parametrize("name", RUNS)
def test_a_written_run_is_the_run(tmp_path, eager, name):
    """Identity: what went to disk piece by piece is what stays in memory, bit for bit."""
    model, given = RUNS[name]()
    expected = whole(name)
    found = model.simulate(**given, folder=tmp_path)
    assert difference(found, expected) == 0.0
    assert difference(vr.load(tmp_path / "run.nc"), expected) == 0.0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.nc"]
    for key, value in expected.data.variables.items():
        assert found.data[key].attrs == value.attrs
        assert found.data[key].dims == value.dims


@pytest.mark.parametrize("name", RUNS)
def test_a_stopped_run_goes_on(tmp_path, eager, name):
    """Identity, stopped after the first step, and twice on the way."""
    model, given = RUNS[name]()
    expected = whole(name)
    third = int(expected.data.attrs["steps"]) // 3
    for number, stop in enumerate((1, third, third)):
        with pytest.raises(vr.SolveError, match="enough") as error:
            model.simulate(**given, folder=tmp_path, resume=number > 0, stop=after(stop))
        assert error.value.run.outcome == "interrupted"
        assert (tmp_path / "run.nc").is_file()
    assert difference(model.simulate(**given, folder=tmp_path, resume=True), expected) == 0.0
    assert not (tmp_path / FOLDER).exists()


def has_checkpoint(folder):
    """Return whether a run has one: how many steps come before the first depends on how fast the disk is."""
    try:
        checkpoint(folder)
    except vr.InputError:
        return False
    return True


def _child(model, given, folder, step, last, delay):
    """Be killed some time after a step: in the next ones, or while something is written; before the end."""
    steps, killers = itertools.count(1), []

    def progress(t, h):
        number = next(steps)
        if not killers and (number == last or (number >= step and has_checkpoint(folder / FOLDER))):
            killers.append(threading.Timer(delay, os.kill, (os.getpid(), signal.SIGKILL)))
            killers[0].start()
        if number == last:
            signal.pause()
        time.sleep(0.002)

    model.simulate(**given, folder=folder, progress=progress)


@pytest.mark.skipif(sys.platform == "win32", reason="no fork")
def test_killed_at_random_moments(tmp_path, eager):
    """Identity to 1e-12 (bit for bit here): killed without warning wherever it is, then resumed."""
    fork = multiprocessing.get_context("fork")
    rng = np.random.default_rng(5)
    names, resumed = ("radau", "midpoint", "Maxwell", "joints"), []
    for number, name in enumerate(names):
        model, given = RUNS[name]()
        folder, last = tmp_path / str(number), int(whole(name).data.attrs["steps"])
        step = int(rng.integers(2, last))
        child = fork.Process(target=_child, args=(model, given, folder, step, last, rng.uniform(0.0, 0.02)))
        child.start()
        child.join()
        assert child.exitcode == -signal.SIGKILL
        until = contents(folder / FOLDER).sizes["time"]  # whole records, however it ended
        if not has_checkpoint(folder / FOLDER):  # a disk so slow that the run ended before the first
            continue
        resumed.append(name)
        assert until >= checkpoint(folder / FOLDER)[1]
        assert difference(model.simulate(**given, folder=folder, resume=True), whole(name)) <= 1e-12
    assert resumed


def test_half_a_record_is_not_read(tmp_path, eager):
    """A full disk leaves a part of a record: what is complete is read, and the run goes on from its checkpoint."""
    model, given = RUNS["radau"]()
    with pytest.raises(vr.SolveError):
        model.simulate(**given, folder=tmp_path, stop=lambda: "enough")
    states = tmp_path / FOLDER / "states.bin"
    complete = contents(tmp_path / FOLDER).sizes["time"]
    with states.open("ab") as file:
        file.write(b"\1" * 100)
    assert contents(tmp_path / FOLDER).sizes["time"] == complete
    assert difference(model.simulate(**given, folder=tmp_path, resume=True), whole("radau")) == 0.0


def test_full_disk_keeps_what_there_is(tmp_path, eager, monkeypatch):
    """What was written before the disk was full can be read."""
    model, given = RUNS["generalised-alpha"]()
    append, calls = Journal.append, iter(range(5))

    def failing(self, data):
        if next(calls, None) is None:
            raise OSError(28, "No space left on device")
        append(self, data)

    monkeypatch.setattr(Journal, "append", failing)
    with pytest.raises(vr.InputError, match=r"No space left on device.*viscorod resume"):
        model.simulate(**given, folder=tmp_path)
    monkeypatch.undo()
    assert contents(tmp_path / FOLDER).sizes["time"] > 4
    assert (
        difference(model.simulate(**given, folder=tmp_path, resume=True), whole("generalised-alpha")) == 0.0
    )


def test_another_model_is_refused(tmp_path, eager):
    model, given = RUNS["radau"]()
    with pytest.raises(vr.SolveError):
        model.simulate(**given, folder=tmp_path, stop=lambda: "enough")
    other = swing()
    other.gravity()
    with pytest.raises(vr.InputError, match=r"(?s)not the same.*gravity"):
        other.simulate(**given, folder=tmp_path, resume=True)
    with pytest.raises(vr.InputError, match=r"(?s)not the same.*duration"):
        model.simulate(**given | {"duration": 4.0}, folder=tmp_path, resume=True)
    with pytest.raises(vr.InputError, match="give the folder"):
        model.simulate(**given, resume=True)
    with pytest.raises(vr.InputError, match="holds no"):
        model.simulate(**given, folder=tmp_path / "elsewhere", resume=True)


def test_a_run_stopped_by_another_version_is_refused(tmp_path, eager, monkeypatch):
    """Contract: a saved state that this version would misread is not resumed."""
    with pytest.raises(vr.SolveError):
        swing().simulate(1.0, folder=tmp_path, stop=lambda: "enough")
    monkeypatch.setattr(checkpoint_file, "EDITION", checkpoint_file.EDITION + 1)
    with pytest.raises(vr.InputError, match="stopped by another version"):
        swing().simulate(1.0, folder=tmp_path, resume=True)


def test_memory_does_not_grow_with_the_run(tmp_path, monkeypatch):
    """A run six times as long keeps no more in memory (Python's own allocations, arrays included)."""
    monkeypatch.setattr(stored_journal, "CHUNK", 1e5)  # files larger than these are copied and read in pieces
    monkeypatch.setattr(storage, "LARGE", 1e5)
    monkeypatch.setattr(streaming, "MANY", 64)  # states kept in memory
    monkeypatch.setattr(streaming, "MOST", 25)
    clock = itertools.count(0.0, 0.002)  # writes are due after the same states however fast the machine is
    monkeypatch.setattr(streaming, "time", SimpleNamespace(monotonic=lambda: next(clock)))

    def peak(duration, folder):
        model = swing()
        model.simulate(0.05, folder=tmp_path / f"{folder}-first", integrator="midpoint", time_step=0.01)
        tracemalloc.start()
        model.simulate(duration, folder=tmp_path / folder, integrator="midpoint", time_step=0.01)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    short, long = peak(0.5, "short"), peak(3.0, "long")
    assert long < 1.6 * short
    assert vr.load(tmp_path / "long" / "run.nc").time.size > 300


# --- events


def test_crossings_are_found_between_steps():
    """Closed form: a free rod falls from rest through -g t^2/2."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Circle(0.01), material=vr.Material(1e6, 0.3, 1000.0)
    )
    model.add("rod", rod)
    model.gravity((0, 0, -9.81))
    events = [
        vr.Crossing("rod.end", "uz", -0.5, stop=False),
        vr.Crossing("rod@0.1", "vz", -5.0, direction="falling", stop=False),
        vr.Crossing("rod.end", "vz", -6.0, direction="rising", stop=False),
        vr.Crossing("rod.start", "z", -2.0),
    ]
    run = model.simulate(3.0, initial="reference", events=events)
    found = {event["event"]: event["time"] for event in json.loads(run.data.attrs["events"])}
    times = [np.sqrt(2 * 0.5 / 9.81), 5.0 / 9.81, np.sqrt(2 * 2.0 / 9.81)]
    assert list(found.values()) == pytest.approx(sorted(times), rel=1e-7)
    assert len(found) == 3  # nothing rises
    assert run.time[-1] == pytest.approx(times[2], rel=1e-7)
    assert run.data.position[-1, 0, 2] == pytest.approx(-2.0, abs=1e-9)
    assert "z of rod.start" in run.data.attrs["ended_by"]
    assert run.outcome == "completed"
    assert "ended the run" in flat(run.report())


def test_a_decayed_motion_ends_the_run():
    """Closed form: the amplitude falls as exp(-zeta omega t) of the first mode once others are gone."""
    model = swing()
    omega = model.modes(1, about="reference").eigenvalues[0]
    run = model.simulate(200.0, events=[vr.Decayed(0.01)])
    tip = run.history("beam.end", "displacement").sel(axis="y").values
    start, last = np.abs(tip).max(), np.abs(tip[run.time > run.time[-1] - 2 * np.pi / omega.imag]).max()
    assert 0.003 * start < last < 0.03 * start
    rate = np.log(start / last) / run.time[-1]
    assert rate == pytest.approx(-omega.real, rel=0.2)


def test_a_steady_rotation_ends_the_run():
    """A damped rod that is spun up by its clamp comes to a steady shape: strains of two later instants agree."""
    model = cantilever(vr.Rectangle(0.01, 0.01), 0.3, material=vr.Material(
        1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.05, 0.05)))  # fmt: skip
    model.supports.clear()
    model.clamp("beam.start", motion={"rz": vr.SpinUp(5.0, 2.0)})
    run = model.simulate(200.0, initial="reference", events=[vr.SteadyState(1e-3)])
    assert 2.0 < run.time[-1] < 60.0
    strain = run.data.strain.values
    assert np.abs(strain[-1] - strain[-8]).max() < 1e-2 * np.abs(strain).max()
    assert np.abs(run.data.velocity.values[-1]).max() > 0.1


def test_events_of_a_case_file_and_their_errors(tmp_path):
    text = shipped_case("cantilever_swing").read_text()
    good = '\n[[simulate.events]]\nkind = "crossing"\nat = "beam.end"\nquantity = "uy"\n'
    path = tmp_path / "case.toml"
    path.write_text(text + good)
    (event,) = vr.load_case(path).settings.events
    assert event == vr.Crossing("beam.end", "uy")
    for change, words in (
        (good.replace('"uy"', '"uq"'), r"simulate.events\[0\].quantity: 'uq'"),
        (good.replace("at =", "place ="), r"simulate.events\[0\].place: .*no such key"),
        (good.replace('"crossing"', '"crosing"'), "did you mean 'crossing'"),
        (
            '\n[[simulate.events]]\nkind = "decayed"\namplitude = 2.0\n',
            r"events\[0\].amplitude: 2.*above 0 and below 1",
        ),
        ('\n[[simulate.events]]\nkind = "steady"\nduring = -1.0\n', r"events\[0\].during"),
    ):
        path.write_text(text + change)
        with pytest.raises(vr.InputError, match=words):
            vr.load_case(path)
    path.write_text(text + good.replace("beam.end", "bam.end"))
    case = vr.load_case(path)
    with pytest.raises(vr.InputError, match="did you mean 'beam'"):
        vr.Model.of(**case.description.parts()).simulate(0.1, events=case.settings.events)


# --- the commands


def test_commands_stop_and_go_on(tmp_path, monkeypatch):
    """Ctrl-C after some steps, a changed case, the case as it was: messages, and the file of one run."""

    @contextmanager
    def stopping():
        yield after(20)

    monkeypatch.chdir(tmp_path)
    case = tmp_path / "case.toml"
    text = shipped_case("cantilever_swing").read_text().replace("duration = 10.0", "duration = 2.0")
    case.write_text(text)
    invoke = CliRunner().invoke
    assert invoke(app, ["run", "case.toml", "-o", "whole"]).exit_code == 0
    with monkeypatch.context() as patched:
        patched.setattr(run_commands, "polite_stop", stopping)
        stopped = invoke(app, ["run", "case.toml", "-o", "part"])
    assert stopped.exit_code == 1
    assert "Stopped at t = " in stopped.stderr
    assert "go on with: viscorod resume part" in stopped.stderr
    assert {path.name for path in (tmp_path / "part").iterdir()} >= {"run.nc", "motion.png", FOLDER}
    case.write_text(text.replace("duration = 2.0", "duration = 3.0"))
    changed = invoke(app, ["resume", "part"])
    assert changed.exit_code == 2
    assert "-duration = 2.0" in changed.stderr
    assert "+duration = 3.0" in changed.stderr
    case.write_text(text)
    done = invoke(app, ["resume", "part"])
    assert done.exit_code == 0, done.output
    assert not (tmp_path / "part" / FOLDER).exists()
    found, expected = (vr.load(tmp_path / folder / "run.nc") for folder in ("part", "whole"))
    assert difference(found, expected) == 0.0
    for name in ("version", "platform", "case_text", "case_hash"):
        assert found.data.attrs[name] == expected.data.attrs[name]
    assert found.data.attrs["case_text"] == text
    again = invoke(app, ["resume", "part"])
    assert (again.exit_code, "is complete" in again.stderr) == (2, True)
    assert "name the folder" in invoke(app, ["resume", "nowhere"]).stderr


def test_where_no_step_is_taken_the_first_interrupt_ends_the_run(capsys):
    """An initial equilibrium has no step to finish: nobody asks there whether to stop."""
    with (
        polite_stop() as stop,
        pytest.raises(KeyboardInterrupt, match="stopped from the keyboard"),
    ):
        signal.raise_signal(signal.SIGINT)
    with polite_stop() as stop:
        assert stop() == ""
        signal.raise_signal(signal.SIGTERM)
        assert stop() == "asked to end"
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
    assert "finishing the step" in capsys.readouterr().err


def test_interrupt_ends_a_run_after_its_step(tmp_path):
    """A real signal: once ends the run in order, with what to do next; checkpoints come as soon as they may."""
    case = tmp_path / "case.toml"
    case.write_text(
        shipped_case("cantilever_swing")
        .read_text()
        .replace("duration = 10.0", "duration = 1e5\ntime_step = 0.01")
    )
    begin = (
        "from viscorod.results.files import stream; stream.CHECKPOINT = 0.0; stream.SHARE = 1.0; "
        "from viscorod.cli.app import main; main()"
    )
    command = [sys.executable, "-c", begin, "run", str(case), "-o", str(tmp_path / "out")]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    place = tmp_path / "out" / FOLDER / "checkpoint.npz"
    written = set()
    for _ in range(30_000):  # kernels may have to be compiled, on a busy machine
        if place.is_file():
            written.add(place.stat().st_mtime_ns)
        if len(written) > 1:  # the first checkpoint is written before the run listens
            break
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=600)
    assert process.returncode == 1
    assert "finishing the step" in errors
    assert f"go on with: viscorod resume {tmp_path / 'out'}" in errors
    assert vr.load(tmp_path / "out" / "run.nc").outcome == "interrupted"
