"""One run at a time in a folder: whoever writes there holds a lock, which ends with the process at the latest.

The lock is the operating system's, on a file of the journal. It keeps other processes out and other threads of this
one; readers need none, since every file of a folder is whole or says that it is not.
"""

from __future__ import annotations

import errno
import os
import platform
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any
from weakref import WeakValueDictionary

from viscorod.errors import InputError, warn
from viscorod.results.files.journal_folder import FOLDER, LOCK, empty, holds_run
from viscorod.whole_files import system_errors

__all__ = ["claimed", "locked", "require_free", "require_stopped"]

_TRIES = 100
_FAR = 1 << 30  # where Windows locks a byte: it lets nobody read what is locked

_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
"""What systems say of a file system without locks, most of them one on a network."""

_guard = threading.Lock()
_held: WeakValueDictionary[str, FolderLock] = WeakValueDictionary()


@contextmanager
def claimed(folder: Path, *, resume: bool = False, anew: bool = False) -> Iterator[None]:
    """Keep a folder for one run, if it holds none that would be lost.

    Args:
        folder: of the run.
        resume: the run that was stopped there is to go on.
        anew: a run that was stopped there may be removed; the journal does so with the first state of another one.

    Raises:
        InputError: another run writes there, or one was stopped there and neither ``resume`` nor ``anew`` is said.
    """
    journal = folder / FOLDER
    if resume and not journal.is_dir():
        require_stopped(folder)
    with locked(folder):
        if resume:
            require_stopped(folder)
        elif holds_run(journal) and not anew:
            raise _would_be_lost(folder)
        yield


def _would_be_lost(folder: Path) -> InputError:
    return InputError(
        f"{folder} holds a run that was stopped; go on with it: viscorod resume {folder} (in Python resume=True), "
        "name another folder, or remove it and begin anew: --anew (anew=True)"
    )


def require_stopped(folder: Path) -> None:
    """Refuse a folder without a run that was stopped.

    Raises:
        InputError: there is none.
    """
    if not holds_run(folder / FOLDER):
        there = (folder / "run.nc").is_file()
        raise InputError(
            f"{folder} holds no run that was stopped"
            + (": the run in it is complete" if there else "; name the folder that viscorod run wrote to")
        )


def require_free(folder: Path, *, stopped: bool) -> None:
    """Refuse a folder in which a run is being written, before anything is computed for it.

    Args:
        folder: of the run.
        stopped: there may be one that was stopped.

    Raises:
        InputError: another run writes there, or one was stopped there that may not be.
    """
    if (folder / FOLDER).is_dir():
        with locked(folder):
            if holds_run(folder / FOLDER) and not stopped:
                raise _would_be_lost(folder)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder, which is made, against other writers.

    Raises:
        InputError: another one has locked it, or it cannot be written.
    """
    lock = FolderLock(folder)
    try:
        with system_errors(folder):
            lock.acquire()
        yield
    finally:
        lock.release()


class FolderLock:
    """The lock of a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._place = folder / FOLDER / LOCK
        self._key = os.path.realpath(folder)
        self._file: IO[bytes] | None = None
        self._mine = False

    def acquire(self) -> None:
        """Lock it.

        Raises:
            InputError: another one has.
        """
        with _guard:
            if self._key in _held:
                raise self._refused("this process, in another thread or call,")
            _held[self._key] = self
        for _ in range(_TRIES):
            self._place.parent.mkdir(parents=True, exist_ok=True)
            try:
                file = os.fdopen(os.open(self._place, os.O_RDWR | os.O_CREAT, 0o666), "r+b", buffering=0)
            except FileNotFoundError:  # the holder before is just tidying up
                continue
            self._file = file  # so that it is closed whatever comes
            locked = self._lock(file)
            if locked and not _is_at(file, self._place):
                file.close()
                continue
            self._mine = True
            with suppress(OSError):
                file.truncate(0)
                file.write(f"process {os.getpid()} on {platform.node() or 'this machine'}".encode())
            return
        raise OSError(errno.EAGAIN, "its lock is taken and left all the time")

    def _lock(self, file: IO[bytes]) -> bool:
        """Lock a file until it is closed, or its process ends; False where the file system has no locks."""
        try:
            _lock(file)
        except (BlockingIOError, PermissionError):
            holder = b""
            with suppress(OSError):
                holder = file.read(200)
            raise self._refused(holder.decode("utf-8", "replace")) from None
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise
            warn(
                f"{self.folder}: this file system has no locks ({error.strerror or error}), so that nothing keeps a "
                "second run out of this folder: let only one write there at a time"
            )
            return False
        return True

    def _refused(self, holder: str) -> InputError:
        return InputError(
            f"{self.folder} is in use: {holder or 'another process'} is computing a run there; wait until it ends, "
            "or name another folder"
        )

    def release(self) -> None:
        """Unlock it, and remove the file, what an interrupt left of a journal without a run, and what is empty then."""
        try:
            self._release()
        except KeyboardInterrupt:  # to the end, else an empty journal would stay
            self._release()
            raise

    def _release(self) -> None:
        file = self._file
        if file is not None and not file.closed:
            here = self._mine and (_is_at(file, self._place) or not self._place.exists())
            if os.name == "nt":  # which removes no open file
                file.close()
            if here:  # while it is locked, so that nobody has it by then
                with suppress(OSError):
                    if not holds_run(self._place.parent):
                        empty(self._place.parent)
                    self._place.unlink(missing_ok=True)
                    self._place.parent.rmdir()
            if self._mine and not file.closed:
                _unlock(file)
            file.close()
        with _guard:
            if _held.get(self._key) is self:
                del _held[self._key]


def _is_at(file: IO[bytes], place: Path) -> bool:
    """Return whether an open file is the one that is at a place."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), place.stat())
    except OSError:
        return False


def _lock(file: IO[bytes]) -> None:
    """Lock a file; BlockingIOError or PermissionError if another has it."""
    try:
        import fcntl
    except ImportError:
        import msvcrt

        windows: Any = msvcrt
        file.seek(_FAR)
        try:
            windows.locking(file.fileno(), windows.LK_NBLCK, 1)
        finally:
            file.seek(0)  # where the holder's name is read
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _unlock(file: IO[bytes]) -> None:
    """Unlock a file, also for processes that were forked from this one and have it open too."""
    try:
        import fcntl
    except ImportError:  # closing it does so
        return
    with suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_UN)
