"""A file that HDF5 writes to and that never fails while it does.

HDF5 keeps parts of a file in memory. If it cannot write them when the file is closed, its objects stay half closed, and
what touches them next, often Python when it tidies up, ends the whole process. So HDF5 writes through this object:
what the system refuses is kept in memory, the file is closed in order, and the error is raised after that.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = ["Hdf5Output", "hdf5_output", "uninterrupted"]


@contextmanager
def hdf5_output(path: Path) -> Iterator[Hdf5Output]:
    """Yield a new file at ``path`` for HDF5, which is on the disk itself at the end.

    Raises:
        OSError: something of it could not be written.
    """
    output = Hdf5Output(path)
    try:
        yield output
        output.require_written()
        os.fsync(output.handle)
    finally:
        os.close(output.handle)


class Hdf5Output:
    """A file for ``h5py.File(output, "w")``, which asks for the methods of binary files of Python.

    Attributes:
        error: the first that the system raised; from there on everything is kept in memory.
    """

    def __init__(self, path: Path) -> None:
        self.handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
        self.error: OSError | None = None
        self._kept: list[tuple[int, bytes]] = []
        self._place = self._end = 0

    def require_written(self) -> None:
        """Raise what the system said where something could not be written."""
        if self.error is not None:
            raise self.error

    def abandon(self) -> None:
        """Let the next look at errors end the work."""
        self.error = self.error or InterruptedError(errno.EINTR, "interrupted")

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place, from the start or from the end."""
        self._place = offset + (self._end if whence == os.SEEK_END else 0)
        return self._place

    def tell(self) -> int:
        """Return the present place."""
        return self._place

    def write(self, data: Any) -> int:
        """Write all of it."""
        content = memoryview(data).cast("B")
        done = 0
        while done < len(content) and self.error is None:
            try:
                os.lseek(self.handle, self._place + done, os.SEEK_SET)
                done += os.write(self.handle, content[done:])
            except OSError as error:
                self.error = error
        if done < len(content):
            self._kept.append((self._place + done, bytes(content[done:])))
        self._place += len(content)
        self._end = max(self._end, self._place)
        return len(content)

    def readinto(self, buffer: Any) -> int:
        """Read into all of a buffer; zeros where nothing was written."""
        target = memoryview(buffer).cast("B")
        begin, end = self._place, self._place + len(target)
        target[:] = bytes(len(target))
        done = 0
        os.lseek(self.handle, begin, os.SEEK_SET)
        while done < len(target) and (part := os.read(self.handle, len(target) - done)):
            target[done : done + len(part)] = part
            done += len(part)
        for at, kept in self._kept:
            first, last = max(at, begin), min(at + len(kept), end)
            if first < last:
                target[first - begin : last - begin] = kept[first - at : last - at]
        self._place = end
        return len(target)

    def read(self, size: int) -> bytes:
        """Return so many bytes."""
        found = bytearray(size)
        self.readinto(found)
        return bytes(found)

    def truncate(self, size: int) -> int:
        """Make the file so long."""
        self._end = size
        if self.error is None:
            try:
                os.ftruncate(self.handle, size)
            except OSError as error:
                self.error = error
        return size

    def flush(self) -> None:
        """Do nothing: nothing waits in memory."""


def uninterrupted(work: Callable[[], None], abandon: Callable[[], None]) -> None:
    """Do some work with HDF5 in a thread of its own, where no interrupt reaches it within HDF5.

    Args:
        work: to do.
        abandon: called when an interrupt comes, so that the work ends soon; it is waited for.
    """
    with ThreadPoolExecutor(max_workers=1) as pool:
        future = pool.submit(work)
        try:
            future.result()
        except KeyboardInterrupt:
            abandon()
            raise
