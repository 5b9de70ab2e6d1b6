"""Show the progress of a solution: a bar on a terminal; elsewhere one plain line, a few where it takes long."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from viscorod.analyses.compilation_line import end_compilation_line
from viscorod.solve.settings.course import Course

Progress: TypeAlias = Callable[[float, float], None]
"""Called after every step with the time reached [s] (or the load factor) and the step's size."""

_REFRESH = 0.05  # seconds between two updates of the bar
_LINES = 5  # lines over a whole run where there is no terminal
_PAUSE = (
    5.0  # seconds from the first step, or the last line, to the next one there: short runs leave a log alone
)
_LONGEST = 600.0  # seconds without a line, of things that are counted


@contextmanager
def reporting(course: Course, *, shown: bool = True) -> Iterator[Progress]:
    """Show progress along what grows during an analysis: time, load factor, frequency or speed."""
    if not shown:
        yield _nothing
    elif sys.stderr.isatty():
        with _bar(course) as progress:
            yield _Shown(progress)
    else:
        lines = _Lines(course)
        yield _Shown(lines)
        lines.tell()


class _Shown:
    """Progress that is only looked at, and so is told of steps, too, that are no part of the result."""

    again = True

    def __init__(self, show: Progress) -> None:
        self._show = show

    def __call__(self, reached: float, step: float) -> None:
        self._show(reached, step)


@contextmanager
def counting(total: int, noun: str, *, shown: bool = True) -> Iterator[Callable[[float], None]]:
    """Show how many of ``total`` things are done, fractions included; ``noun`` names them."""
    if not shown:
        yield _nothing
        return
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (
            TextColumn("{task.fields[whole]} of {task.total:g} " + noun),
            BarColumn(bar_width=None),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("left"),
        )
        pace = _Rate()
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("", total=total, whole=0, rate="")

            def show(done: float) -> None:
                rate = pace.at(done, time.monotonic())
                bar.update(task, completed=done, whole=_whole(done), rate=f"{rate:.3g} per s" if rate else "")

            yield show
        return
    told, last, waiting, pace = 0, 0.0, "", _Rate()

    def update(done: float) -> None:
        nonlocal told, last, waiting
        now = time.monotonic()
        last, rate = last or now, pace.at(done, now)
        part = int(_LINES * done / total * (1.0 + 1e-9))
        if part <= told and now - last < _LONGEST:
            return
        told, waiting = part, f"{_whole(done)} of {total} {noun}"
        if rate:
            waiting += f", {rate:.3g} per s, {max(total - done, 0.0) / rate:.0f} s left"
        if now - last >= _PAUSE:
            last = now
            tell()

    def tell() -> None:
        nonlocal waiting
        if waiting:
            print(waiting, file=sys.stderr, flush=True)
            waiting = ""

    yield update
    tell()  # the last line, unless it was told


class _Rate:
    """How many things are done in a second, of those that were not done before."""

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None

    def at(self, done: float, now: float) -> float:
        """Return it, by how many are done now [s]; 0 where nothing tells."""
        began, before = self._first = self._first or (now, done)
        return (done - before) / (now - began) if done > before and now > began else 0.0


def _nothing(*_: float) -> None:
    """Show nothing."""


def _whole(done: float) -> int:
    """Return how many things are done, without those that are on the way."""
    return int(done * (1.0 + 1e-9))


@contextmanager
def _bar(course: Course) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    end = "" if course.end is None else f" of {course.end:g}"
    columns = (
        TextColumn(f"{course.name} = {{task.fields[reached]:.4g}}{end}{course.unit}"),
        BarColumn(bar_width=None),
        TextColumn("step {task.fields[step]:.3g}" + course.unit),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task("", total=None if course.end is None else 1.0, step=0.0, reached=course.start)
    last = 0.0

    def update(reached: float, step: float) -> None:
        nonlocal last
        now = time.monotonic()
        if not last:  # until now kernels may have been compiled, which has a line of its own
            end_compilation_line()
            bar.start()
        if now - last > _REFRESH or course.part(reached) >= 1.0:
            last = now
            bar.update(task, completed=course.part(reached), step=step, reached=reached)

    try:
        yield update
    finally:
        bar.stop()


class _Lines:
    """Lines of a run: the last step has one, and those before it where that takes long."""

    def __init__(self, course: Course) -> None:
        self._course = course
        self._shown, self._before, self._told, self._waiting = 0, 0.0, math.nan, ""
        self._first: tuple[float, float] | None = None
        """When and where the first step ended; the time before it was preparation."""

    def __call__(self, reached: float, step: float) -> None:
        now, course = time.monotonic(), self._course
        done = course.part(reached)
        if done < self._before and self._before >= 1.0:  # again: on a finer mesh, or with smaller steps
            self._shown, self._first = 0, None
        self._before = done
        self._first = self._first or (now, reached)
        self._told = now if math.isnan(self._told) else self._told
        part = int(_LINES * done * (1.0 + 1e-9))
        if part <= self._shown:
            return
        self._shown = part
        began, start = self._first[0], course.part(self._first[1])
        state = f"{course.name} = {reached:.4g} of {course.end:g}{course.unit}, step {step:.3g}{course.unit}"
        if start < done < 1.0:
            state += f", {max((now - began) * (1.0 - done) / (done - start), 0.0):.0f} s left"
        self._waiting = state
        if now - self._told >= _PAUSE:
            self._told = now
            self.tell()

    def tell(self) -> None:
        """Print the last line, unless it was."""
        if self._waiting:
            print(self._waiting, file=sys.stderr, flush=True)
            self._waiting = ""
