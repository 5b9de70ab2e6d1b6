"""Ctrl-C that lets a computation finish its present step."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import typer

__all__ = ["polite_stop"]


class _Asked:
    """Returns why a run is to end, if it is.

    Attributes:
        patient: it may be called after some short steps, and need not be after every one.
    """

    patient = True

    def __init__(self) -> None:
        self.reason, self.listening = "", False

    def __call__(self) -> str:
        self.listening = True
        return self.reason


@contextmanager
def polite_stop() -> Iterator[Callable[[], str]]:
    """Let Ctrl-C, or a request to terminate, end the run after the present step; the second one ends it at once.

    So does the first one before the solver has asked: an initial equilibrium has no step to finish.
    """
    stop = _Asked()

    def ask(number: int, _: FrameType | None) -> None:
        if stop.reason:
            raise KeyboardInterrupt
        stop.reason = "stopped from the keyboard" if number == signal.SIGINT else "asked to end"
        if not stop.listening:
            raise KeyboardInterrupt(stop.reason)
        typer.echo("\nfinishing the step; interrupt again to end at once", err=True)

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
