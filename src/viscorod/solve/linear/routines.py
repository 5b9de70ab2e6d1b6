"""LAPACK and BLAS for compiled code, real or complex by the type of the arrays, through the addresses SciPy exports.

A routine is called with an array that tells the type and a tuple of all its arguments as arrays, whose first entries
they start at: ``getrf(a, (size, size, a, size, pivots, result))``. Integers are int32, letters too (:data:`LETTERS`).
"""

from __future__ import annotations

import ctypes
from typing import Any

import llvmlite.binding
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import get_cython_function_address, intrinsic

from viscorod.mechanics.compilation.compiled import PURE_PYTHON

LETTERS = np.array([0x01010101 * ord(letter) for letter in "NLUR"], dtype=np.int32)
"""LAPACK's letters: no transposed matrix or no unit diagonal, lower or left, upper or unit diagonal, right."""

_insert: Any = cgutils.get_or_insert_function


def _routine(module: str, name: str) -> Any:
    addresses = {kind: get_cython_function_address(f"scipy.linalg.{module}", kind + name) for kind in "dz"}
    if PURE_PYTHON:

        def call_python(like: Any, arrays: Any) -> None:
            kind = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(arrays))
            kind(addresses["z" if like.dtype == complex else "d"])(*(array.ctypes.data for array in arrays))

        return call_python

    for kind, address in addresses.items():
        llvmlite.binding.add_symbol(f"viscorod_{kind}{name}", address)

    @intrinsic
    def call(_context: Any, like: Any, arrays: Any) -> Any:
        symbol = f"viscorod_{'z' if like.dtype == types.complex128 else 'd'}{name}"

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            pointers = []
            for k, kind in enumerate(signature.args[1]):
                value = builder.extract_value(arguments[1], k)
                data = context.make_array(kind)(context, builder, value=value).data
                pointers.append(builder.bitcast(data, cgutils.voidptr_t))
            kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t] * len(pointers))
            builder.call(_insert(builder.module, kind, symbol), pointers)
            return context.get_dummy_value()

        return types.void(like, arrays), generate

    return call


gbtrf = _routine("cython_lapack", "gbtrf")
getrf = _routine("cython_lapack", "getrf")
trsm = _routine("cython_blas", "trsm")
gemm = _routine("cython_blas", "gemm")
