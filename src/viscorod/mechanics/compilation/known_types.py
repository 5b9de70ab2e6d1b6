"""Calls of kernels whose arguments always have the same types, without looking at these again.

At every call Numba looks at the type of every array, in bundles too, to find the machine code: 0.15 us each, of which a
step has 150. Where types do not change this is done once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, cast

import numba
import numpy as np
from numba import _dispatcher

from viscorod.mechanics.compilation.compiled import PURE_PYTHON, on_disk

__all__ = ["KnownTypes"]

Code = Callable[..., Any]

_LAYOUT = 0x0001 | 0x0002 | 0x0400
"""NumPy's flags of C and Fortran order, and of arrays that may be written."""


class KnownTypes:
    """A kernel for arguments of the types of its first call: arrays of the same kind, dimensions and layout, always.

    Args:
        kernel: that is called.

    Attributes:
        call: the kernel, from its second call on as machine code.
    """

    __slots__ = ("_compiled", "_kernel", "call")

    _found: ClassVar[dict[Any, Any]] = {}
    """What Numba compiled, by kernel and kinds of arguments: it takes milliseconds to find it."""

    def __init__(self, kernel: Code) -> None:
        self._kernel = kernel
        self._compiled: Any = None
        self.call: Code = kernel if PURE_PYTHON else self._first_call

    def _first_call(self, *arguments: Any) -> Any:
        self.call = self.compiled(arguments).entry_point
        return self.call(*arguments)

    @property
    def unknown(self) -> bool:
        """Whether the types are still unknown."""
        return self._compiled is None

    @property
    def loaded(self) -> bool:
        """Whether machine code of the kernel is in memory."""
        return not PURE_PYTHON and bool(cast(Any, self._kernel).overloads)

    @property
    def kept(self) -> bool:
        """Whether machine code of the kernel is on disk."""
        return not PURE_PYTHON and on_disk(self._kernel)

    def suited(self, *arrays: np.ndarray) -> Code:
        """Return what calls the kernel where these ``arrays`` might not be of real numbers in C's order; others are."""
        for array in arrays:
            if not array.flags.c_contiguous or array.dtype.char != "d":
                return self._kernel
        return self.call

    def take_over(self, other: KnownTypes) -> None:
        """Use the machine code of another call of the same kernel with arguments of the same types, if it is known."""
        if self._kernel is other._kernel and other._compiled is not None:
            self.call, self._compiled = other.call, other._compiled

    def compiled(self, arguments: tuple[Any, ...]) -> Any:
        """Return what Numba compiled for these arguments, which are of the types of all calls."""
        if self._compiled is not None:
            return self._compiled
        key = self._kernel, _fingerprint(arguments)
        found = self._found.get(key)
        if found is None:
            dispatcher: Any = self._kernel
            typeof: Any = numba.typeof
            types = tuple(typeof(argument) for argument in arguments)
            dispatcher.compile(types)
            found = self._found[key] = dispatcher.overloads[types]
        self._compiled = found
        return found


def _kinds(value: Any) -> Any:
    """Return what the type of an argument depends on."""
    if isinstance(value, np.ndarray):
        return value.dtype.char, value.ndim, value.flags.num & _LAYOUT
    if isinstance(value, tuple):
        return type(value), *(_kinds(item) for item in value)
    return type(value)


_fingerprint: Code = getattr(_dispatcher, "compute_fingerprint", _kinds)
"""Numba's own numbers for the types of arguments, 30 times as fast as :func:`_kinds` for the 150 arrays of a step."""
