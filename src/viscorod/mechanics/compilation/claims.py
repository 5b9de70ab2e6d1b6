"""Claims on kernels: each is compiled by one process; another that needs it waits, and reads it from disk."""

from __future__ import annotations

import time
import zlib
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


def _claimed(place: Path) -> IO[bytes] | None:
    """Wait until a file is locked here; None where that cannot be, or takes too long."""
    try:
        file = place.open("wb")
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
            return file
    file.close()
    return None


class ClaimedCache:
    """Numba's cache of one kernel on disk, ``cache``; a process that finds nothing claims and compiles the kernel.

    The claim is a locked file, one for each signature, since variants of a large kernel are compiled beside each other;
    it is released when the kernel is saved or the process ends. The index of all signatures, ``place`` locked, is
    written by one process at a time.
    """

    def __init__(self, cache: Any, place: Path) -> None:
        self._cache, self._place = cache, place
        self._claims: dict[Any, IO[bytes]] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cache, name)

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the compiled kernel from disk, None if the caller has to compile it."""
        found = self._cache.load_overload(signature, target_context)
        if found is not None or signature in self._claims:
            return found
        variant = zlib.crc32(str(signature).encode())
        claim = _claimed(self._place.with_name(f"{self._place.stem}-{variant:08x}{self._place.suffix}"))
        if claim is None:
            return None
        found = self._cache.load_overload(signature, target_context)
        if found is None:
            self._claims[signature] = claim
        else:
            claim.close()
        return found

    def save_overload(self, signature: Any, data: Any) -> None:
        """Save the compiled kernel on disk and release the claim."""
        index = _claimed(self._place)
        try:
            self._cache.save_overload(signature, data)
        finally:
            for file in (index, self._claims.pop(signature, None)):
                if file is not None:
                    file.close()
