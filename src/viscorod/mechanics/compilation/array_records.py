"""What describes arrays, read from where NumPy keeps it: of 150 arrays at once, in microseconds.

NumPy's interface for C fixes the record of an array (``PyArrayObject_fields``): after the head of a Python object stand
the address of its entries, the number of dimensions, the addresses of shape and strides, the array that it is a view
of, the type of its entries, and flags. :data:`READABLE` says whether that is so here.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from viscorod.mechanics.compilation.compiled import PURE_PYTHON, loop
from viscorod.typing import Integers

__all__ = ["READABLE", "described", "lay_out"]

_HEAD = int(object.__basicsize__)
_ENTRIES, _DIMENSIONS, _SHAPE, _STRIDES, _TYPE, _FLAGS = (_HEAD + 8 * k for k in (0, 1, 2, 3, 5, 6))
_KIND = _HEAD + 8
"""Kind, byte order and number of a type, in one word of its own record."""

_C, _F, _OTHERS = 0x0001, 0x0002, 0x0500
"""Flags: the order of entries; whether they are aligned and may be written to."""
_HALF = 0xFFFFFFFF


def _word(_context: Any, address: Any) -> Any:
    """Return the word at an ``address``."""
    del address

    def generate(_lowering: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        (place,) = arguments
        return builder.load(builder.inttoptr(place, ir.PointerType(place.type)))

    return types.int64(types.int64), generate


def _read(address: int) -> int:
    return int(ctypes.c_int64.from_address(int(address)).value)


_compiled: Any = _read if PURE_PYTHON else intrinsic(_word)


def described(array: np.ndarray) -> tuple[int, int, int]:
    """Return dimensions, order and other flags, and type of the entries of an array."""
    flags = array.flags.num
    order = _C if flags & _C else flags & _F
    return array.ndim, (flags & _OTHERS) | order, _read(id(array.dtype) + _KIND)


@loop
def lay_out(objects: Integers, descriptions: Integers, places: Integers, words: Integers) -> bool:
    """Write what describes arrays into records as compiled code has them; return whether they are as described.

    Args:
        objects: where the arrays themselves are ``(n,)``; descriptions: as :func:`described` returns them ``(n, 3)``.
        places: of the records among the words ``(n,)``: count and size of entries, their address, shape, strides follow
            two words.
        words: of which counts, addresses, shapes and strides are written.
    """
    for k in range(objects.shape[0]):
        record, at = objects[k], places[k]
        dimensions, flags = _compiled(record + _DIMENSIONS) & _HALF, _compiled(record + _FLAGS) & _HALF
        order = _C if flags & _C != 0 else flags & _F
        if dimensions != descriptions[k, 0] or (flags & _OTHERS) | order != descriptions[k, 1]:
            return False
        if _compiled(_compiled(record + _TYPE) + _KIND) != descriptions[k, 2]:
            return False
        shape, strides, count = _compiled(record + _SHAPE), _compiled(record + _STRIDES), 1
        for d in range(dimensions):
            length = _compiled(shape + 8 * d)
            count *= length
            words[at + 5 + d] = length
            words[at + 5 + dimensions + d] = _compiled(strides + 8 * d)
        words[at + 2] = count
        words[at + 4] = _compiled(record + _ENTRIES) if count != 0 else 0
    return True


def _readable() -> bool:
    """Try whether records are as they should be."""
    array = np.zeros((2, 3))[:, 1:]
    record = id(array)
    found = (_read(record + _DIMENSIONS) & _HALF, _read(record + _FLAGS) & _HALF, _read(record + _ENTRIES))
    if found != (2, array.flags.num, array.ctypes.data) or _read(record + _TYPE) != id(array.dtype):
        return False
    shape, strides = _read(record + _SHAPE), _read(record + _STRIDES)
    return [_read(at + 8 * d) for at in (shape, strides) for d in range(2)] == [2, 2, 24, 8]


READABLE = _HEAD == 16 and _readable()
"""Whether NumPy's records can be read."""
