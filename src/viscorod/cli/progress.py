"""Show the progress of a solution: a bar on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

Progress: TypeAlias = Callable[[float, float], None]
"""Called after every step with the time reached [s] (or the load factor) and the step's size."""

_REFRESH = 0.05  # seconds between two updates of the bar
_LINES = 5  # lines over a whole run where there is no terminal


TIME, LOAD, FREQUENCY = ("t", " s"), ("load", ""), ("f", " Hz")
"""What grows during a solution: its name and its unit."""


@contextmanager
def reporting(total: float, quantity: tuple[str, str]) -> Iterator[Progress]:
    """Show progress towards a ``total`` time, load factor or frequency."""
    if sys.stderr.isatty():
        with _bar(total, quantity) as progress:
            yield progress
    else:
        yield _lines(total, quantity)


@contextmanager
def counting(total: int, noun: str) -> Iterator[Callable[[float], None]]:
    """Show how many of ``total`` things are done, fractions included; ``noun`` names them."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (
            TextColumn("{task.completed:.1f} of {task.total:g} " + noun),
            BarColumn(bar_width=None),
            TimeRemainingColumn(),
            TextColumn("left"),
        )
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("", total=total)
            yield lambda done: bar.update(task, completed=done)
        return
    shown = 0

    def update(done: float) -> None:
        nonlocal shown
        part = int(_LINES * done / total * (1.0 + 1e-9))
        if part > shown:
            shown = part
            print(f"{done:.1f} of {total} {noun}", file=sys.stderr, flush=True)

    yield update


@contextmanager
def _bar(total: float, quantity: tuple[str, str]) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    name, unit = quantity
    columns = (
        TextColumn(name + " = {task.completed:.4g} of {task.total:g}" + unit),
        BarColumn(bar_width=None),
        TextColumn("step {task.fields[step]:.3g}" + unit),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=total, step=0.0)
        last = 0.0

        def update(reached: float, step: float) -> None:
            nonlocal last
            now = time.monotonic()
            if now - last > _REFRESH or reached >= total:
                last = now
                bar.update(task, completed=reached, step=step)

        yield update


def _lines(total: float, quantity: tuple[str, str]) -> Progress:
    name, unit = quantity
    shown = 0
    first: tuple[float, float] | None = (
        None  # when and where the first step ended; the time before it was preparation
    )

    def update(reached: float, step: float) -> None:
        nonlocal shown, first
        now = time.monotonic()
        first = first or (now, reached)
        part = int(_LINES * reached / total * (1.0 + 1e-9))
        if part > shown:
            shown = part
            began, start = first
            state = f"{name} = {reached:.4g} of {total:g}{unit}, step {step:.3g}{unit}"
            if reached > start:
                left = (now - began) * (total - reached) / (reached - start)
                state += f", {max(left, 0.0):.1f} s left"
            print(state, file=sys.stderr, flush=True)

    return update
