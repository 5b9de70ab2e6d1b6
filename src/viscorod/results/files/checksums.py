"""Checksums of result files: a file that is not as it was written is refused, with the name of what changed.

HDF5 keeps a Fletcher-32 checksum with every piece of an array, and checksums of its own tables (from format 1.10 on).
These do not see a piece whose bytes are zero, its checksum too, as a gap in a copy leaves it, and not texts and
attributes. So the file has an attribute ``checksums``, a JSON text: CRC-32 of every attribute, of type, shape and
attributes of every array, and of the values of every piece of it. Any program can read the file; one that changes it
makes it another file, which viscorod refuses until it is given as a data set.
"""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.pieces_of_arrays import cuts
from viscorod.results.files.plain_file import is_bare

__all__ = ["FORMAT", "NAME", "Sums", "checksum", "require_unchanged", "seal", "stored_sums"]

NAME = "checksums"
"""The attribute of the file that holds them."""
FORMAT = ("v110", "v110")
"""Format of HDF5 whose own tables have checksums; netCDF reads it since 2016."""
_DERIVED = {"REFERENCE_LIST"}  # attributes in which HDF5 keeps addresses

Sums: TypeAlias = list[int]
"""Checksum of every piece of an array, in the order of ``cuts``."""


def seal(file: Any) -> None:
    """Write the checksums of all that an open file holds into it; it is read in pieces for that.

    Raises:
        OSError: it cannot be read or written.
    """
    import h5py

    file.attrs.pop(NAME, None)
    about: dict[str, Any] = {}
    values: dict[str, Sums] = {}
    for name, item in _items(file):
        about[name] = _about(item)
        if isinstance(item, h5py.Dataset) and not is_bare(item):
            values[name] = _sums(item)
    file.attrs[NAME] = json.dumps({"about": about, "values": values}, separators=(",", ":"))


def stored_sums(file: Any) -> dict[str, Any] | None:
    """Return what ``seal`` wrote into an open file; None if it has none, as those of version 0.1.0.

    Raises:
        ValueError: what is there are no checksums.
    """
    if NAME not in file.attrs:
        return None
    found = json.loads(file.attrs[NAME])
    about, values = (found.get("about"), found.get("values")) if isinstance(found, dict) else (None, None)
    if not isinstance(about, dict) or not isinstance(values, dict):
        raise ValueError(f"the attribute {NAME} holds no checksums")
    if not all(isinstance(part, dict) for part in about.values()):
        raise ValueError(f"the attribute {NAME} holds no checksums")
    return {"about": about, "values": values}


def require_unchanged(file: Any, sums: dict[str, Any], path: Path) -> None:
    """Refuse an open file whose attributes, arrays or texts are not those that were written; numbers come later.

    Raises:
        InputError: it is damaged, or was changed.
    """
    import h5py

    found: dict[str, Any] = dict(_items(file))
    for name in sums["about"].keys() | sums["values"].keys() | found.keys():
        if name not in sums["about"]:
            raise _changed(path, f"{name[1:]} was not there when it was written")
        if name not in found:
            raise _changed(path, f"{name[1:]} is missing")
        now, then = _about(found[name]), sums["about"][name]
        for part in now.keys() | then.keys():
            if now.get(part) != then.get(part):
                raise _changed(path, _part_in_words(name, part, missing=part not in now))
    for name, item in found.items():
        if isinstance(item, h5py.Dataset) and not is_bare(item):
            then = sums["values"].get(name)
            if not item.chunks or item.dtype.kind == "O":  # single numbers, and texts, empty ones too
                if then != _sums(item):
                    raise _changed(path, f"the values of {name[1:]} are others")
            elif not isinstance(then, list) or len(then) != _count(item):
                raise _changed(path, f"{name[1:]} has pieces without checksums")


def _changed(path: Path, what: str) -> InputError:
    return InputError(
        f"{path} is damaged, or another program changed it: {what}; take another copy of the file, or compute it again"
    )


def _part_in_words(name: str, part: str, *, missing: bool) -> str:
    of = f" of {name[1:]}" if name != "/" else ""
    if part == "":
        return f"type or shape{of} is another one"
    return f"the attribute {part}{of} {'is missing' if missing else 'is another one'}"


def _items(file: Any) -> list[tuple[str, Any]]:
    """Return all groups and arrays of a file with their paths, the file itself first."""
    found: list[tuple[str, Any]] = [("/", file)]
    file.visititems(lambda name, item: found.append((f"/{name}", item)))
    return found


def _about(item: Any) -> dict[str, int]:
    """Return the checksum of every attribute of a group or array, and under "" that of its type and shape."""
    import h5py

    found = {name: _of_attribute(item, name) for name in item.attrs if name not in _DERIVED and name != NAME}
    if isinstance(item, h5py.Dataset):
        text = h5py.check_string_dtype(item.dtype) is not None
        kind = "text" if text else item.dtype.str
        found[""] = _of_text(json.dumps([kind, item.shape, item.chunks]))
    return found


def _of_attribute(item: Any, name: str) -> int:
    import h5py

    value = item.attrs[name]
    if name == "DIMENSION_LIST":  # references to the dimensions, which have names
        return _of_text(json.dumps([[item.file[reference].name for reference in side] for side in value]))
    if isinstance(value, h5py.Empty):
        return _of_text("nothing")
    array = np.asarray(value)
    if array.dtype.kind in "OUS":
        return _of_text(json.dumps([str(array.shape), *(_text(one) for one in array.ravel().tolist())]))
    return checksum(array, _of_text(f"{array.dtype.str} {array.shape}"))


def _sums(item: Any) -> Sums:
    """Return the checksums of all pieces of an array; of texts and single numbers, the one of all."""
    if item.dtype.kind == "O":
        values = np.asarray(item[()], dtype=object).ravel().tolist()
        return [_of_text(json.dumps([_text(value) for value in values]))]
    if not item.chunks:
        return [checksum(np.asarray(item[()]))]
    return [checksum(item[cut]) for cut in cuts(item.shape, item.chunks)]


def _count(item: Any) -> int:
    return sum(1 for _ in cuts(item.shape, item.chunks)) if item.chunks else 1


def checksum(values: np.ndarray, start: int = 0) -> int:
    """Return the CRC-32 of the numbers of an array, as they are in memory."""
    return zlib.crc32(np.ascontiguousarray(values).data.cast("B") if values.size else b"", start)


def _of_text(text: str) -> int:
    return zlib.crc32(text.encode("utf-8", "surrogatepass"))


def _text(value: Any) -> str:
    return value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else str(value)
