"""Small files of a journal, each with a checksum at its end: each is whole and of this journal, or is refused."""

from __future__ import annotations

import os
import struct
import zlib
from contextlib import suppress
from pathlib import Path

from viscorod.errors import InputError

__all__ = ["IDENTITY", "read_sealed", "write_sealed"]

IDENTITY = 8
"""Bytes that tell journals apart."""

_WORD = b"viscorod"
_SEAL = struct.Struct(f"<8s{IDENTITY}sQI")


def write_sealed(
    path: Path, content: bytes | memoryview, identity: bytes, before: Path | None = None
) -> None:
    """Write a file beside its place, to the disk itself, and put it there; its predecessor becomes ``before``.

    Raises:
        OSError: it cannot be written; what was there is still there.
    """
    new = path.with_name(f"new-{path.name}")
    seal = _SEAL.pack(_WORD, identity, len(content), zlib.crc32(content, zlib.crc32(identity)))
    with new.open("wb", buffering=0) as file:
        for part in (content, seal):
            rest = memoryview(part)
            while rest:
                rest = rest[file.write(rest) :]
        os.fsync(file.fileno())
    if before is not None:
        with suppress(FileNotFoundError):
            path.replace(before)
    new.replace(path)


def read_sealed(path: Path, identity: bytes | None = None) -> tuple[bytes, bytes]:
    """Return the content of a file and the identity of its journal, which has to be the given one.

    Raises:
        FileNotFoundError: there is none. InputError: it is damaged, or of another journal.
    """
    try:
        whole = path.read_bytes()
    except FileNotFoundError:
        raise
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error})") from None
    content, seal = whole[: -_SEAL.size], whole[-_SEAL.size :]
    word, found, length, checksum = _SEAL.unpack(seal) if len(seal) == _SEAL.size else (b"", b"", 0, 0)
    if word != _WORD or length != len(content) or checksum != zlib.crc32(content, zlib.crc32(found)):
        raise InputError(f"{path} is damaged, or was written by another version of viscorod")
    if identity is not None and found != identity:
        raise InputError(f"{path} belongs to another run")
    return content, found
