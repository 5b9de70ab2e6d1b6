"""Claims on kernels: each is compiled by one process; another that needs it waits, and reads it from disk."""

from __future__ import annotations

import time
from pathlib import Path
from typing import IO, Any

PATIENCE = 300.0
"""Longest wait [s]; then the kernel is compiled here as well."""


def _lock(file: IO[bytes]) -> None:
    """Lock a file until it is closed, or its process ends; BlockingIOError or PermissionError if another has it."""
    try:
        import fcntl
    except ImportError:
        import msvcrt

        windows: Any = msvcrt
        windows.locking(file.fileno(), windows.LK_NBLCK, 1)
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


class ClaimedCache:
    """Numba's cache of one kernel on disk, ``cache``; a process that finds nothing claims and compiles the kernel.

    The claim is a locked file, ``place``; it is released when the kernel is saved or the process ends.
    """

    def __init__(self, cache: Any, place: Path) -> None:
        self._cache, self._place = cache, place
        self._claim: IO[bytes] | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cache, name)

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the compiled kernel from disk, None if the caller has to compile it."""
        found = self._cache.load_overload(signature, target_context)
        if found is not None or self._claim is not None:
            return found
        try:
            file = self._place.open("wb")
        except OSError:  # a folder that has become read-only keeps nothing, and needs no claims
            return None
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            try:
                _lock(file)
            except (BlockingIOError, PermissionError):
                time.sleep(0.02)
            except OSError:  # no locks in this file system
                break
            else:
                self._claim = file
                found = self._cache.load_overload(signature, target_context)
                if found is not None:
                    self._release()
                return found
        file.close()
        return None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Save the compiled kernel on disk and release the claim."""
        try:
            self._cache.save_overload(signature, data)
        finally:
            self._release()

    def _release(self) -> None:
        if self._claim is not None:
            self._claim.close()
            self._claim = None
