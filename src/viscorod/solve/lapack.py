"""LAPACK's band LU for compiled code, real and complex, through the addresses that SciPy exports.

A matrix is stored in rows of ``band (n, 3 w + 1)``: row j is column j, entry (i, j) at ``band[j, 2 w + i - j]``; its
first ``w`` places per row are room for pivoting.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import llvmlite.binding
import numpy as np
from numba import types
from numba.extending import get_cython_function_address
from numpy.typing import NDArray

from viscorod.mechanics.compiled import kernel, part
from viscorod.typing import Floats, Integers

Bytes: TypeAlias = NDArray[np.uint8]

NO_TRANSPOSE: Bytes = np.frombuffer(b"N", dtype=np.uint8)
"""LAPACK's letter for a solution with the matrix itself."""

COMPLEX = 16
"""Bytes of a complex number, by which compiled code tells the types apart."""


def _routine(name: str, arguments: int) -> Any:
    symbol = f"viscorod_{name}"
    llvmlite.binding.add_symbol(symbol, get_cython_function_address("scipy.linalg.cython_lapack", name))
    return types.ExternalFunction(symbol, types.void(*[types.voidptr] * arguments))


_dgbtrf, _dgbtrs = _routine("dgbtrf", 8), _routine("dgbtrs", 11)
_zgbtrf, _zgbtrs = _routine("zgbtrf", 8), _routine("zgbtrs", 11)


def pivots(size: int, width: int) -> Integers:
    """Return room for the pivots of a matrix with ``size`` rows, and LAPACK's other integers behind them.

    These are rows, half width, columns of storage, one, result.
    """
    return np.array([0] * size + [size, width, 3 * width + 1, 1, 0], dtype=np.int32)


@kernel
def factorise(band: Floats, integers: Integers) -> int:
    """Replace a real or complex band matrix by its LU factors; return 0, or the (1-based) row of a zero pivot."""
    n = band.shape[0]
    size, width, columns = integers[n:].ctypes, integers[n + 1 :].ctypes, integers[n + 2 :].ctypes
    result = integers[n + 4 :].ctypes
    if band.itemsize == COMPLEX:
        _zgbtrf(size, size, width, width, band.ctypes, columns, integers.ctypes, result)
    else:
        _dgbtrf(size, size, width, width, band.ctypes, columns, integers.ctypes, result)
    return int(integers[n + 4])


@part
def solve(band: Floats, integers: Integers, letter: Bytes, b: Floats) -> None:
    """Solve with factors in place, ``b`` of their type; ``letter`` is a copy of ``NO_TRANSPOSE``."""
    n = band.shape[0]
    size, width, columns = integers[n:].ctypes, integers[n + 1 :].ctypes, integers[n + 2 :].ctypes
    one, result = integers[n + 3 :].ctypes, integers[n + 4 :].ctypes
    pivots_ = integers.ctypes
    if band.itemsize == COMPLEX:
        _zgbtrs(letter.ctypes, size, width, width, one, band.ctypes, columns, pivots_, b.ctypes, size, result)
    else:
        _dgbtrs(letter.ctypes, size, width, width, one, band.ctypes, columns, pivots_, b.ctypes, size, result)
