"""What a result file may consist of: groups and arrays of numbers and texts, all of it in the file itself.

HDF5 can do more: take the values of an array from any other file of the machine, link to other files, load filters,
hold objects, and declare arrays that were never written. None of that is in a result of viscorod, and files may come
from elsewhere.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from viscorod.errors import InputError, reading
from viscorod.limits import LARGEST_RESULT, MOST_DECLARED, MOST_PARTS

__all__ = ["is_bare", "require_levels_readable", "require_plain", "require_written"]


def require_plain(file: Any, path: Path) -> int:
    """Refuse an open file that holds more than a result may, before anything is made for it.

    Returns:
        bytes of all arrays together.

    Raises:
        InputError: something in it is outside of it, is too large, is not complete or is of another kind.
    """
    import h5py

    size, claimed, own, parts = path.stat().st_size, 0, 0, 0
    seen: set[Any] = set()
    groups: list[tuple[str, Any]] = [("", file)]
    while groups:
        prefix, group = groups.pop()
        for name in group:
            where = f"{prefix}{name}"
            parts += 1
            if parts > MOST_PARTS:
                raise _refused(path, f"it holds more than {MOST_PARTS} groups and arrays")
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise _refused(path, f"{where} is a link to another place")
            item = group[name]
            address = h5py.h5o.get_info(item.id).addr
            if address in seen:
                raise _refused(path, f"{where} is a second name for something else in the file")
            seen.add(address)
            if isinstance(item, h5py.Group):
                groups.append((f"{where}/", item))
            elif isinstance(item, h5py.Dataset):
                own = _bytes(item, where, path)
                claimed += own
            else:
                raise _refused(path, f"{where} is neither a group nor an array")
            if claimed > min(LARGEST_RESULT, MOST_DECLARED * size):
                what = f"{where} claims" if own == claimed else f"all arrays up to {where} claim"
                raise _refused(path, f"{what} {claimed / 1e9:.3g} GB in a file of {size / 1e6:.3g} MB")
    return claimed


def _bytes(item: Any, where: str, path: Path) -> int:
    """Return the bytes that an array claims, after looking at how it is stored."""
    import h5py

    if item.shape is None:
        raise _refused(path, f"{where} has no shape")
    text = h5py.check_string_dtype(item.dtype) is not None
    if not text and item.dtype.kind not in "fiub":
        raise _refused(path, f"{where} holds {item.dtype}, neither numbers nor texts")
    stored = item.id.get_create_plist()
    if stored.get_external_count():
        raise _refused(path, f"the values of {where} are in another file")
    if stored.get_layout() == h5py.h5d.VIRTUAL:
        raise _refused(path, f"{where} is put together from other files")
    own = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}
    if any(stored.get_filter(k)[0] not in own for k in range(stored.get_nfilters())):
        raise _refused(path, f"{where} needs a filter that results do not have")
    count = math.prod(item.shape)
    whole: int = max(count, math.prod(item.chunks or (0,)) if count else 0) * item.dtype.itemsize
    return whole


def require_written(file: Any, path: Path) -> None:
    """Refuse an open file with arrays of which a part was never written, in whose place HDF5 gives zeros.

    Raises:
        InputError: an array is not complete.
    """
    import h5py

    def look(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or not item.size or is_bare(item):
            return
        if item.chunks:
            sides = zip(item.shape, item.chunks, strict=True)
            whole, there = math.prod(-(-size // step) for size, step in sides), item.id.get_num_chunks()
        else:
            whole, there = item.size * item.dtype.itemsize, item.id.get_storage_size()
        if there < whole:
            raise _refused(path, f"{name} is not complete, {there} of {whole} parts are there")

    file.visititems(look)


def require_levels_readable(group: Any, path: Path) -> None:
    """Read the coordinates of dimensions once, which xarray reads when a file is opened.

    Raises:
        InputError: one is damaged; its name is given.
    """
    import h5py

    for name in group:
        item = group[name]
        if isinstance(item, h5py.Dataset) and item.is_scale and not is_bare(item):
            with reading(path, name):
                item[()]


def is_bare(item: Any) -> bool:
    """Return whether an array is a dimension only, which has a size and no values."""
    name = item.attrs.get("NAME", b"")
    text = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
    return text.startswith("This is a netCDF dimension but not a netCDF variable")


def _refused(path: Path, why: str) -> InputError:
    return InputError(f"{path} cannot be trusted: {why}; name a run.nc that viscorod wrote")
