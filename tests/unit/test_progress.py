"""What is printed of a solution's progress where there is no terminal."""

from __future__ import annotations

import io
import re
from itertools import count
from types import SimpleNamespace

import pytest

from viscorod.analyses import progress
from viscorod.solve.settings.course import Course


def ticking(monkeypatch, seconds, start=0.0):
    """Let so many seconds pass from one look at the clock to the next."""
    ticks = count()
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: start + seconds * next(ticks)))


def test_time_left_is_that_of_equal_steps(monkeypatch, capsys):
    """A minute of preparation, then ten seconds per step: the estimate counts the steps alone."""
    ticking(monkeypatch, 10.0, 70.0)
    with progress.reporting(Course("t", " s", 0.0, 10.0)) as report:
        for k in range(1, 11):
            report(float(k), 1.0)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 5
    for line, reached in zip(lines, (2, 4, 6, 8, 10), strict=True):
        assert line.startswith(f"t = {reached} of 10 s")
        assert line.endswith(f"{10 * (10 - reached)} s left" if reached < 10 else "step 1 s")


@pytest.mark.parametrize("total", [1.0, 3.0])
def test_one_step_has_no_estimate(capsys, total):
    with progress.reporting(Course("load", "", 0.0, total)) as report:
        report(total, total)
    assert capsys.readouterr().err == f"load = {total:g} of {total:g}, step {total:.3g}\n"


def test_a_short_run_has_one_line(monkeypatch, capsys):
    """Others come five seconds after the one before at the earliest, however often all is computed again."""
    ticking(monkeypatch, 0.1)
    with progress.reporting(Course("t", " s", 0.0, 10.0)) as report:
        for reached in (2.0, 4.0, 6.0, 8.0, 10.0) * 9:  # four and a half seconds
            report(reached, 2.0)
        assert not capsys.readouterr().err
        for reached in (2.0, 4.0, 6.0, 8.0, 10.0) * 2:
            report(reached, 2.0)
    told = [line.split(",")[0] for line in capsys.readouterr().err.splitlines()]
    assert told == ["t = 2 of 10 s", "t = 10 of 10 s"]
    with progress.counting(100, "members") as report:
        for done in range(101):  # ten seconds, from nothing done on
            report(done)
    told = [line.split(",")[0] for line in capsys.readouterr().err.splitlines()]
    assert told == ["60 of 100 members", "100 of 100 members"]


def test_curves_that_fall_or_have_no_known_end(monkeypatch, capsys):
    """A curve may lead from high to low; where nobody knows its end there is nothing to be a part of."""
    ticking(monkeypatch, 10.0)
    with progress.reporting(Course("f", " Hz", 30.0, 10.0)) as report:
        report(30.0, 0.0)
        report(20.0, 10.0)
        report(26.0, 6.0)  # back, behind a fold
    assert capsys.readouterr().err.startswith("f = 20 of 10 Hz, step 10 Hz")
    with progress.reporting(Course("load", "", 0.0, None)) as report:
        report(3.0, 1.0)
    assert not capsys.readouterr().err


def test_what_is_computed_again_is_told_again(monkeypatch, capsys):
    """Once more from the start, on a finer mesh or with smaller steps; not where a curve goes back on its way."""
    ticking(monkeypatch, 10.0)
    with progress.reporting(Course("t", " s", 0.0, 10.0)) as report:
        for reached in (1.0, 5.0, 3.0, 5.0, 10.0, 1.0, 5.0, 10.0):
            report(reached, 5.0)
    told = [line.split(",")[0] for line in capsys.readouterr().err.splitlines()]
    assert told == ["t = 5 of 10 s", "t = 10 of 10 s"] * 2


def test_many_things_are_told_every_ten_minutes_with_their_rate(monkeypatch, capsys):
    """Forty members were done before; from there on it is one in a hundred seconds."""
    ticking(monkeypatch, 100.0, 50.0)
    with progress.counting(1000, "members") as report:
        for done in range(40, 60):
            report(done)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(" of")[0] for line in lines] == ["46", "52", "58"]
    assert lines[0] == "46 of 1000 members, 0.01 per s, 95400 s left"


class Terminal(io.StringIO):
    """A standard error that is looked at."""

    def isatty(self):
        return True


def test_a_terminal_has_the_rate_too(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    ticking(monkeypatch, 2.0)
    with progress.counting(100, "members") as report:
        for done in range(5):
            report(float(done))
    told = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())
    assert "4 of 100 members" in told
    assert "0.5 per s" in told
