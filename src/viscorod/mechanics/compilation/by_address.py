"""Calls from one kernel to another that is compiled by itself, through its address.

A kernel that calls another contains its code, which is optimised once more in every caller. A loop that calls large
kernels takes their addresses instead, numbers in its arguments: it is compiled quickly, machine code on disk stays
valid, and the numbers are those of the same kernel when Python calls it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.references import numbers_of, referred

__all__ = ["address_of", "far", "returning", "sharing"]

_alloca: Any = cgutils.alloca_once
_unliteral: Any = types.unliteral


def address_of(known: KnownTypes, result: Any, arguments: Callable[[], tuple[Any, ...]]) -> int:
    """Return the address of a kernel that returns a ``result``; ``arguments`` are asked for if types are unknown.

    In pure Python, where nothing is at an address, it is 1: there is such a kernel.
    """
    if PURE_PYTHON:
        return 1
    compiled = known.compiled(arguments() if known.unknown else ())
    if compiled.signature.return_type != result:
        raise TypeError(f"{compiled.fndesc.qualname} returns {compiled.signature.return_type}, not {result}")
    return _place(compiled.library, compiled.fndesc.llvm_func_name)


@functools.cache
def _place(library: Any, name: str) -> int:
    found: int = library.get_pointer_to_function(name)
    return found


def far(kernel: Callable[..., Any], result: Any) -> Callable[[int, tuple[Any, ...]], Any]:
    """Return what calls ``kernel``, which returns a ``result``, by its address; in pure Python the kernel itself.

    Bundles stand for references to them among the arguments, or in bundles of them.
    """
    return _calling(kernel) if PURE_PYTHON else returning(result)


def sharing(kernel: Callable[..., Any], result: Any) -> Callable[[int, tuple[Any, ...]], Any]:
    """Do what :func:`far` does for a kernel that takes references."""
    return _calling(kernel) if PURE_PYTHON else returning(result, whole=False)


def _calling(kernel: Callable[..., Any]) -> Callable[[int, tuple[Any, ...]], Any]:
    return lambda _, arguments: kernel(*arguments)


def returning(result: Any, *, whole: bool = True) -> Callable[[int, tuple[Any, ...]], Any]:
    """Return what calls a kernel that returns a ``result`` from compiled code, by its address and arguments.

    Args:
        result: its type; whole: bundles stand for references to them among the arguments, or in bundles of them.
    """

    def invoke(_context: Any, address: Any, arguments: Any) -> Any:
        kinds = tuple(referred(kind) if whole else _unliteral(kind) for kind in arguments)

        def generate(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            kind = context.call_conv.get_function_type(result, kinds)
            flat = numbers_of(context, builder, arguments, given[1], whole=whole)
            out, error = (_alloca(builder, kind.args[k].pointee) for k in range(2))
            builder.call(builder.inttoptr(given[0], ir.PointerType(kind)), [out, error, *flat])
            return context.get_returned_value(builder, result, builder.load(out))

        return result(address, arguments), generate

    def invoke_python(address: int, arguments: tuple[Any, ...]) -> Any:
        raise AssertionError(f"in pure Python nothing is at {address} for {len(arguments)} arguments")

    chosen: Any = invoke_python if PURE_PYTHON else intrinsic(invoke)
    found: Callable[[int, tuple[Any, ...]], Any] = chosen
    return found
