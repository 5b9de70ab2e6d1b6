"""Ctrl-C that lets a computation finish its present step."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import typer

__all__ = ["polite_stop"]


@contextmanager
def polite_stop() -> Iterator[Callable[[], str]]:
    """Let Ctrl-C, or a request to terminate, end the run after the present step; the second one ends it at once.

    So does the first one before the solver has asked: an initial equilibrium has no step to finish.
    """
    reason, listening = "", False

    def ask(number: int, _: FrameType | None) -> None:
        nonlocal reason
        if reason:
            raise KeyboardInterrupt
        reason = "stopped from the keyboard" if number == signal.SIGINT else "asked to end"
        if not listening:
            raise KeyboardInterrupt(reason)
        typer.echo("\nfinishing the step; interrupt again to end at once", err=True)

    def stop() -> str:
        nonlocal listening
        listening = True
        return reason

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
