"""Calls of kernels whose arguments always have the same types, without looking at these again.

At every call Numba looks at the type of every array, in bundles too, to find the machine code: 0.15 us each, of which a
step has 150. Where types do not change this is done once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numba
import numpy as np

from viscorod.mechanics.compilation.compiled import PURE_PYTHON

__all__ = ["KnownTypes"]

Code = Callable[..., Any]


class KnownTypes:
    """A kernel for arguments of the types of its first call: arrays of the same kind, dimensions and layout, always.

    Args:
        kernel: that is called.

    Attributes:
        call: the kernel, from its second call on as machine code.
    """

    __slots__ = ("_kernel", "call")

    _found: ClassVar[dict[Any, Code]] = {}
    """Machine code by kernel and kinds of arguments: Numba takes milliseconds to find it."""

    def __init__(self, kernel: Code) -> None:
        self._kernel = kernel
        self.call: Code = kernel if PURE_PYTHON else self._first_call

    def _first_call(self, *arguments: Any) -> Any:
        self.call = self._machine_code(arguments)
        return self.call(*arguments)

    def take_over(self, other: KnownTypes) -> None:
        """Use the machine code of another call of the same kernel with arguments of the same types, if it is known."""
        if self._kernel is other._kernel and other.call != other._first_call:
            self.call = other.call

    def _machine_code(self, arguments: tuple[Any, ...]) -> Code:
        key = self._kernel, _kinds(arguments)
        found = self._found.get(key)
        if found is None:
            dispatcher: Any = self._kernel
            typeof: Any = numba.typeof
            types = tuple(typeof(argument) for argument in arguments)
            dispatcher.compile(types)
            found = self._found[key] = dispatcher.overloads[types].entry_point
        return found


def _kinds(value: Any) -> Any:
    """Return what the type of an argument depends on."""
    if isinstance(value, np.ndarray):
        flags = value.flags
        return value.dtype.char, value.ndim, flags.c_contiguous, flags.f_contiguous, flags.writeable
    if isinstance(value, tuple):
        return type(value), *(_kinds(item) for item in value)
    return type(value)
