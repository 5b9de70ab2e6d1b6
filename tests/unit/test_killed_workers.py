"""Processes of a sweep that really die: their member is tried again, the others keep what they have."""

import multiprocessing
import os
import threading

import pytest

from helpers.deadly_members import work
from viscorod.analyses.sweeps.processes import hired
from viscorod.errors import InputError

DONE = ("", "completed")


def died(number, why):
    return None, why, "failed"


def computed(jobs, workers=2):
    jobs = [{"number": k, **job} for k, job in enumerate(jobs)]
    found = {}
    with hired(work, len(jobs), workers) as crew:
        crew.work(jobs, range(len(jobs)), found, threading.Event(), None, died)
    return [found[k] for k in range(len(jobs))]


def test_a_killed_member_is_tried_again_and_no_other_is_lost(tmp_path):
    once = {"folder": str(tmp_path), "signal": "SIGKILL", "deaths": 2}
    found = computed([{}, once, {"seconds": 0.5}, {}])
    assert found == [(k**2, *DONE) for k in range(4)]
    assert (tmp_path / "1").read_text() == "xx"


def test_members_that_wait_behind_a_killed_one_are_computed_once(tmp_path):
    """Short members wait in the process already; those behind one that kills it count as not begun."""
    jobs = [{"counted": str(tmp_path), "seconds": 0.01} for _ in range(24)]
    jobs[9] |= {"folder": str(tmp_path), "signal": "SIGKILL", "deaths": 2}
    assert computed(jobs) == [(k**2, *DONE) for k in range(24)]
    assert (tmp_path / "9").read_text() == "xx"
    assert [(tmp_path / f"{k}-computed").read_text() for k in range(24)] == ["x"] * 24


def test_a_member_that_always_kills_its_process_is_its_own_failure(tmp_path):
    always = {"folder": str(tmp_path), "deaths": 99}
    found = computed([{**always, "signal": "SIGKILL"}, {}, {**always, "signal": "SIGSEGV"}, {"exit": 7}, {}])
    assert [found[k] for k in (1, 4)] == [(1, *DONE), (16, *DONE)]
    for k, words in ((0, "SIGKILL"), (2, "SIGSEGV"), (3, "exit code 7")):
        result, message, outcome = found[k]
        assert result is None
        assert outcome == "failed"
        assert words in message
        assert "tried 3 times" in message
    assert "memory" in found[0][1]
    assert [(tmp_path / name).read_text() for name in ("0", "2")] == ["xxx", "xxx"]


def test_what_cannot_be_handed_over_is_its_own_failure():
    found = computed([{"unsendable": True}, {}], workers=1)
    assert found[1] == (1, *DONE)
    assert "could not be handed over" in found[0][1]


def test_processes_that_end_before_they_begin_are_one_message(monkeypatch):
    monkeypatch.setattr("viscorod.analyses.sweeps.processes._serve", os._exit)
    with (
        pytest.raises(InputError, match="no worker process could be started"),
        hired(work, 1, 1) as crew,
    ):
        crew.work([{"number": 0}], [0], {}, threading.Event(), None, died)
    assert not multiprocessing.active_children()
