"""Small files of a journal, each with a checksum at its end: each is whole and of this journal, or is refused.

What a journal cannot be read without is there twice: the file, and its twin beside it.
"""

from __future__ import annotations

import os
import struct
import zlib
from contextlib import suppress
from pathlib import Path

from viscorod.errors import InputError
from viscorod.whole_files import make_durable, system_errors

__all__ = ["IDENTITY", "mend_twins", "read_sealed", "read_twins", "twin", "write_sealed", "write_twins"]

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


def twin(path: Path) -> Path:
    """Return the place of the second copy of a file."""
    return path.with_name(f"{path.stem}.twin{path.suffix}")


def write_twins(path: Path, content: bytes | memoryview, identity: bytes) -> None:
    """Write a file and its twin, the file last; see :func:`write_sealed`.

    Raises:
        OSError: they cannot be written.
    """
    for place in (twin(path), path):
        write_sealed(place, content, identity)


def read_twins(path: Path, identity: bytes | None = None) -> tuple[bytes, bytes, str]:
    """Return what :func:`read_sealed` does, of the twin where the file is damaged or missing; and what is wrong.

    Raises:
        FileNotFoundError: there is neither. InputError: neither is whole.
    """
    try:
        return *read_sealed(path, identity), ""
    except (FileNotFoundError, InputError) as error:
        wrong = f"{path} is missing" if isinstance(error, FileNotFoundError) else str(error)
        try:
            found = read_sealed(twin(path), identity)
        except FileNotFoundError:
            raise error from None
        except InputError as other:
            raise InputError(f"{wrong}; {other}") from None
        return *found, f"{wrong}: its twin {twin(path).name} was read instead"


def mend_twins(path: Path, identity: bytes | None = None) -> str:
    """Make a file that is damaged or missing again from its whole twin, or the twin from the file; say so, or "".

    Raises:
        FileNotFoundError: there is neither. InputError: neither is whole, or the disk takes no other one.
    """
    content, found, wrong = read_twins(path, identity)
    other, whole = (path, twin(path)) if wrong else (twin(path), path)
    try:
        if not wrong and read_sealed(other, found)[0] == content:
            return ""
    except (FileNotFoundError, InputError):
        pass
    with system_errors(other):
        write_sealed(other, content, found)
        make_durable(other.parent)
    return f"{other} was damaged or missing: it was made again from {whole.name}"
