"""Stopped runs with damaged journals, interrupts anywhere, several writers: the undisturbed run, or a message.

``make fuzz`` runs many examples; here are a few, the same each time.
"""

import shutil
import sys
import threading
import warnings

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import viscorod as vr
from helpers import stopped_runs as runs
from viscorod.results.files import stream as streaming
from viscorod.results.files.journal_folder import FOLDER

MANY = settings.default.max_examples > 1000
FIXTURES = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="no fork"),
]


def result_or_message(call):
    try:
        return call()
    except vr.InputError as error:
        return str(error)


def examples(few, many):
    return settings(max_examples=many if MANY else few, suppress_health_check=FIXTURES, deadline=None)


@pytest.fixture(autouse=True)
def eager(monkeypatch):
    """Write and make checkpoints as often as possible."""
    for name in ("SHARE", "FLUSH", "CHECKPOINT"):
        monkeypatch.setattr(streaming, name, 1.0 if name == "SHARE" else 0.0)


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        for name in ("SHARE", "FLUSH", "CHECKPOINT"):
            patch.setattr(streaming, name, 1.0 if name == "SHARE" else 0.0)
        folder = tmp_path_factory.mktemp("stopped")
        runs.stopped(folder)
    return folder


DAMAGE = st.tuples(
    st.sampled_from(runs.FILES), st.sampled_from(runs.KINDS), st.floats(0.0, 1.0), st.integers(1, 5000)
)


@given(damages=st.lists(DAMAGE, min_size=1, max_size=3))
@examples(few=5, many=5000)
def test_damaged_journals_go_on_or_are_refused(base, tmp_path, damages):
    folder = tmp_path / "run"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(base, folder)
    for name, *how in damages:
        path = folder / FOLDER / name
        if path.is_file() and path.stat().st_size:
            runs.damage(path, *how)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vr.AccuracyWarning)
        part = result_or_message(lambda: vr.load(folder / FOLDER))
        run = result_or_message(lambda: runs.swing().simulate(**runs.GIVEN, folder=folder, resume=True))
    if not isinstance(part, str):
        known = runs.whole().data["position"].values[: part.time.size]
        assert (part.data["position"].values == known).all()
    assert len(run) < 1500 if isinstance(run, str) else runs.differences(run) == set()


@given(places=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=3))
@examples(few=1, many=1000)
def test_interrupted_again_and_again_a_run_goes_on(tmp_path, places):
    runs.whole()
    folder = tmp_path / "run"
    shutil.rmtree(folder, ignore_errors=True)

    def interrupted():
        for place in places:
            with runs.Interrupt(int(1 + place * LINES)):
                try:
                    runs.gone_on(folder)
                except (vr.SolveError, KeyboardInterrupt):
                    continue
        return sorted(runs.differences(runs.gone_on(folder)))

    assert runs.in_child(interrupted) == []


LINES = 6000
"""About as many lines of viscorod as a run of these has that can be interrupted."""


@given(words=st.lists(st.sampled_from(["run", "resume", "anew"]), min_size=2, max_size=4))
@examples(few=2, many=500)
def test_several_writers_make_one_run(base, tmp_path, words):
    folder = tmp_path / "run"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(base, folder)
    found, begin = [], threading.Barrier(len(words))

    def write(word):
        begin.wait()
        more = {} if word == "run" else {word: True}
        found.append(result_or_message(lambda: runs.swing().simulate(**runs.GIVEN, folder=folder, **more)))

    threads = [threading.Thread(target=write, args=(word,)) for word in words]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == len(words)
    assert all(runs.differences(run) == set() for run in found if not isinstance(run, str))
    assert runs.differences(runs.gone_on(folder)) == set()
