"""Parts of kernels, which have no entry from Python, made callable."""

from __future__ import annotations

import functools
import inspect

import numba


@functools.lru_cache
def from_python(part):
    """Return a compiled function with the parameters of ``part`` that calls it."""
    names = ", ".join(inspect.signature(part).parameters)
    scope = {"part": part}
    exec(f"def call({names}):\n    return part({names})\n", scope)
    return numba.njit(scope["call"])
