"""Bundles that stand in memory, so that Python hands kernels one address in place of all arrays.

Where Python calls a kernel with a bundle, compiled code takes every array apart: 13 ms of compilation for each, and
every call does it again. A :class:`Shared` bundle has been taken apart once, as compiled code lays it out; kernels take
a reference to it (see ``references``). What changes from call to call is numbers in its arrays.
"""

from __future__ import annotations

import array
import ctypes
import itertools
import struct
from typing import Any, Generic, TypeVar

import numba
import numpy as np
from numba import _dispatcher
from numba.core import cgutils
from numba.extending import NativeValue, typeof_impl, unbox

from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.references import Reference

__all__ = ["Shared", "kinds_of"]

Bundle = TypeVar("Bundle", bound=tuple[Any, ...])

_WORD = 8
_C_ORDER, _F_ORDER, _WRITEABLE = 0x0001, 0x0002, 0x0400
"""NumPy's flags."""

_byte: Any = ctypes.c_char.from_buffer
_typeof: Any = numba.typeof
_native: Any = NativeValue
_is_not_null: Any = cgutils.is_not_null
_typeof_of: Any = typeof_impl.register
_unbox: Any = unbox


def _unknown(_value: Any) -> Any:
    """Stand in for Numba's numbers where a version has none."""
    raise NotImplementedError


_fingerprint: Any = getattr(_dispatcher, "compute_fingerprint", _unknown)
_numbers = itertools.count()
_types: dict[Any, tuple[Any, int]] = {}
"""Numba's types of bundles and their numbers, by kinds: it takes milliseconds to find a type, and long to hash it."""


def kinds_of(value: Any) -> Any:
    """Return what Numba's type of an argument depends on.

    Numba's own numbers are 30 times as fast as looking at 150 arrays here, but know nothing of shared bundles.
    """
    try:
        return _fingerprint(value)
    except NotImplementedError:
        pass
    if isinstance(value, np.ndarray):
        flags = value.flags.num
        order = _C_ORDER if flags & _C_ORDER else flags & _F_ORDER
        return value.dtype.char, value.ndim, order | (flags & _WRITEABLE)
    if isinstance(value, tuple):
        return type(value), *(kinds_of(item) for item in value)
    return (Shared, value.number) if isinstance(value, Shared) else type(value)


class Shared(Generic[Bundle]):
    """A bundle of arrays, numbers and bundles that compiled code reads where it stands.

    Shared bundles within others are references there.

    Args:
        bundle: that stays as it is; its arrays may be written to.
        kinds: those of the bundle, if they are known.

    Attributes:
        bundle: the same, for Python; address: where it stands; kind: Numba's type of the bundle; number: of the kind.
    """

    __slots__ = ("_words", "address", "bundle", "kind", "number")

    def __init__(self, bundle: Bundle, kinds: Any = None) -> None:
        self.bundle = bundle
        kinds = kinds_of(bundle) if kinds is None else kinds
        found = _types.get(kinds)
        if found is None:
            found = _types.setdefault(kinds, (_typeof(bundle), next(_numbers)))  # of one thread, for all
        self.kind, self.number = found
        words = _Words()
        words.add(bundle)
        self._words = array.array("q", words.found)
        self.address = self._words.buffer_info()[0]

    @property
    def argument(self) -> Any:
        """What kernels are handed: this, or the bundle in pure Python."""
        return self.bundle if PURE_PYTHON else self


class _Words:
    """A value as compiled code has it in memory, in words of eight bytes; switches take a byte each."""

    def __init__(self) -> None:
        self.found: list[int] = []
        self._switches = 0  # in the last word, which is full without any

    def add(self, value: Any) -> None:
        """Append a value."""
        if isinstance(value, np.ndarray):
            self._switches = 0
            # nobody counts references to an array, which Python's bundle keeps
            self.found += (0, 0, value.size, value.itemsize, _place_of(value), *value.shape, *value.strides)
        elif isinstance(value, tuple) and value:
            # one of switches alone begins and ends within a word
            mixed = not isinstance(value[0], bool | np.bool_ | tuple) or not _only_switches(value)
            if mixed:
                self._switches = 0
            for item in value:
                self.add(item)
            if mixed:
                self._switches = 0
        elif isinstance(value, bool | np.bool_):
            if self._switches % _WORD == 0:
                self.found.append(0)
                self._switches = 0
            self.found[-1] |= int(value) << (8 * self._switches)
            self._switches += 1
        elif not isinstance(value, tuple):
            self._switches = 0
            self.found += _number(value)


def _number(value: Any) -> tuple[int, ...]:
    if isinstance(value, Shared):
        return (value.address,)
    if isinstance(value, complex):
        return struct.unpack("=2q", struct.pack("=2d", value.real, value.imag))
    return struct.unpack("=q", struct.pack("=d", value)) if isinstance(value, float) else (int(value),)


def _place_of(array: np.ndarray) -> int:
    """Return where the first entry of an array is; 0: it has none."""
    if not array.size:
        return 0
    try:
        return ctypes.addressof(_byte(array))  # four times as fast as NumPy's way
    except (TypeError, ValueError):  # read only, or in another order
        return int(array.ctypes.data)


def _only_switches(value: Any) -> bool:
    if isinstance(value, tuple):
        return all(map(_only_switches, value))
    return isinstance(value, bool | np.bool_)


@_typeof_of(Shared)
def _type_of(shared: Shared[Any], _context: Any) -> Any:
    return Reference(shared.kind)


@_unbox(Reference)
def _from_python(kind: Any, shared: Any, calling: Any) -> Any:
    """Read the address."""
    api, builder = calling.pyapi, calling.builder
    number = api.object_getattr_string(shared, "address")
    address = api.long_as_longlong(number)
    api.decref(number)
    pointer = calling.context.get_value_type(kind)
    failed = _is_not_null(builder, api.err_occurred())
    return _native(builder.inttoptr(address, pointer), is_error=failed)
