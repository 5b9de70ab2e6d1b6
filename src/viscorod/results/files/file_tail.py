"""The tail of a result file: checksums of all bytes that are not values of arrays, looked at before HDF5 is.

Texts, attributes and tables of a damaged HDF5 file can send the library into an endless loop or end the process, so
their bytes are compared first, without it. What follows the end that an HDF5 file states is invisible to it and to any
program that reads it. The tail is a JSON text, ``{"bytes": [[first, last + 1, CRC-32], ...]}``, then its length and
its CRC-32 (four bytes each, largest first) and the word "viscorod". Values of arrays have checksums of their own
(``checksums``), so that a large file can be opened without reading all of it.
"""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any, BinaryIO

from viscorod.errors import InputError

__all__ = ["require_tail_fits", "write_tail"]

_END = struct.Struct(">II8s")
_WORD = b"viscorod"
_AT_ONCE = 1 << 20


def write_tail(path: Path) -> None:
    """Append the tail to a closed file.

    Raises:
        OSError: it cannot be read or written.
    """
    import h5py

    values: list[tuple[int, int]] = []

    def look(_name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.chunks and item.size:
            item.id.chunk_iter(lambda chunk: values.append((chunk.byte_offset, chunk.size)))

    with h5py.File(path, "r") as file:
        file.visititems(look)
    size = path.stat().st_size
    begin, parts = 0, []
    for offset, length in [*sorted(values), (size, 0)]:
        if offset > begin:
            parts.append((begin, offset))
        begin = offset + length
    with path.open("r+b") as stream:
        sums = [(first, last, _sum_of(stream, first, last)) for first, last in parts]
        text = json.dumps({"bytes": sums}, separators=(",", ":")).encode()
        stream.seek(size)
        stream.write(text + _END.pack(len(text), zlib.crc32(text), _WORD))


def require_tail_fits(path: Path) -> None:
    """Compare a file with its tail; another program that opens a file to write cuts it off, and then there is none.

    Raises:
        InputError: the file is damaged.
        OSError: it cannot be read.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        if size < _END.size:
            return
        stream.seek(size - _END.size)
        length, checksum, word = _END.unpack(stream.read(_END.size))
        begin = size - _END.size - length
        if word != _WORD or begin < 0:
            return
        stream.seek(begin)
        text = stream.read(length)
        if zlib.crc32(text) != checksum:
            raise _damaged(path, "its checksums do not fit themselves")
        parts = json.loads(text)["bytes"]
        if parts and max(last for _, last, _ in parts) > begin:
            raise _damaged(path, "a part of it is missing")
        for first, last, known in parts:
            if _sum_of(stream, first, last) != known:
                raise _damaged(path, f"bytes {first} to {last} are not those that were written")


def _sum_of(stream: BinaryIO, first: int, last: int) -> int:
    stream.seek(first)
    found = 0
    while first < last:
        part = stream.read(min(_AT_ONCE, last - first))
        if not part:
            break
        found = zlib.crc32(part, found)
        first += len(part)
    return found


def _damaged(path: Path, why: str) -> InputError:
    return InputError(f"{path} is damaged: {why}; take another copy of the file, or compute it again")
