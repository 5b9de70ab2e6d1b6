"""Bundles of arrays by reference, within compiled code.

Numba hands a named tuple from function to function as all its numbers: five and two per dimension for each array, some
1500 for the arrays of a step. Typing, lowering and optimising these is most of what such a function takes to compile. A
reference is one pointer: its fields are read where they are needed, and fields that are bundles are references again::

    run = refer(bundle)          # in a kernel; parts that it calls take ``run``
    run.model.parts.stages.X     # reads one array

Functions that are compiled into their caller may take references, and those that are not, bundles by value
(:func:`whole_of`): then the compiler knows that nobody changes them, and keeps what it needs in registers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model

from viscorod.mechanics.compilation.compiled import PURE_PYTHON

__all__ = ["Reference", "numbers_of", "refer", "referred", "row_of", "whole_of"]

Bundle = TypeVar("Bundle")

_Type: Any = types.Type
_Template: Any = AttributeTemplate
_tuples: Any = types.BaseTuple
_numba: Any = types
_models: Any = models
_infer: Any = infer_getattr
_register: Any = register_model
_lower: Any = lower_getattr_generic
_alloca: Any = cgutils.alloca_once
_borrowed: Any = impl_ret_borrowed


class Reference(_Type):
    """Numba's type of a reference to a tuple of the type ``kind``, which cannot be written to as a whole."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(name=f"reference to {kind}")


@_register(Reference)
class _Pointer(_models.PrimitiveModel):
    """A pointer to the tuple's numbers."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, manager.lookup(kind.kind).get_value_type().as_pointer())


@_infer
class _Fields(_Template):
    """Types of the fields."""

    key = Reference

    def generic_resolve(self, reference: Any, name: str) -> Any:
        """Return the type of the field ``name``, None if there is none."""
        kind = reference.kind
        if name not in getattr(kind, "fields", ()):
            return None
        field = kind.types[kind.fields.index(name)]
        return Reference(field) if isinstance(field, _tuples) else field


@_lower(Reference)
def _field(context: Any, builder: Any, reference: Any, pointer: Any, name: str) -> Any:
    kind = reference.kind
    place = kind.fields.index(name)
    at = _at(builder, pointer, place)
    if isinstance(kind.types[place], _tuples):
        return at
    return _borrowed(context, builder, kind.types[place], builder.load(at))


def _at(builder: Any, pointer: Any, place: int) -> Any:
    index = ir.IntType(32)
    return builder.gep(pointer, [index(0), index(place)], inbounds=True)


def _members(model: Any) -> list[Any] | None:
    """Return the models of what a struct or a tuple has in it, None for a single number."""
    if isinstance(model, _models.StructModel):
        return list(model.inner_models())
    if isinstance(model, _models.UniTupleModel):
        return [*model.inner_models()] * len(model.fe_type)
    return None


def _store(builder: Any, model: Any, value: Any, pointer: Any) -> None:
    """Store a value number by number, since LLVM takes long for a large one."""
    members = _members(model)
    if members is None:
        builder.store(value, pointer)
        return
    for place, member in enumerate(members):
        _store(builder, member, builder.extract_value(value, place), _at(builder, pointer, place))


def _stored(builder: Any, model: Any, pointer: Any) -> list[Any]:
    members = _members(model)
    if members is None:
        return _flat(model.as_argument(builder, builder.load(pointer)))
    return [
        number
        for place, member in enumerate(members)
        for number in _stored(builder, member, _at(builder, pointer, place))
    ]


def _flat(value: Any) -> list[Any]:
    return (
        [number for item in value for number in _flat(item)] if isinstance(value, (tuple, list)) else [value]
    )


def referred(kind: Any) -> Any:
    """Return the type of a value with the bundles themselves in place of references to them."""
    if isinstance(kind, Reference):
        return kind.kind
    if not isinstance(kind, _tuples):
        return _numba.unliteral(kind)
    found: Any = tuple(referred(member) for member in kind)
    if not hasattr(kind, "instance_class"):
        return _numba.Tuple(found)
    if len(set(found)) == 1:
        return _numba.NamedUniTuple(found[0], len(found), kind.instance_class)
    return _numba.NamedTuple(found, kind.instance_class)


def numbers_of(context: Any, builder: Any, kind: Any, value: Any, *, whole: bool = True) -> list[Any]:
    """Return the numbers as which a value is handed to a compiled function.

    Args:
        kind, value: of the value; whole: bundles are read from where references to them point.
    """
    reads = whole and isinstance(kind, Reference)
    model = context.data_model_manager[kind.kind if reads else kind]
    if reads:
        return _stored(builder, model, value)
    if not isinstance(kind, _tuples):
        return _flat(model.as_argument(builder, value))
    return [
        number
        for place, member in enumerate(kind)
        for number in numbers_of(context, builder, member, builder.extract_value(value, place), whole=whole)
    ]


def _refer(_context: Any, bundle: Any) -> Any:
    """Return a reference to a bundle, which stands on the stack of the function that asks; nothing stays nothing."""
    if not isinstance(bundle, _tuples):
        return bundle(bundle), lambda _context, _builder, _signature, arguments: arguments[0]

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        (value,) = arguments
        pointer = _alloca(builder, value.type)
        _store(builder, context.data_model_manager[bundle], value, pointer)
        return pointer

    return Reference(bundle)(bundle), generate


def _whole_of(_context: Any, reference: Any) -> Any:
    """Return the bundle that a reference stands for."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        numbers = _stored(builder, context.data_model_manager[reference.kind], arguments[0])
        (value,) = context.get_arg_packer([reference.kind]).from_arguments(builder, numbers)
        return _borrowed(context, builder, signature.return_type, value)

    return reference.kind(reference), generate


def _row_of(_context: Any, rows: Any, place: Any) -> Any:
    """Return the array at a ``place`` among ``rows``, a reference to a tuple of arrays that are alike."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer, at = arguments
        found = builder.load(builder.gep(pointer, [at.type(0), at], inbounds=True))
        return _borrowed(context, builder, signature.return_type, found)

    return rows.kind.dtype(rows, _numba.unliteral(place)), generate


def _itself(bundle: Bundle) -> Bundle:
    return bundle


def _item(rows: tuple[Bundle, ...], place: int) -> Bundle:
    return rows[place]


_refers: Any = _itself if PURE_PYTHON else intrinsic(_refer)
_wholes: Any = _itself if PURE_PYTHON else intrinsic(_whole_of)
_reads: Any = _item if PURE_PYTHON else intrinsic(_row_of)
refer: Callable[[Bundle], Bundle] = _refers
whole_of: Callable[[Bundle], Bundle] = _wholes
row_of: Callable[[tuple[Bundle, ...], int], Bundle] = _reads
