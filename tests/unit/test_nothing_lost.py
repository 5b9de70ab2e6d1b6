"""What viscorod promises about data: two writers, damaged journals, full disks, interrupts; see docs/explanation."""

import contextlib
import errno
import itertools
import json
import os
import random
import resource
import shutil
import signal
import stat
import subprocess
import sys
import threading
import time
import tracemalloc
import warnings
from pathlib import Path

import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers import stopped_runs as runs
from helpers.plain_text import flat
from viscorod.casefile.shipped import shipped_case
from viscorod.cli.app import app
from viscorod.pictures.viewer import view
from viscorod.results.files import csv_text, folder_lock
from viscorod.results.files import stream as streaming
from viscorod.results.files.journal import Journal
from viscorod.results.files.journal_folder import FOLDER, empty, holds_run
from viscorod.results.files.paraview import write_paraview
from viscorod.results.files.sealed_file import mend_twins, read_sealed, read_twins
from viscorod.results.files.stored_journal import contents, damaged, last_checkpoint, mended
from viscorod.results.run import Run

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="no fork, no limits on files"),
]


@pytest.fixture(autouse=True, scope="module")
def eager():
    """Write and make checkpoints as often as possible.

    Nobody waits for the disk, since no machine loses its power here; tests that watch what is told to it do so.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda handle: None)
        patch.setattr(streaming, "SHARE", 1.0)
        patch.setattr(streaming, "FLUSH", 0.0)
        patch.setattr(streaming, "CHECKPOINT", 0.0)
        yield


@pytest.fixture(scope="module")
def stopped_once(tmp_path_factory):
    return runs.stopped(tmp_path_factory.mktemp("stopped"))


@pytest.fixture
def journal(stopped_once, tmp_path):
    """The journal of a stopped run in a folder of its own: a copy of the one that all tests here share."""
    return Path(shutil.copytree(stopped_once, tmp_path / FOLDER))


def resumed(folder):
    """The run that went on, and what was said; None and the message if it was refused."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            run = runs.swing().simulate(**runs.GIVEN, folder=folder, resume=True)
        except vr.InputError as error:
            return None, [str(error)]
    return run, [str(warning.message) for warning in told]


# --- one writer at a time


def test_a_second_run_in_a_folder_is_refused(tmp_path):
    """Contract: of five threads of a process that write into one folder one does, and its run is the run."""
    runs.whole()
    found, waited, begin, refused = [], [], threading.Barrier(5), threading.Semaphore(0)

    def wait_for_the_others(*_):
        """Go on when four were refused: however slow the machine is, none of them comes when the run is over."""
        if not waited:
            waited.append(all(refused.acquire(timeout=600) for _ in range(4)))

    def write(number):
        begin.wait()
        try:
            run = runs.swing().simulate(**runs.GIVEN, folder=tmp_path, progress=wait_for_the_others)
            found.append(runs.differences(run))
        except vr.InputError as error:
            found.append(str(error))
            refused.release()

    threads = [threading.Thread(target=write, args=(number,)) for number in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found.count(set()) == 1
    assert sum("is in use: this process" in flat(str(one)) for one in found) == 4
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


HOLDER = """
import sys, time
from pathlib import Path
from viscorod.results.files.folder_lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(100)
"""


def test_another_process_is_named_and_its_death_frees_the_folder(tmp_path, journal):
    """Runs, resumes, commands and sweeps are refused while a process holds the folder; killed, it holds no more."""
    case = tmp_path / "case.toml"
    case.write_text(shipped_case("cantilever_swing").read_text())
    holder = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE)
    try:
        assert holder.stdout.readline() == b"held\n"
        name = f"is in use: process {holder.pid} on "
        for more in ({}, {"resume": True}, {"anew": True}):
            with pytest.raises(vr.InputError, match=name):
                runs.swing().simulate(**runs.GIVEN, folder=tmp_path, **more)
        for command in (
            ["run", str(case), "-o"],
            ["resume"],
            ["sweep", str(case), "--set", "simulate.duration=1", "-o"],
        ):
            answer = CliRunner().invoke(app, [*command, str(tmp_path)])
            assert answer.exit_code == 2, answer.output
            assert name in answer.stderr
        assert vr.load(tmp_path).time.size > 12  # reading goes on
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.communicate()
    assert (journal / "lock").is_file()  # what is left of it keeps nobody out
    assert runs.differences(runs.gone_on(tmp_path)) == set()


