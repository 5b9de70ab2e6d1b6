"""How kernels are compiled: once, cached on disk, with fused multiply-add but otherwise strict floating point."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])

_ASIDE = "VISCOROD_COMPILES_ASIDE"
"""Set in the process that compiles aside."""

_helpers: list[subprocess.Popen[bytes]] = []

KERNELS: list[Any] = []
"""All kernels that have been imported, as Numba's dispatchers."""


def inlined(function: Kernel) -> Kernel:
    """Make ``function`` a part of the kernels that call it, once each: it costs no compilation of its own.

    What takes many arrays is dear to compile as a function that is called.
    """
    part: Any = numba.njit(inline="always", error_model="numpy", fastmath={"contract", "nsz"})(function)
    return cast(Kernel, part)


def kernel(function: Kernel) -> Kernel:
    """Compile ``function`` with Numba at its first call and keep the machine code on disk.

    Copy rows entry by entry: one assignment of an array to a slice compiles, for the message of its error, two to
    three seconds of text formatting.
    """
    compiled: Any = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})(function)
    KERNELS.append(compiled)
    return cast(Kernel, compiled)


def on_disk(compiled: Any) -> bool:
    """Whether there is machine code of a kernel on disk."""
    function = compiled.py_func
    stem = f"{function.__module__.rpartition('.')[2]}.{function.__name__}-{function.__code__.co_firstlineno}."
    return any(Path(compiled.stats.cache_path).glob(f"{stem}*.nbi"))


def lane_kernel(function: Kernel) -> Kernel:
    """Compile ``function`` into its callers only: loops over lanes vectorise where row lengths are constants."""
    njit: Any = numba.njit
    compiled = njit(
        error_model="numpy",
        fastmath={"contract", "nsz"},
        forceinline=True,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )(function)
    return cast(Kernel, compiled)


def announce_compilation(largest: Any) -> None:
    """Say so if the machine code of the kernel ``largest`` is neither in memory nor on disk yet, and get help."""
    if not largest.signatures and not on_disk(largest):
        logging.getLogger("viscorod").warning(
            "viscorod: compiling its kernels, once, for about half a minute; later runs start at once "
            "(viscorod warmup compiles all of them)"
        )
        compile_aside()


def compile_aside() -> None:
    """Have the kernels of transients compiled by a second process, while this one is busy with those of statics."""
    if _ASIDE not in os.environ and not _helpers:
        command = [sys.executable, "-m", "viscorod.warmup"]
        quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        _helpers.append(subprocess.Popen(command, env=os.environ | {_ASIDE: "1"}, **quiet))


def await_compilation() -> None:
    """Wait for the second process, if there is one: what it compiled is then on disk."""
    while _helpers:
        _helpers.pop().wait()
