"""Calls of kernels whose arguments always have the same types, without looking at these again.

At every call Numba looks at the type of every array, in bundles too, to find the machine code: 0.15 us each, of which a
step has 150. Where types do not change this is done once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, cast

import numba
import numpy as np

from viscorod.mechanics.compilation.compiled import PURE_PYTHON, on_disk
from viscorod.mechanics.compilation.shared import kinds_of

__all__ = ["KnownTypes"]

Code = Callable[..., Any]


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
        if PURE_PYTHON:
            self.call: Code = kernel

    def __getattr__(self, name: str) -> Code:
        """Return the first call, which is not kept: an object that refers to itself would wait for a search."""
        if name != "call":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return self._first_call

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
        key = self._kernel, kinds_of(arguments)
        found = self._found.get(key)
        if found is None:
            dispatcher: Any = self._kernel
            typeof: Any = numba.typeof
            types = tuple(typeof(argument) for argument in arguments)
            dispatcher.compile(types)
            found = self._found[key] = dispatcher.overloads[types]
        self._compiled = found
        return found
