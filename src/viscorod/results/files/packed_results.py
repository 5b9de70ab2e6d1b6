"""Whole results of members on their way: appended to one file per writer, each an archive of NumPy's with a checksum.

A netCDF file takes longer to write than a short motion takes to compute, and as long to read. What is packed here has
the same arrays and attributes, and NumPy reads it, too: a result is what ``numpy.savez`` writes, with names and
attributes as JSON beside the arrays. Every entry of such an archive has a CRC-32, which is compared when it is read.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.storage import result_of
from viscorod.results.stacked_members import layout_of, plain

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.any_result import AnyResult

__all__ = ["PackedResult", "append", "packed", "unpacked"]

ABOUT, ARRAY = "about", "array/"
"""Entries of the archive: JSON, and the arrays by their names."""


@dataclass(frozen=True, slots=True)
class PackedResult:
    """The whole result of a member, where it lies; a call reads it.

    Attributes:
        path: of the file of its writer.
        offset, length: bytes of it.
        layout: what it shares with the results on which it can be stacked (``layout_of``); empty if that is not known.
    """

    path: Path
    offset: int
    length: int
    layout: str = ""

    @property
    def there(self) -> bool:
        """Whether the file is there and long enough: the system may lose its end when the power fails."""
        try:
            return self.path.stat().st_size >= self.offset + self.length
        except OSError:
            return False

    def __call__(self) -> AnyResult:
        """Return the result.

        Raises:
            InputError: it cannot be read, or is damaged.
        """
        return result_of(self.data(), self.path)

    def data(self) -> xr.Dataset:
        """Return its data set.

        Raises:
            InputError: it cannot be read, or is damaged.
        """
        try:
            with self.path.open("rb") as file:
                file.seek(self.offset)
                return unpacked(file.read(self.length))
        except OSError as error:
            raise InputError(f"{self.path} cannot be read ({error.strerror or error})") from None
        except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            why = " ".join(str(error).split())[:120] or type(error).__name__
            raise InputError(
                f"{self.path} is damaged ({why}); remove it and compute the sweep again in its folder"
            ) from None


def append(path: Path, data: xr.Dataset) -> PackedResult:
    """Append a result to the file of a writer, which is made if it is not there; returns where it lies.

    What is left of an append that was cut off lies before it and is never read.

    Raises:
        OSError: it cannot be written.
    """
    content = packed(data)
    with path.open("ab") as file:
        offset = file.seek(0, io.SEEK_END)
        file.write(content)
    return PackedResult(path, offset, len(content), layout_of(data))


def packed(data: xr.Dataset) -> bytes:
    """Return a data set as an archive."""
    variables = {str(name): variable for name, variable in data.variables.items()}
    about = {
        "attributes": data.attrs,
        "coordinates": [str(name) for name in data.coords],
        "variables": {name: [v.dims, v.attrs] for name, v in variables.items()},
    }
    text = np.frombuffer(json.dumps(about, default=plain).encode(), np.uint8)
    arrays: dict[str, Any] = {ABOUT: text}
    arrays |= {f"{ARRAY}{name}": _readable(v.values) for name, v in variables.items()}
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def unpacked(content: bytes) -> xr.Dataset:
    """Return the data set of an archive.

    Raises:
        ValueError, KeyError, TypeError, zipfile.BadZipFile, zlib.error: it is damaged, or none.
    """
    import xarray as xr

    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        about: dict[str, Any] = json.loads(arrays[ABOUT].tobytes())
        variables = {
            name: (dims, arrays[f"{ARRAY}{name}"], attrs)
            for name, (dims, attrs) in about["variables"].items()
        }
    coordinates = {name: variables.pop(name) for name in about["coordinates"]}
    return xr.Dataset(variables, coordinates, about["attributes"])


def _readable(values: np.ndarray) -> np.ndarray:
    """Return texts that are objects of Python as those of NumPy."""
    return values.astype(str) if values.dtype == object else values
