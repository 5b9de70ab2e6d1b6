"""LAPACK's band LU for compiled code, real and complex, through the addresses that SciPy exports.

A matrix is stored as in :class:`~viscorod.solve.banded.BandMatrix`: row j of ``band (n, 3 w + 1)`` is column j, entry
(i, j) at ``band[j, 2 w + i - j]``; its first ``w`` places per row are room for pivoting.
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


def _routine(name: str, arguments: int) -> Any:
    symbol = f"viscorod_{name}"
    llvmlite.binding.add_symbol(symbol, get_cython_function_address("scipy.linalg.cython_lapack", name))
    return types.ExternalFunction(symbol, types.void(*[types.voidptr] * arguments))


_dgbtrf, _dgbtrs = _routine("dgbtrf", 8), _routine("dgbtrs", 11)
_zgbtrf, _zgbtrs = _routine("zgbtrf", 8), _routine("zgbtrs", 11)


def pivots(size: int) -> Integers:
    """Return room for the pivots of a matrix with ``size`` rows, and for LAPACK's other integers and its letter."""
    return np.zeros(size + 5, dtype=np.int32)


@part
def _describe(band: Floats, integers: Integers) -> int:
    """Write LAPACK's integer arguments (rows, half width, columns of storage, one, result) behind the pivots."""
    n = band.shape[0]
    integers[n] = n
    integers[n + 1] = (band.shape[1] - 1) // 3
    integers[n + 2] = band.shape[1]
    integers[n + 3] = 1
    return int(n)


@kernel
def factorise(band: Floats, integers: Integers) -> int:
    """Replace a real band matrix by its LU factors; return 0, or the (1-based) row of a zero pivot."""
    n = _describe(band, integers)
    size, width, columns = integers[n:].ctypes, integers[n + 1 :].ctypes, integers[n + 2 :].ctypes
    _dgbtrf(size, size, width, width, band.ctypes, columns, integers.ctypes, integers[n + 4 :].ctypes)
    return int(integers[n + 4])


@kernel
def factorise_complex(band: Floats, integers: Integers) -> int:
    """Replace a complex band matrix by its LU factors; return 0, or the (1-based) row of a zero pivot."""
    n = _describe(band, integers)
    size, width, columns = integers[n:].ctypes, integers[n + 1 :].ctypes, integers[n + 2 :].ctypes
    _zgbtrf(size, size, width, width, band.ctypes, columns, integers.ctypes, integers[n + 4 :].ctypes)
    return int(integers[n + 4])


@part
def solve(band: Floats, integers: Integers, letter: Bytes, b: Floats) -> None:
    """Solve with real factors in place; ``letter`` is ``NO_TRANSPOSE``."""
    n = _describe(band, integers)
    size, width, columns = integers[n:].ctypes, integers[n + 1 :].ctypes, integers[n + 2 :].ctypes
    one, result = integers[n + 3 :].ctypes, integers[n + 4 :].ctypes
    pivots_ = integers.ctypes
    _dgbtrs(letter.ctypes, size, width, width, one, band.ctypes, columns, pivots_, b.ctypes, size, result)


@part
def solve_complex(band: Floats, integers: Integers, letter: Bytes, b: Floats) -> None:
    """Solve with complex factors in place; ``letter`` is ``NO_TRANSPOSE``."""
    n = _describe(band, integers)
    size, width, columns = integers[n:].ctypes, integers[n + 1 :].ctypes, integers[n + 2 :].ctypes
    one, result = integers[n + 3 :].ctypes, integers[n + 4 :].ctypes
    pivots_ = integers.ctypes
    _zgbtrs(letter.ctypes, size, width, width, one, band.ctypes, columns, pivots_, b.ctypes, size, result)