def test_a_file_system_without_locks_is_told(tmp_path, monkeypatch):
    def none(_file):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(folder_lock, "_lock", none)
    with pytest.warns(vr.AccuracyWarning, match="has no locks"):
        run = runs.swing().simulate(**runs.GIVEN, folder=tmp_path)
    assert runs.differences(run) == set()
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.parametrize("code", ["ENOLCK", "EOPNOTSUPP", "ENOSYS", "EINVAL"])
def test_network_folders_without_locks_are_told(tmp_path, monkeypatch, code):
    """What flock says on NFS without a lock daemon, on FUSE and on some cluster file systems."""

    def none(_handle, _how):
        raise OSError(getattr(errno, code), os.strerror(getattr(errno, code)))

    monkeypatch.setattr("fcntl.flock", none)
    with (
        pytest.warns(vr.AccuracyWarning, match="has no locks.*only one write there"),
        folder_lock.locked(tmp_path),
    ):
        pass


def test_a_disk_that_fails_is_no_file_system_without_locks(tmp_path, monkeypatch):
    def broken(_handle, _how):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr("fcntl.flock", broken)
    with (
        pytest.raises(vr.InputError, match=r"cannot be written \(Input/output error\)"),
        folder_lock.locked(tmp_path),
    ):
        pass


class Windows:
    """The module of Windows for locks, as far as it is used: a byte of a file belongs to one open file."""

    LK_NBLCK = 2

    def __init__(self):
        self.held = {}

    def locking(self, handle, how, count):
        assert (how, count) == (self.LK_NBLCK, 1)
        place = (os.fstat(handle).st_ino, os.lseek(handle, 0, os.SEEK_CUR))
        other = self.held.get(place)
        if other is not None and other != handle and _is_open(other, place[0]):
            raise PermissionError(errno.EACCES, "Permission denied")
        self.held[place] = handle


def _is_open(handle, number):
    try:
        return os.fstat(handle).st_ino == number
    except OSError:
        return False


def test_locks_of_windows(tmp_path, monkeypatch):
    """Where there is no fcntl: a byte far behind what is read is locked; closing the file frees it."""
    windows = Windows()
    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", windows)
    with folder_lock.locked(tmp_path):
        (place,) = windows.held
        assert place[1] > 1 << 20
        monkeypatch.setattr(folder_lock, "_held", {})  # as another process, which has a list of its own
        with (
            pytest.raises(vr.InputError, match=f"is in use: process {os.getpid()} on "),
            folder_lock.locked(tmp_path),
        ):
            pass
    with folder_lock.locked(tmp_path):
        pass
    assert runs.differences(runs.swing().simulate(**runs.GIVEN, folder=tmp_path)) == set()


def test_a_journal_that_is_half_removed_holds_no_run(tmp_path, journal):
    """Identity, wherever an interrupt or a kill came while it was removed: the complete run is read, or one begins."""
    whole = runs.whole().save(tmp_path / "run.nc")
    with runs.Interrupt(-1) as counted:
        empty(Path(shutil.copytree(journal, tmp_path / "count")))
    read = []
    for number in range(1, counted.count + 1, 3):
        folder = tmp_path / str(number)
        shutil.copytree(journal, folder / FOLDER)
        with runs.Interrupt(number), pytest.raises(KeyboardInterrupt):
            empty(folder / FOLDER)
        if holds_run(folder / FOLDER):  # it had not begun
            continue
        with pytest.raises(vr.InputError, match="holds no state of a run yet"):
            vr.load(folder)
        shutil.copy(whole, folder)
        assert runs.differences(vr.load(folder)) == set(), number
        with folder_lock.locked(folder):  # the next who writes there tidies up
            pass
        assert [path.name for path in folder.iterdir()] == ["run.nc"], number
        read.append(number)
    assert len(read) > 5


# --- a run that was stopped is not removed


