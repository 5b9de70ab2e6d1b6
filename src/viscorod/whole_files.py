"""Files that viscorod writes: each is written beside its place and takes it when it is whole.

So a full disk, an interrupt, a killed process or a power cut leaves what was there before, never a part of a file
under its name.
"""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from viscorod.errors import InputError

__all__ = ["make_durable", "page_path", "replacing", "system_errors", "why_not"]

NO_ROOM = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))
"""What the system says where a disk, a quota or a limit on the size of files is exhausted."""
PAGES = (".html", ".htm")
"""Suffixes of pages."""


def page_path(path: str | Path) -> Path:
    """Return the path of a page, which a browser opens by its suffix.

    Raises:
        InputError: it has another one.
    """
    path = Path(path)
    if path.suffix.lower() not in PAGES:
        raise InputError(
            f"{path}: the suffix {path.suffix!r} is not that of a page; use {' or '.join(PAGES)}"
        )
    return path


@contextmanager
def replacing(path: str | Path, *, needs: float = 0.0, instead: str = "name another place") -> Iterator[Path]:
    """Yield a place beside ``path`` to write a file to, which replaces ``path`` at the end; its folder is made.

    If anything fails, ``path`` is what it was. Devices and pipes are written as they are.

    Args:
        path: of the file; a link stays, and the file that it names is replaced.
        needs: bytes of the file, as far as they are known, for the message.
        instead: what to do where it cannot be written.

    Raises:
        InputError: the place cannot be written.
    """
    with system_errors(Path(path), needs, instead):
        target = Path(os.path.realpath(path))
        target.parent.mkdir(parents=True, exist_ok=True)
        there = target.exists()
        if there and not target.is_file() and not target.is_dir():
            yield target
            return
        new = target.with_name(f"new-{secrets.token_hex(4)}{target.suffix}")
        try:
            yield new
            if there:
                shutil.copymode(target, new)
            _to_disk(new)
            new.replace(target)
            make_durable(target.parent)
        except BaseException:
            new.unlink(missing_ok=True)
            raise


@contextmanager
def system_errors(path: Path, needs: float = 0.0, instead: str = "name another place") -> Iterator[None]:
    """Turn what the system says of a place that cannot be written into one message; see :func:`replacing`.

    Raises:
        InputError: the place cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"{path} cannot be written ({why_not(error, path, needs)}); {instead}") from None


def why_not(error: OSError, path: Path, needs: float = 0.0) -> str:
    """Say why a place cannot be written; where there is no room, also how much is needed and free."""
    text = str(error.strerror or error)
    if error.errno not in NO_ROOM:
        return text
    there = next((place for place in path.absolute().parents if place.is_dir()), None)
    if needs:
        text += f"; {_size(needs)} are needed"
    if there is not None:
        text += f"{' and' if needs else ';'} {_size(shutil.disk_usage(there).free)} are free on the disk"
    return text


def _to_disk(path: Path) -> None:
    """Let the system write a file to the disk: what takes a name has to be there before the name is.

    Raises:
        OSError: the disk is full, or gone.
    """
    if path.is_file():  # a folder, and no device, may have been written
        with path.open("rb+") as file:
            os.fsync(file.fileno())


def make_durable(folder: Path) -> None:
    """Let the system write the entries of a folder to the disk, so that they survive a power cut, where it can."""
    with suppress(OSError):  # Windows opens no folders, and some file systems have no need
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _size(count: float) -> str:
    """Return a number of bytes in words."""
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count:.0f} bytes"
