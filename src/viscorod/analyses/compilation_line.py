"""A line on the terminal that says how far the kernels of a first run are compiled."""

from __future__ import annotations

import logging
import sys
import time
from typing import Any

__all__ = ["CompilationLine", "end_compilation_line"]

COSTS = {
    "try_step": 8.8,
    "assemble": 13.7,
    "reduce": 4.2,
    "read_between": 2.4,
    "internal_forces": 1.8,
    "substitute": 1.8,
    "collect": 1.6,
    "impose": 1.5,
    "strains": 1.5,
    "measure": 1.5,
    "combine": 1.5,
    "end_step": 1.3,
    "update_stress": 1.2,
    "impose_tangent": 0.9,
    "reaction_wrenches": 0.8,
    "add_nodal_loads": 0.8,
    "add_inertia": 0.7,
    "extrapolate_step": 0.7,
    "project": 0.7,
    "energies": 0.6,
}
"""Kernels that a first motion compiles, and the seconds that it takes: all others, a score, take 4 s together."""


class CompilationLine(logging.Handler):
    """Prints what the package tells; where it tells that kernels are compiled, a line on the terminal follows them."""

    def __init__(self) -> None:
        super().__init__()
        self._listener: Any = None
        self._began = self._last = 0.0
        self._done = 0.0  # part of the time

    def emit(self, record: logging.LogRecord) -> None:
        """Print a message; begin the line if it says that kernels are compiled."""
        self._clear()
        print(self.format(record), file=sys.stderr, flush=True)
        if getattr(record, "compiles", False) and sys.stderr.isatty() and self._listener is None:
            self._begin()

    def _begin(self) -> None:
        from numba.core import event

        line = self

        class Listener(event.Listener):
            """Shows the line again whenever a kernel, or a part of one, is compiled."""

            def on_start(self, _event: Any) -> None:
                line.show()

            def on_end(self, _event: Any) -> None:
                line.show()

        self._began, self._listener = time.monotonic(), Listener()
        events: Any = event
        events.register("numba:compile", self._listener)

    def show(self) -> None:
        """Show how far it is; kernels that a second process compiles count when they are read."""
        from viscorod.mechanics.compilation.compiled import KERNELS

        now = time.monotonic()
        ready = {kernel.py_func.__name__ for kernel in KERNELS if kernel.signatures}
        done = sum(cost for kernel, cost in COSTS.items() if kernel in ready) / sum(COSTS.values())
        if done > self._done:
            self._done, self._last = done, now
        text = f"compiling kernels, once per machine: {100.0 * done:.0f} %"
        if 0.0 < done < 1.0:
            left = (self._last - self._began) / done - (now - self._began)
            text += f", about {max(left, 1.0):.0f} s left"
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """End the line: something else is shown from here on."""
        if self._listener is not None:
            from numba.core import event

            events: Any = event
            events.unregister("numba:compile", self._listener)
            self._clear()
            self._listener = None

    def _clear(self) -> None:
        if self._listener is not None:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def end_compilation_line() -> None:
    """End the line, if there is one."""
    for handler in logging.getLogger("viscorod").handlers:
        if isinstance(handler, CompilationLine):
            handler.end()
