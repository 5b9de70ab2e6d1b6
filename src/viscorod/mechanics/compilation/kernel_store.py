"""Where Numba looks for the machine code of a kernel: in the wheel, then in the folder of this machine."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

from viscorod.mechanics.compilation.claims import ClaimedCache
from viscorod.mechanics.compilation.machine_code import cache_folder, kept, shipped

__all__ = ["KernelStore"]


class KernelStore:
    """Machine code of one kernel on disk, in the place of Numba's own cache; nothing is opened before it is needed."""

    def __init__(self, function: Callable[..., object]) -> None:
        self._function = function

    @cached_property
    def _shipped(self) -> Any:
        return shipped(self._function)

    @cached_property
    def _kept(self) -> Any:
        folder, cache = cache_folder(), kept(self._function)
        if folder is None:
            return None
        return ClaimedCache(
            cache, folder / f"{self._function.__module__}.{self._function.__qualname__}.claim"
        )

    @property
    def cache_path(self) -> str | None:
        """The folder that machine code is written to; None if nothing is kept."""
        return None if self._kept is None else str(self._kept.cache_path)

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the machine code for one signature, None if it has to be compiled."""
        for cache in (self._shipped, self._kept):
            found = None if cache is None else cache.load_overload(signature, target_context)
            if found is not None:
                return found
        return None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep what was compiled here."""
        if self._kept is not None:
            self._kept.save_overload(signature, data)

    def filled(self) -> bool:
        """Return whether there is any machine code of the kernel."""
        function: Any = self._function
        module = function.__module__.rpartition(".")[2]
        stem = f"{module}.{function.__name__}-{function.__code__.co_firstlineno}."
        return any(
            any(Path(cache.cache_path).glob(f"{stem}*.nbi"))
            for cache in (self._shipped, self._kept)
            if cache is not None
        )
