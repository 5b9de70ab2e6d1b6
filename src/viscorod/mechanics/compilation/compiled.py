"""Compile kernels: once, cached on disk, with fused multiply-add but otherwise strict floating point.

With ``NUMBA_DISABLE_JIT=1`` nothing is compiled: kernels are the Python functions themselves, some hundred times
slower, which debuggers and measurements of coverage can follow.
"""

from __future__ import annotations

import contextlib
import logging
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from viscorod.mechanics.compilation.kernel_store import KernelStore
from viscorod.mechanics.compilation.pipelines import kernel_compiler, part_compiler

Kernel = TypeVar("Kernel", bound=Callable[..., object])

_ASIDE = "VISCOROD_COMPILES_ASIDE"
"""Set in the process that compiles aside."""

_helpers: list[subprocess.Popen[bytes]] = []

_CONSTRUCTORS = {"empty", "zeros", "dot"}
"""Constructors of arrays within kernels."""

_FAST = {"contract", "nsz"}
"""What floating point may do: multiply and add at once, forget the sign of zero."""

_njit: Any = numba.njit
PURE_PYTHON = bool(cast(Any, numba).config.DISABLE_JIT)
"""Whether kernels stay the Python functions that they are."""

KERNELS: list[Any] = []
"""All kernels that have been imported, as Numba's dispatchers; none in pure Python."""


def _allocates(function: Callable[..., object]) -> bool:
    """Return whether ``function`` makes arrays; if not, it needs no reference counts, which are half of all code."""
    return not _CONSTRUCTORS.isdisjoint(cast(Any, function).__code__.co_names)


def part(function: Kernel) -> Kernel:
    """Compile ``function`` as a part of the kernels that call it; calling it from Python crashes.

    It must not return arrays.
    """
    return _part(function, _FAST)


def exact_part(function: Kernel) -> Kernel:
    """Compile ``function`` as a part whose numbers are, bit for bit, those of Python: no operations are fused."""
    return _part(function, False)


def _part(function: Kernel, fast: set[str] | bool) -> Kernel:
    if PURE_PYTHON:
        return function
    compiled: Any = _njit(
        error_model="numpy",
        fastmath=fast,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
        pipeline_class=part_compiler(),
        _nrt=_allocates(function),
    )(function)
    return cast(Kernel, compiled)


def kernel(function: Kernel) -> Kernel:
    """Compile ``function`` with Numba at its first call and keep the machine code on disk.

    It runs without Python's lock, so that other threads run meanwhile; Python functions that it calls take it.
    A kernel that makes arrays names one of the constructors above itself; the others return no arrays, not even views.
    Copy rows entry by entry: one assignment of an array to a slice compiles, for the message of its error, two to
    three seconds of text formatting.
    """
    return _kernel(function, _FAST)


def loop(function: Kernel) -> Kernel:
    """Compile ``function`` as a kernel whose own numbers are, bit for bit, those of Python; see :func:`exact_part`."""
    return _kernel(function, False)


def _kernel(function: Kernel, fast: set[str] | bool) -> Kernel:
    if PURE_PYTHON:
        return function
    compiled: Any = _njit(
        error_model="numpy",
        fastmath=fast,
        no_cfunc_wrapper=True,
        nogil=True,
        pipeline_class=kernel_compiler(),
        _nrt=_allocates(function),
    )(function)
    compiled._cache = KernelStore(function)
    KERNELS.append(compiled)
    return cast(Kernel, compiled)


def on_disk(compiled: Any) -> bool:
    """Return whether there is machine code of a kernel on disk, compiled here or in the wheel."""
    return bool(compiled._cache.filled())


def lane_kernel(function: Kernel) -> Kernel:
    """Compile ``function`` into its callers only, without reference counts.

    Loops over lanes vectorise where row lengths are constants, formulas stay in registers, and parts of a step take
    bundles of arrays without a copy of all that describes them.
    """
    if PURE_PYTHON:
        return function
    compiled = _njit(
        error_model="numpy",
        fastmath=_FAST,
        forceinline=True,
        _nrt=False,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
        pipeline_class=part_compiler(),
    )(function)
    return cast(Kernel, compiled)


def _uncompiled(compiled: Any) -> bool:
    """Return whether machine code of a kernel is neither in memory nor on disk yet."""
    return not PURE_PYTHON and not compiled.signatures and not on_disk(compiled)


def announce_formulation(first: Any) -> None:
    """Warn if ``first``, a kernel that only some runs need, still has to be compiled."""
    if _uncompiled(first):
        logging.getLogger("viscorod").warning(
            "viscorod: compiling the kernels that this kind of model needs, once, for about a quarter of a minute",
            extra={"compiles": True},
        )


def announce_compilation(largest: Any) -> None:
    """Warn if the kernel ``largest`` still has to be compiled, and get help."""
    if _uncompiled(largest):
        logging.getLogger("viscorod").warning(
            "viscorod: compiling its kernels, once, for about half a minute; later runs start at once "
            "(viscorod warmup compiles all of them)",
            extra={"compiles": True},
        )
        compile_aside()


def compile_aside(*words: str) -> None:
    """Start a second process that compiles the kernels of transients, while this one compiles those of statics.

    Each kernel is compiled by the process that reaches it first; the other waits for it (see ``claims``).

    Args:
        words: that the process is given, see ``analyses.warmup``.
    """
    if _ASIDE not in os.environ and not _helpers and sys.executable:
        command = [sys.executable, "-m", "viscorod.analyses.warmup", *words]
        quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        # where no process can be started, this one compiles everything
        with contextlib.suppress(OSError):
            _helpers.append(subprocess.Popen(command, env=os.environ | {_ASIDE: "1"}, **quiet))


def await_compilation() -> None:
    """Wait for the second process, if there is one: all kernels are on disk then."""
    while _helpers:
        _helpers.pop().wait()
