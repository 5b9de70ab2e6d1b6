"""How kernels are compiled: once, cached on disk, with fused multiply-add but otherwise strict floating point."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def kernel(function: Kernel) -> Kernel:
    """Compile ``function`` with Numba at its first call and keep the machine code on disk."""
    compiled: Any = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})(function)
    return cast(Kernel, compiled)


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
    """Say so if the machine code of the kernel ``largest`` is neither in memory nor on disk yet."""
    folder = Path(largest.stats.cache_path)
    stem = f"{largest.py_func.__module__.rpartition('.')[2]}.{largest.py_func.__name__}-"
    if not largest.signatures and not any(folder.glob(f"{stem}*.nbi")):
        logging.getLogger("viscorod").warning(
            "viscorod: compiling its kernels, once, for about half a minute; later runs start at once"
        )
