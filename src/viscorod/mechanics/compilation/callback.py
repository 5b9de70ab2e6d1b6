"""Python functions that compiled code calls through an address given at run time.

Addresses are numbers in the arguments of a kernel, never constants within: machine code on disk stays valid, and one
kernel serves all functions. The code called has the signature ``void f(double *values, int64_t count)``: it reads
``count`` numbers and overwrites them (complex numbers count twice).

An exception cannot pass through compiled code. :class:`Callback` keeps the first one and fills the numbers with NaN;
the caller of the kernel calls :meth:`Callback.check` afterwards, which raises it::

    doubled = Callback(double)           # def double(values): values *= 2.0
    kernel(..., doubled.address, values)
    doubled.check()
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.typing import Floats

_SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)


class Callback:
    """A Python function for compiled code; the address is valid as long as this object lives.

    Args:
        function: takes the numbers ``(count,)`` and overwrites them; it must not keep the array.
    """

    def __init__(self, function: Callable[[Floats], object]) -> None:
        errors: list[BaseException] = []

        def call(pointer: int, count: int) -> None:
            buffer: Any = (ctypes.c_double * count).from_address(pointer)
            values: Floats = np.frombuffer(buffer)
            try:
                function(values)
            except BaseException as error:  # also a keyboard interrupt must reach Python
                values.fill(np.nan)
                if not errors:
                    errors.append(error)

        self._errors = errors
        self._entry = _SIGNATURE(call)
        self.address: int = ctypes.cast(self._entry, ctypes.c_void_p).value or 0

    def check(self) -> None:
        """Raise the first exception of the function since the last check, if there is one."""
        if self._errors:
            raise self._errors.pop()


def _call(_context: Any, address: Any, pointer: Any, number: Any) -> Any:
    """Call the code at ``address`` with the ``number`` float64 values at ``pointer`` (``array.ctypes``)."""
    del address, pointer, number

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        place, data, count = arguments
        kind = ir.FunctionType(ir.VoidType(), [data.type, count.type])
        builder.call(builder.inttoptr(place, kind.as_pointer()), [data, count])
        return context.get_dummy_value()

    return types.void(types.int64, types.voidptr, types.int64), generate


def _call_python(address: int, pointer: Any, number: int) -> None:
    """Do the same in pure Python."""
    _SIGNATURE(int(address))(pointer.data, number)


_compiled: Any = _call_python if PURE_PYTHON else intrinsic(_call)
call: Callable[[int, Any, int], None] = _compiled