def test_a_stopped_run_is_removed_only_by_a_word(tmp_path, journal):
    """Refused in Python and by the command, whatever the new analysis; ``anew`` keeps it until something is there."""
    before = {path.name: path.read_bytes() for path in journal.iterdir()}
    with pytest.raises(vr.InputError, match=r"holds a run that was stopped.*resume=True.*anew=True"):
        runs.swing().simulate(**runs.GIVEN, folder=tmp_path)
    for case in ("cantilever_swing", "deep_arch"):
        answer = CliRunner().invoke(app, ["run", str(shipped_case(case)), "-o", str(tmp_path)])
        assert answer.exit_code == 2
        assert "viscorod resume" in answer.stderr
        assert "--anew" in answer.stderr
    wrong = runs.swing()
    wrong.pin("beam.start")  # twice held: found only when it is computed
    with pytest.raises(vr.InputError):
        wrong.simulate(**runs.GIVEN, folder=tmp_path, anew=True)
    assert {path.name: path.read_bytes() for path in journal.iterdir() if path.name != "lock"} == before
    assert runs.differences(runs.swing().simulate(**runs.GIVEN, folder=tmp_path, anew=True)) == set()
    assert not journal.exists()
    with pytest.raises(vr.InputError, match="resume and anew"):
        runs.swing().simulate(**runs.GIVEN, folder=tmp_path, resume=True, anew=True)
    with pytest.raises(vr.InputError, match="anew: give the folder"):
        runs.swing().simulate(**runs.GIVEN, anew=True)


def test_a_run_of_less_than_a_second_goes_to_its_file_at_once(stopped_once, tmp_path, monkeypatch):
    """Contract: without a journal the file holds the same, and a run that was stopped there is gone."""
    monkeypatch.setattr(streaming, "FLUSH", 1e9)
    monkeypatch.setattr(streaming, "CHECKPOINT", 1e9)
    appended = []
    monkeypatch.setattr(Journal, "append", lambda *given: appended.append(given))
    shutil.copytree(stopped_once, tmp_path / FOLDER)
    run = runs.swing().simulate(**runs.GIVEN, folder=tmp_path, anew=True)
    assert not appended
    assert runs.differences(run) == set()
    assert runs.differences(vr.load(tmp_path)) == set()
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    with pytest.raises(vr.InputError, match="the run in it is complete"):
        runs.swing().simulate(**runs.GIVEN, folder=tmp_path, resume=True)


# --- damaged journals


DAMAGES = [(name, kind) for name in runs.FILES if ".twin" not in name for kind in runs.KINDS]


@pytest.mark.parametrize(
    ("name", "kind"), [*DAMAGES, ("states.twin.json", "flip"), ("layout.twin.nc", "cut")]
)
def test_a_damaged_journal_goes_on_bit_for_bit_or_is_refused(tmp_path, journal, name, kind):
    """Identity with the run that nobody stopped, or one message that names the file and leaves it as it is."""
    rng = random.Random(f"{name} {kind}")
    runs.damage(journal / name, kind, rng.random(), rng.randint(1, 2000))
    run, told = resumed(tmp_path)
    if run is None:
        assert "damaged" in told[0] or "missing" in told[0] or "No such file" in told[0]
        assert journal.is_dir()
    else:
        assert runs.differences(run) == set()
        assert (name, kind) != ("states.bin", "flip")
    if name in runs.TWINS:
        assert run is not None
        assert f"{name} was damaged or missing: it was made again" in told[0]
        assert told[0] in run.warnings


