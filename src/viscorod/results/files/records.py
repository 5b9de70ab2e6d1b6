"""The states of a journal: records of one size, each with a checksum of its numbers, its place and its journal."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CHUNK", "Layout", "RecordFile", "octets"]

CHUNK = 16e6
"""Bytes that are read at once."""
_CHECKSUM = "checksum of the record"


def octets(rows: np.ndarray) -> memoryview:
    """Return records as they lie in memory."""
    content: Any = np.ascontiguousarray(rows).view(np.uint8)
    return memoryview(content)


class Layout:
    """What a record holds.

    Args:
        fields: name, type and shape of the values of each variable.
        identity: of the journal.

    Attributes:
        dtype: of a record.
    """

    def __init__(self, fields: list[tuple[str, str, tuple[int, ...]]], identity: bytes) -> None:
        self.dtype = np.dtype([*fields, (_CHECKSUM, "<u8")])
        self.names = [name for name, *_ in fields]
        self._identity = identity

    def records(self, data: xr.Dataset, begin: int) -> np.ndarray:
        """Return the states of a data set as records from number ``begin`` on."""
        rows = np.zeros(len(data.variables[self.names[0]]), dtype=self.dtype)
        for name in self.names:
            rows[name] = data.variables[name].values
        rows[_CHECKSUM] = self._sums(rows, begin)
        return rows

    def whole(self, rows: np.ndarray, begin: int) -> int:
        """Return how many records, from number ``begin`` on, are whole before the first that is not."""
        wrong = np.flatnonzero(rows[_CHECKSUM] != self._sums(rows, begin))
        return int(wrong[0]) if wrong.size else len(rows)

    def _sums(self, rows: np.ndarray, begin: int) -> list[int]:
        size = self.dtype.itemsize
        content = octets(rows)
        end = self.dtype.fields[_CHECKSUM][1] if self.dtype.fields else 0
        found = []
        for k in range(len(rows)):
            start = zlib.crc32(self._identity + (begin + k).to_bytes(8, "little"))
            found.append(zlib.crc32(content[k * size : k * size + end], start))
        return found


class RecordFile:
    """The file of states, to be read.

    Attributes:
        count: records that are there, whole or not.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        self.path, self.layout = path, layout
        try:
            self.count = path.stat().st_size // layout.dtype.itemsize
        except OSError as error:
            raise InputError(f"{path} cannot be read ({error.strerror or error})") from None

    def whole(self, most: int | None = None) -> int:
        """Return how many records are whole before the first that is not, of ``most`` at most."""
        most = self.count if most is None else min(most, self.count)
        done = 0
        for rows in self._pieces(most):
            found = self.layout.whole(rows, done)
            done += found
            if found < len(rows):
                break
        return done

    def rows(self, count: int, *, in_memory: bool) -> np.ndarray:
        """Return the first records; those that are not in memory are read when they are looked at."""
        if not count:
            return np.empty(0, self.layout.dtype)
        if in_memory:
            return np.fromfile(self.path, dtype=self.layout.dtype, count=count)
        return np.memmap(self.path, dtype=self.layout.dtype, mode="r", shape=(count,))

    def require_whole(self, rows: np.ndarray, part: slice) -> None:
        """Refuse records, of those that :meth:`rows` returned, that are not what was written.

        Raises:
            InputError: one is not.
        """
        begin = part.start
        found = self.layout.whole(np.ascontiguousarray(rows[part]), begin)
        if begin + found < part.stop:
            raise InputError(
                f"{self.path} is damaged: state number {begin + found} is not the one that was written"
            )

    def _pieces(self, count: int) -> Iterator[np.ndarray]:
        step = max(1, int(CHUNK // self.layout.dtype.itemsize))
        try:
            with self.path.open("rb") as file:
                for begin in range(0, count, step):
                    yield np.fromfile(file, dtype=self.layout.dtype, count=min(step, count - begin))
        except OSError as error:
            raise InputError(f"{self.path} cannot be read ({error.strerror or error})") from None
