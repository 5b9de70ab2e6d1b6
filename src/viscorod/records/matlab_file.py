"""Columns of MATLAB files of all versions: vectors, columns of matrices, and fields of structures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError, let_interrupts_through
from viscorod.records.column_units import name_and_unit
from viscorod.records.columns import Columns, stacked

__all__ = ["columns_of_matlab"]


def columns_of_matlab(path: Path) -> Columns:
    """Return the vectors of a MATLAB file that are as long as the most, with units where their names end in one.

    Fields of a structure are named "data.tip", columns of a matrix "D(1)".

    Raises:
        InputError: it cannot be read, or has no vectors.
    """
    from scipy.io import loadmat

    try:
        try:
            content = loadmat(path, simplify_cells=True)
        except NotImplementedError:  # version 7.3 is HDF5
            content = _of_hdf5(path)
    except Exception as error:  # the readers fail in many ways on what is no MATLAB file
        let_interrupts_through(error)
        raise InputError(
            Fault(str(path), "", f"it cannot be read as MATLAB ({error})", "check the file")
        ) from None
    vectors: dict[str, tuple[str | None, np.ndarray]] = {}
    for label, array in _arrays(content):
        name, unit = name_and_unit(label)
        if array.ndim == 1:
            vectors[name] = unit, array
        else:
            vectors |= {f"{name}({k + 1})": (unit, array[:, k]) for k in range(array.shape[1])}
    if not vectors:
        raise InputError(
            Fault(str(path), "", "it has no vectors of numbers", "save times and values as vectors")
        )
    lengths = [len(vector) for _, vector in vectors.values()]
    usual = max(set(lengths), key=lengths.count)
    kept = {name: one for name, one in vectors.items() if len(one[1]) == usual}
    return stacked(
        str(path), list(kept), [one for _, one in kept.values()], [unit for unit, _ in kept.values()]
    )


def _arrays(content: Mapping[str, Any], above: str = "") -> list[tuple[str, np.ndarray]]:
    """Return vectors, and matrices with their longer side first, by name."""
    found = []
    for name, value in content.items():
        if name.startswith(("__", "#")):
            continue
        if isinstance(value, Mapping):
            found += _arrays(value, f"{above}{name}.")
            continue
        array = np.asarray(value)
        if array.dtype.kind not in "fiuc" or array.size < 2 or array.ndim > 2:
            continue
        if array.ndim == 2 and 1 in array.shape:
            array = array.ravel()
        elif array.ndim == 2 and array.shape[0] < array.shape[1]:
            array = array.T
        found.append((f"{above}{name}", array))
    return found


def _of_hdf5(path: Path) -> dict[str, Any]:
    """Return the numbers of a file of version 7.3; its arrays are stored with their dimensions reversed."""
    import h5py

    def read(group: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, one in group.items():
            if isinstance(one, h5py.Group):
                found[name] = read(one)
            elif one.dtype.kind in "fiu" and b"char" != one.attrs.get("MATLAB_class", b""):
                found[name] = np.asarray(one).T
        return found

    with h5py.File(path, "r") as file:
        return read(file)