def test_no_damage_of_one_small_file_loses_a_run(tmp_path, journal):
    """Flips all over it, and its first bytes only: read as before and said; mended as it was, byte for byte."""
    known = contents(journal)
    identity = read_sealed(journal / "states.json")[1]
    for name in runs.TWINS:
        path, rng = journal / name, random.Random(name)
        main = journal / name.replace(".twin", "")
        content = path.read_bytes()
        size = len(content)
        damages = [content[:end] for end in (0, 1, 27, 28, 29, size // 2, size - 1)]
        for at in {*rng.sample(range(size), 60), *range(size - 28, size)}:
            damages.append(content[:at] + bytes([content[at] ^ (1 << rng.randrange(8))]) + content[at + 1 :])
        for damage in damages:
            path.write_bytes(damage)
            found, _, wrong = read_twins(main, identity)
            assert found == content[:-28]
            assert (name in wrong) == (path == main)  # the twin is not read where the file is whole
            assert f"{name} was damaged or missing" in mend_twins(main, identity)
            assert path.read_bytes() == content
            assert mend_twins(main, identity) == ""
        path.write_bytes(rng.choice(damages))
        assert contents(journal).identical(known)
        if path == main:
            with pytest.warns(vr.AccuracyWarning, match=rf"{name} is damaged.*twin"):
                part = vr.load(tmp_path)
            assert any(f"{name} is damaged" in text for text in part.warnings)
        assert [name in told for told in mended(journal)] == [True]
        assert mended(journal) == damaged(journal) == []
    for name in ("states.json", "states.twin.json"):
        (journal / name).write_bytes(b"")
    with pytest.raises(vr.InputError, match=r"states.json is damaged.*states.twin.json is damaged"):
        vr.load(tmp_path)


# --- power cuts


class Disk:
    """What is on a disk that keeps no more than it was told to: contents and entries of folders as of their fsync.

    Attributes:
        states: of the journal, every one a power cut could leave: ``{name: content}``, with what was promised by then.
    """

    def __init__(self, journal, monkeypatch):
        self.journal, self.states, self.promised = journal, [], 0
        self._contents, self._entries, self._parent = {}, {}, False
        fsync, replace, checkpoint = os.fsync, Path.replace, Journal.checkpoint

        def synced(handle):
            fsync(handle)
            about = os.fstat(handle)
            if stat.S_ISREG(about.st_mode):
                self._contents[about.st_ino] = Path(f"/proc/self/fd/{handle}").read_bytes()
            elif self.journal.is_dir() and os.path.samestat(about, self.journal.stat()):
                self._entries = self._now()
            elif os.path.samestat(about, self.journal.parent.stat()):
                self._parent = True
            self._cut()

        def replaced(path, target):
            found = replace(path, target)
            self._cut()
            return found

        def promised(journal, state, about):
            checkpoint(journal, state, about)
            self.promised = journal.count
            self._cut()

        monkeypatch.setattr(os, "fsync", synced)
        monkeypatch.setattr(Path, "replace", replaced)
        monkeypatch.setattr(Journal, "checkpoint", promised)

    def _now(self):
        return (
            {path.name: path.stat().st_ino for path in self.journal.iterdir()}
            if self.journal.is_dir()
            else {}
        )

    def _cut(self):
        for entries in (
            self._entries if self._parent else {},
            self._now(),
        ):  # none later than told, or all of them
            files = {name: self._contents.get(number, b"") for name, number in entries.items()}
            if not self.states or self.states[-1] != (files, self.promised):
                self.states.append((files, self.promised))


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="reads open files by their number")
def test_a_power_cut_leaves_the_last_checkpoint(tmp_path, monkeypatch):
    """At every moment, of a disk that keeps what was written with fsync and no more, or names before contents."""
    with monkeypatch.context() as patch:
        disk = Disk(tmp_path / "run" / FOLDER, patch)
        runs.stopped(tmp_path / "run")
    assert len(disk.states) > 30
    assert disk.promised > 10
    journal = tmp_path / "left" / FOLDER
    for files, promised in disk.states:
        shutil.rmtree(journal, ignore_errors=True)
        journal.mkdir(parents=True)
        for name, content in files.items():
            (journal / name).write_bytes(content)
        if promised:
            found = last_checkpoint(journal)
            assert found.count >= promised
            assert not found.doubt
            assert mended(journal) == []
    assert runs.differences(runs.gone_on(journal.parent)) == set()


def test_a_file_is_on_the_disk_before_its_name_and_its_name_before_what_it_replaces_goes(
    tmp_path, monkeypatch
):
    """Order of calls at the end of a run: contents of run.nc, its name, the folder; then the journal goes."""
    done, fsync, replace, unlink = [], os.fsync, Path.replace, Path.unlink

    def synced(handle):
        fsync(handle)
        about = os.fstat(handle)
        done.append("folder" if stat.S_ISDIR(about.st_mode) else about.st_ino)

    def replaced(path, target):
        number = path.stat().st_ino
        done.append((number, Path(target).name))
        return replace(path, target)

    def unlinked(path, **more):
        done.append(f"{path.name} goes")
        unlink(path, **more)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", replaced)
    monkeypatch.setattr(Path, "unlink", unlinked)
    runs.swing().simulate(**runs.GIVEN, folder=tmp_path)
    number = (tmp_path / "run.nc").stat().st_ino
    named = done.index((number, "run.nc"))
    assert number in done[:named]
    assert done[named + 1] == "folder"
    assert done.index("states.bin goes") > named + 1


def test_flipped_bits_of_the_states_are_noticed(tmp_path, journal):
    """Of one record bytes all over it, its checksum too; a record of another run, or place, is none of this one."""
    states = journal / "states.bin"
    content, count = states.read_bytes(), contents(journal).sizes["time"]
    size = len(content) // count
    for place in [
        *range(3 * size, 4 * size, size // 15),
        *range(4 * size - 12, 4 * size),
        *range(3 * size, 3 * size + 12),
    ]:
        states.write_bytes(
            content[:place] + bytes([content[place] ^ (1 << place % 8)]) + content[place + 1 :]
        )
        assert contents(journal).sizes["time"] == 3
    states.write_bytes(content[:size] + content[2 * size : 3 * size] + content[size : 2 * size])
    assert contents(journal).sizes["time"] == 1
    other = runs.stopped(tmp_path / "other")
    states.write_bytes(content[:size] + (other / "states.bin").read_bytes()[size:])
    assert contents(journal).sizes["time"] == 1


def test_a_damaged_checkpoint_goes_back_to_the_one_before(tmp_path, journal):
    """It is said at once, stands in the result, and in the result of a run that is stopped once more."""
    runs.damage(journal / "checkpoint.npz", "flip", 0.5, 3)
    count = itertools.count()
    with (
        pytest.warns(vr.AccuracyWarning, match=r"checkpoint.npz is damaged.*went on from the state before"),
        pytest.raises(vr.SolveError),
    ):
        runs.swing().simulate(
            **runs.GIVEN, folder=tmp_path, resume=True, stop=lambda: "x" if next(count) else ""
        )
    with pytest.warns(vr.AccuracyWarning, match="went on from the state before"):
        run = runs.swing().simulate(**runs.GIVEN, folder=tmp_path, resume=True)
    assert runs.differences(run) == set()
    assert ["went on from the state before" in text for text in run.warnings].count(True) == 1


def test_states_after_a_damaged_one_are_not_read(tmp_path, journal):
    """What can be read of a stopped run are the states before, with a word."""
    all_of_it = vr.load(tmp_path)
    assert isinstance(all_of_it, Run)
    assert all_of_it.outcome == "interrupted"
    assert "has not ended" in flat(all_of_it.report())
    runs.damage(journal / "states.bin", "flip", 0.6, 1)
    with pytest.warns(vr.AccuracyWarning, match=r"is damaged: \d+ of \d+ states are whole"):
        part = vr.load(tmp_path)
    assert 1 < part.time.size < all_of_it.time.size
    assert (part.data["position"].values == all_of_it.data["position"].values[: part.time.size]).all()
    assert "is damaged" in flat(part.report())
    run, told = resumed(tmp_path)
    assert run is None
    assert "viscorod.load" in told[0]
    assert "--anew" in told[0]


@pytest.mark.usefixtures("journal")
def test_estimates_of_a_run_that_went_on_are_those_of_the_whole(tmp_path):
    """Errors by the mesh are estimated from states of all of the motion, those before it was stopped too."""
    run, _ = resumed(tmp_path)
    estimates = {name: value for name, value in runs.whole().data.attrs.items() if "error" in name}
    assert estimates
    assert {name: run.data.attrs[name] for name in estimates} == estimates


# --- full disks


def on_a_full_disk(room, folder, work):
    """Do some work in a process that can write no file of more than so many bytes."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
        try:
            work(folder)
        except vr.InputError as error:
            return str(error)
        return ""

    return runs.in_child(limited)


WRITERS = {
    "result": lambda path: runs.whole().save(path / "file.nc"),
    "picture": lambda path: runs.whole().plot(path / "file.png"),
    "table": lambda path: csv_text.write(
        csv_text.history_columns(runs.whole(), ["beam.end"], ["position", "velocity", "strain"]),
        path / "file.csv",
    ),
    "page": lambda path: view(runs.whole(), path / "file.html"),
    "film": lambda path: runs.whole().animate(path / "file.gif", fps=2.0, speed=0.2),
    "ParaView": lambda path: write_paraview(runs.whole(), path / "file.vtkhdf", times=[0.1]),
}


@pytest.mark.parametrize("what", WRITERS)
def test_a_full_disk_leaves_what_was_there(tmp_path, what):
    """Wherever the room ends: one message, the process lives, the file before is as it was, and nothing lies beside."""
    runs.whole()
    WRITERS[what](tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    largest = max(map(len, before.values()))
    rng = random.Random(what)
    for room in (
        0,
        1000,
        *(rng.randrange(largest) for _ in range(3 if what != "result" else 10)),
        largest - 1,
    ):
        told = on_a_full_disk(room, tmp_path, WRITERS[what])
        assert "cannot be written" in told, room
        assert "are free" in told
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_run_in_memory_survives_a_save_that_failed(tmp_path):
    """The same process saves it where there is room; the message says how much it needs."""
    runs.whole()

    def save():
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
        with pytest.raises(vr.InputError, match=r"kB are needed and .* are free.*still in memory"):
            runs.whole().save(tmp_path / "run.nc")
        assert not list(tmp_path.iterdir())
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        runs.whole().save(tmp_path / "run.nc")

    runs.in_child(save)
    assert runs.differences(vr.load(tmp_path / "run.nc")) == set()


@pytest.mark.parametrize("part", [0.02, 0.3, 0.6, 0.9])
def test_a_run_whose_disk_is_full_goes_on_when_there_is_room(tmp_path, part):
    """Identity: while states are written, or when the file is made of them at the end."""
    runs.swing().simulate(**runs.GIVEN, folder=tmp_path / "whole")
    room = int(part * (tmp_path / "whole" / "run.nc").stat().st_size)
    told = on_a_full_disk(
        room, tmp_path / "run", lambda path: runs.swing().simulate(**runs.GIVEN, folder=path)
    )
    assert "viscorod resume" in told or "cannot be written" in told
    assert not (tmp_path / "run" / "run.nc").exists()
    assert runs.differences(runs.gone_on(tmp_path / "run")) == set()


def test_a_short_run_whose_disk_is_full_is_to_be_computed_again(tmp_path, monkeypatch):
    """Contract: what has no journal yet is not said to be kept; what was there stays, a stopped run too."""
    monkeypatch.setattr(streaming, "FLUSH", 1e9)
    monkeypatch.setattr(streaming, "CHECKPOINT", 1e9)
    (tmp_path / "run.nc").write_bytes(b"an earlier one")
    told = on_a_full_disk(20_000, tmp_path, lambda path: runs.swing().simulate(**runs.GIVEN, folder=path))
    assert "cannot be written" in told
    assert "compute it again" in told
    assert "memory" not in told
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"run.nc": b"an earlier one"}


SMALL_DISK = """
import sys, warnings
from pathlib import Path
sys.path.insert(0, {tests!r})
import viscorod as vr
from helpers import stopped_runs as runs
disk = Path({disk!r})
for size in range(60_000, 300_000, 60_000):
    filler = disk / "filler"
    filler.write_bytes(b"x" * ({room} - size))
    for name in ("run.nc", "again.nc"):
        try:
            runs.whole().save(disk / name)
        except vr.InputError as error:
            assert "are needed and" in str(error), error
    for path in disk.glob("*.nc"):
        assert runs.differences(vr.load(path)) == set()
        path.unlink()
    try:
        run = runs.swing().simulate(**runs.GIVEN, folder=disk / "run")
    except vr.InputError as error:
        assert "written" in str(error), error
        filler.unlink()
        run = runs.gone_on(disk / "run")
    assert runs.differences(run) == set()
    assert [path.name for path in (disk / "run").iterdir()] == ["run.nc"]
    (disk / "run" / "run.nc").unlink()
    filler.unlink(missing_ok=True)
print("done")
"""


def _may_mount():
    if shutil.which("unshare") is None:
        return False
    return subprocess.run(["unshare", "-rm", "true"], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize("room", [1_500_000] if _may_mount() else [])
def test_a_small_disk(tmp_path, room):
    """A real file system of 1.5 MB, with less and less room, where a user may mount one."""
    tests = os.path.dirname(os.path.dirname(__file__))
    script = tmp_path / "script.py"
    script.write_text(SMALL_DISK.format(tests=tests, disk=str(tmp_path / "disk"), room=room))
    (tmp_path / "disk").mkdir()
    command = f"mount -t tmpfs -o size={room} none {tmp_path / 'disk'} && exec {sys.executable} {script}"
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", command], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, "done\n"), done.stderr


# --- interrupts


def test_interrupted_at_any_line_a_run_goes_on(tmp_path):
    """Identity: KeyboardInterrupt in any line of what records, writes and completes; more by ``make fuzz``."""
    runs.whole()
    with runs.Interrupt(-1) as counted:
        runs.swing().simulate(**runs.GIVEN, folder=tmp_path / "count")
    rng = random.Random(11)
    chosen = [rng.randrange(counted.count) for _ in range(3)]
    chosen += [counted.count - rng.randrange(600) for _ in range(2)]  # the end, where the file is made

    def interrupted(number):
        folder = tmp_path / str(number)
        with runs.Interrupt(number), contextlib.suppress(vr.SolveError, KeyboardInterrupt):
            runs.swing().simulate(**runs.GIVEN, folder=folder)
        differing = sorted(runs.differences(runs.gone_on(folder)))
        with folder_lock.locked(
            folder
        ):  # an interrupt just before the lock is left leaves its file to the next one
            pass
        return differing + [path.name for path in folder.iterdir() if path.name != "run.nc"]

    for number in chosen:
        assert runs.in_child(interrupted, number) == [], number


def test_ctrl_c_in_python_keeps_the_run(tmp_path):
    """Real signals at random times, again and again, until it is done: identity with the run that nobody stopped."""
    runs.whole()

    def nagged():
        durations = []  # the shortest counts: one that the machine held up would let all others end undisturbed
        for number in range(2):
            begun = time.perf_counter()
            runs.gone_on(tmp_path / f"undisturbed {number}")
            durations.append(time.perf_counter() - begun)
        taken = min(durations)
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        rng, stops = random.Random(4), 0
        for _ in range(15):
            signal.setitimer(signal.ITIMER_REAL, rng.uniform(0.1, 0.5) * taken)
            try:
                run = runs.gone_on(tmp_path / "nagged")
            except (vr.SolveError, KeyboardInterrupt):
                stops += 1
                continue
            except SystemError as error:  # libraries written in C say so where an interrupt met them
                if not isinstance(error.__cause__ or error.__context__, KeyboardInterrupt):
                    raise
                stops += 1
                continue
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
            return stops, sorted(runs.differences(run))
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        return stops, sorted(runs.differences(runs.gone_on(tmp_path / "nagged")))

    stops, differing = runs.in_child(nagged)
    assert stops > 0
    assert differing == []


# --- memory


@pytest.mark.parametrize("where", ["memory", "folder"])
def test_states_within_a_step_do_not_pile_up(tmp_path, where):
    """Beside the result there is as little for 8000 states within two steps as for 1000."""

    def beside(count):
        folder = {"folder": tmp_path / str(count)} if where == "folder" else {}
        tracemalloc.start()
        run = runs.swing().simulate(0.2, time_step=0.1, output_interval=0.2 / count, **folder)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert run.time.size == count + 1
        return peak - 1.25 * run.data.nbytes, run.data.nbytes

    beside(10)
    few, many = beside(1000), beside(8000)
    assert many[0] < few[0] + 0.1 * many[1]


def test_states_in_pieces_are_those_of_one_piece(tmp_path, monkeypatch):
    """Identity: how many states of a step are computed and written at once changes none of them."""
    from viscorod.solve.transient import transient_solver

    def run():
        return runs.swing().simulate(0.4, output_interval=0.001)

    expected = run()
    monkeypatch.setattr(transient_solver, "AT_ONCE", 3)
    monkeypatch.setattr(streaming, "MANY", 5)
    found = run()
    assert found.time.size > 400
    for name, variable in expected.data.variables.items():
        if variable.dtype.kind == "f":
            assert found.data[name].values == pytest.approx(variable.values, rel=1e-13, abs=1e-15), name
        else:
            assert (found.data[name].values == variable.values).all()
    assert json.loads(found.data.attrs["warnings"]) == json.loads(expected.data.attrs["warnings"])
