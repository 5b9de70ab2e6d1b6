"""Compile kernels: once, cached on disk, with fused multiply-add but otherwise strict floating point.

With ``NUMBA_DISABLE_JIT=1`` nothing is compiled: kernels are the Python functions themselves, some hundred times
slower, which debuggers and measurements of coverage can follow.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from viscorod.mechanics.compilation.claims import ClaimedCache
from viscorod.mechanics.compilation.pipelines import kernel_compiler, part_compiler

Kernel = TypeVar("Kernel", bound=Callable[..., object])

_ASIDE = "VISCOROD_COMPILES_ASIDE"
"""Set in the process that compiles aside."""

_MARK = re.compile(rb"^@(kernel|part|lane_kernel|loop|exact_part|loop_part)$", re.MULTILINE)
_IMPORTED = re.compile(rb"^\s*(?:from|import) viscorod\.([\w.]+)", re.MULTILINE)

_helpers: list[subprocess.Popen[bytes]] = []

_CONSTRUCTORS = {"empty", "zeros", "dot"}
"""Constructors of arrays within kernels."""

_FAST = {"contract", "nsz"}
"""What floating point may do: multiply and add at once, forget the sign of zero."""

_njit: Any = numba.njit
_config: Any = numba.config

PURE_PYTHON = bool(_config.DISABLE_JIT)
"""Whether kernels stay the Python functions that they are."""

KERNELS: list[Any] = []
"""All kernels that have been imported, as Numba's dispatchers; none in pure Python."""


def _kernel_sources(package: Path) -> list[bytes]:
    """Return the sources that machine code depends on: modules with kernels, and what these import of the package."""
    sources = {
        path: path.read_bytes()
        for part_of in ("mechanics", "solve")
        for path in sorted((package / part_of).rglob("*.py"))
    }
    found: set[Path] = set()
    sought = {path for path, text in sources.items() if _MARK.search(text)}
    while sought:
        found |= sought
        names = {name.decode() for path in sought for name in _IMPORTED.findall(sources[path])}
        places = {package.joinpath(*name.split(".")) for name in names}
        files = {place.with_suffix(".py") for place in places} | {place / "__init__.py" for place in places}
        sought = (files & sources.keys()) - found
    return [sources[path] for path in sorted(found)]


@functools.lru_cache
def cache_folder() -> Path | None:
    """Return the folder of the machine code of exactly this version of all kernels; None if none is writable.

    Kernels contain those that they call, so all are compiled again when the source of any has changed; folders of
    earlier versions are removed. It lies in Numba's cache folder if one is set, else in that of this package.
    """
    package = Path(__file__).parents[2]
    content = hashlib.sha1(usedforsecurity=False)
    for source in _kernel_sources(package):
        content.update(source)
    family = f"viscorod-{hashlib.sha1(str(package).encode(), usedforsecurity=False).hexdigest()[:8]}-"
    given = _config.CACHE_DIR
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for base in [Path(given)] if given else [package / "__pycache__", user / "viscorod"]:
        folder = base / f"{family}{content.hexdigest()[:16]}"
        try:
            if not folder.is_dir():
                for earlier in base.glob(f"{family}*"):
                    shutil.rmtree(earlier, ignore_errors=True)
                folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:  # not writable
            continue
        return folder
    return None


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
    folder, given = cache_folder(), _config.CACHE_DIR
    _config.CACHE_DIR = given if folder is None else str(folder)
    compiled: Any = _njit(
        cache=True,
        error_model="numpy",
        fastmath=fast,
        no_cfunc_wrapper=True,
        nogil=True,
        pipeline_class=kernel_compiler(),
        _nrt=_allocates(function),
    )(function)
    _config.CACHE_DIR = given
    if folder is not None:
        name = f"{function.__module__}.{function.__name__}"
        compiled._cache = ClaimedCache(compiled._cache, folder / f"{name}.claim")
    KERNELS.append(compiled)
    return cast(Kernel, compiled)


def on_disk(compiled: Any) -> bool:
    """Return whether there is machine code of a kernel on disk."""
    function = compiled.py_func
    stem = f"{function.__module__.rpartition('.')[2]}.{function.__name__}-{function.__code__.co_firstlineno}."
    return any(Path(compiled.stats.cache_path).glob(f"{stem}*.nbi"))


def lane_kernel(function: Kernel) -> Kernel:
    """Compile ``function`` into its callers only, without reference counts.

    Loops over lanes vectorise where row lengths are constants, formulas stay in registers, and parts of a step take
    bundles of arrays without a copy of all that describes them.
    """
    return _inlined(function, _FAST)


def loop_part(function: Kernel) -> Kernel:
    """Do so with a part of a :func:`loop`: bit for bit, its numbers are those of Python."""
    return _inlined(function, False)


def _inlined(function: Kernel, fast: set[str] | bool) -> Kernel:
    if PURE_PYTHON:
        return function
    compiled = _njit(
        error_model="numpy",
        fastmath=fast,
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
            "viscorod: compiling the kernels that this kind of model needs, once, for about a quarter of a minute"
        )


def announce_compilation(largest: Any) -> None:
    """Warn if the kernel ``largest`` still has to be compiled, and get help."""
    if _uncompiled(largest):
        logging.getLogger("viscorod").warning(
            "viscorod: compiling its kernels, once, for about half a minute; later runs start at once "
            "(viscorod warmup compiles all of them)"
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
