"""Bundles that stand in memory, so that Python hands kernels one address in place of all arrays.

Where Python calls a kernel with a bundle, compiled code takes every array apart: 13 ms of compilation for each, and
every call does it again. A :class:`Shared` bundle has been taken apart once, as compiled code lays it out; kernels take
a reference to it (see ``references``). What changes from call to call is numbers in its arrays. Of bundles like earlier
ones only the arrays are looked at (see ``array_records``).
"""

from __future__ import annotations

import ctypes
import itertools
import operator
import struct
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

import numba
import numpy as np
from numba import _dispatcher
from numba.core import cgutils
from numba.extending import NativeValue, typeof_impl, unbox

from viscorod.mechanics.compilation.array_records import READABLE, described, lay_out
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.references import Reference
from viscorod.typing import Integers

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
MOST_LAYOUTS = 8
"""Of bundles of one class."""

_numbers = itertools.count()
_layouts: dict[type, list[_Layout]] = {}
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
        bundle: that stays as it is, but for :meth:`put`; its arrays may be written to.

    Attributes:
        bundle: the same, for Python; address: where it stands; kind: Numba's type of the bundle; number: of the kind.
    """

    __slots__ = ("_fields", "_words", "address", "bundle", "kind", "number")

    def __init__(self, bundle: Bundle) -> None:
        self.bundle = bundle
        known = _layouts.setdefault(type(bundle), [])
        for layout in known:
            if (words := layout.words_of(bundle)) is not None:
                break
        else:
            layout = _Layout(bundle)
            words = layout.blank.copy()
            known[:] = [layout, *known[: MOST_LAYOUTS - 1]]
        self._words, self._fields = words, layout.fields
        self.kind, self.number = layout.kind, layout.number
        self.address = int(words.ctypes.data)

    def put(self, name: str, part: tuple[int, ...]) -> None:
        """Put other integers in the place of the bundle of integers called ``name``."""
        bundle: Any = self.bundle
        self.bundle = bundle._replace(**{name: part})
        first = self._fields[bundle._fields.index(name)]
        self._words[first : first + len(part)] = part

    @property
    def argument(self) -> Any:
        """What kernels are handed: this, or the bundle in pure Python."""
        return self.bundle if PURE_PYTHON else self


class _Plan:
    """What a bundle has in it, so that others can be compared with it, and taken apart.

    Its items stand in one list: those of the bundle, then those of each bundle in that list, in its order.
    """

    def __init__(self, bundle: tuple[Any, ...], words: _Words) -> None:
        """Look at a bundle, which ``words`` have been made of."""
        flat: list[Any] = list(bundle)
        first: dict[int, int] = {}
        for k, item in enumerate(flat):  # which grows
            if isinstance(item, tuple):
                first[k] = len(flat)
                flat += item
        self._types = list(map(type, flat))
        self._bundles = [(k, type(flat[k]), len(flat[k])) for k in first]
        places = list(_in_order(flat, range(len(bundle)), first))
        arrays = [k for k in places if isinstance(flat[k], np.ndarray)]
        switches = [k for k in places if isinstance(flat[k], bool | np.bool_)]
        others = [k for k in places if not isinstance(flat[k], np.ndarray | bool | np.bool_)]
        at = dict(zip(others, words.numbers, strict=True))
        whole, real = ([k for k in others if type(flat[k]) is kind] for kind in (int, float))
        rest = [k for k in others if type(flat[k]) not in (int, float)]
        self._arrays, self._switches, self._whole, self._real, self._rest = (
            _items(numbers) for numbers in (arrays, switches, whole, real, rest)
        )
        self._shared = _items([k for k in rest if isinstance(flat[k], Shared)])
        self._switched = self._switches(flat)
        self._numbers = [shared.number for shared in self._shared(flat)]
        self.arrays_at = np.array(words.arrays, dtype=np.int64)
        self._at = [
            np.array([word for k in numbers for word in at[k]], dtype=np.int64)
            for numbers in (whole, real, rest)
        ]

    def take_apart(self, bundle: tuple[Any, ...]) -> list[Any] | None:
        """Return all items of a bundle; None if it is not like the first one."""
        flat: list[Any] = list(bundle)
        for k, kind, length in self._bundles:
            item = flat[k]
            if type(item) is not kind or len(item) != length:
                return None
            flat += item
        if list(map(type, flat)) != self._types or self._switches(flat) != self._switched:
            return None
        if [shared.number for shared in self._shared(flat)] != self._numbers:
            return None
        return flat

    def arrays(self, flat: list[Any]) -> tuple[np.ndarray, ...]:
        """Return the arrays among the items of a bundle, in the order of ``arrays_at``."""
        return self._arrays(flat)

    def write_numbers(self, flat: list[Any], words: Integers) -> None:
        """Write the numbers among the items of a bundle to its words."""
        whole, real, rest = self._at
        words[whole] = self._whole(flat)
        words.view(np.float64)[real] = self._real(flat)
        words[rest] = [word for value in self._rest(flat) for word in _number(value)]


def _in_order(flat: list[Any], places: range, first: dict[int, int]) -> Iterator[int]:
    """Return the places of all items but bundles, as compiled code has them; ``first``: of the items of each bundle."""
    for k in places:
        if k in first:
            yield from _in_order(flat, range(first[k], first[k] + len(flat[k])), first)
        else:
            yield k


def _items(places: list[int]) -> Callable[[list[Any]], tuple[Any, ...]]:
    """Return what takes the items at some places from a list."""
    if len(places) > 1:
        return operator.itemgetter(*places)
    return lambda flat: tuple(flat[k] for k in places)


class _Layout:
    """How bundles of one kind stand in memory, so that of another one only arrays and numbers are looked at.

    Attributes:
        kind, number: of the bundle; blank: words of the first bundle; fields: where its fields begin among them.
    """

    def __init__(self, bundle: tuple[Any, ...]) -> None:
        kinds = kinds_of(bundle)
        found = _types.get(kinds)
        if found is None:
            found = _types.setdefault(kinds, (_typeof(bundle), next(_numbers)))  # of one thread, for all
        self.kind, self.number = found
        words = _Words()
        words.add(bundle)
        self.blank = np.array(words.found, dtype=np.int64)
        self.fields = words.fields
        self._plan = plan = _Plan(bundle, words)
        rows = [described(array) for array in plan.arrays(plan.take_apart(bundle) or [])]
        self._descriptions = np.array(rows, dtype=np.int64).reshape(-1, 3)

    def words_of(self, bundle: tuple[Any, ...]) -> Integers | None:
        """Return the words of a bundle; None if it is of another kind."""
        plan = self._plan
        if not READABLE or (flat := plan.take_apart(bundle)) is None:
            return None
        words = self.blank.copy()
        arrays = plan.arrays(flat)
        objects = np.fromiter(map(id, arrays), dtype=np.int64, count=len(arrays))
        if not lay_out(objects, self._descriptions, plan.arrays_at, words):
            return None
        plan.write_numbers(flat, words)
        return words


class _Words:
    """A value as compiled code has it in memory, in words of eight bytes; switches take a byte each.

    Attributes:
        found: the words; arrays, fields: where arrays and fields of the outermost bundle begin among them; numbers: the
            places of each.
    """

    def __init__(self) -> None:
        self.found: list[int] = []
        self.arrays: list[int] = []
        self.numbers: list[range] = []
        self.fields: list[int] = []
        self._switches = 0  # in the last word, which is full without any
        self._within = False

    def add(self, value: Any) -> None:
        """Append a value."""
        if isinstance(value, np.ndarray):
            self._switches = 0
            self.arrays.append(len(self.found))
            # nobody counts references to an array, which Python's bundle keeps
            self.found += (0, 0, value.size, value.itemsize, _place_of(value), *value.shape, *value.strides)
        elif isinstance(value, tuple) and value:
            # one of switches alone begins and ends within a word
            mixed = not isinstance(value[0], bool | np.bool_ | tuple) or not _only_switches(value)
            if mixed:
                self._switches = 0
            outermost, self._within = not self._within, True
            for item in value:
                if outermost:
                    self.fields.append(len(self.found))
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
            first = len(self.found)
            self.found += _number(value)
            self.numbers.append(range(first, len(self.found)))


def _number(value: Any) -> tuple[int, ...]:
    if type(value) is int:
        return (value,)
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
