"""Signatures as people read them: names, kinds of values and defaults, without what checks them."""

from __future__ import annotations

import collections.abc
import inspect
import math
import types
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic.fields import FieldInfo

__all__ = ["Words", "parameters", "plain_type", "signature"]


class Words(str):
    """Text that stands in a signature as it is, without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def parameters(fields: Mapping[str, FieldInfo], left_out: tuple[str, ...] = ()) -> list[inspect.Parameter]:
    """Return the parameters of what is made of fields: those given by position first, in their order."""
    found = []
    for name, known in sorted(fields.items(), key=lambda item: bool(item[1].kw_only)):
        if name in left_out:
            continue
        kind = inspect.Parameter.KEYWORD_ONLY if known.kw_only else inspect.Parameter.POSITIONAL_OR_KEYWORD
        found.append(
            inspect.Parameter(
                name, kind, default=_default(known), annotation=Words(plain_type(known.annotation))
            )
        )
    return found


def signature(given: list[inspect.Parameter]) -> inspect.Signature:
    """Return a signature, also where something must be given behind others that need not."""
    return inspect.Signature(given, __validate_parameters__=False)


def _default(known: FieldInfo) -> Any:
    if known.is_required():
        return inspect.Parameter.empty
    if isinstance(known.default, float) and math.isnan(
        known.default
    ):  # worked out from others, or checked later
        return Words("...")
    return known.default


def plain_type(kind: Any) -> str:
    """Return the name of a type, as in "float | None"."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is None or kind is type(None):
        return "None"
    if origin is Annotated:
        return plain_type(inner[0])
    if origin in (Union, types.UnionType):
        return " | ".join(dict.fromkeys(map(plain_type, inner)))
    if origin is Literal:
        return f"Literal[{', '.join(map(repr, inner))}]"
    if origin is collections.abc.Callable:
        *arguments, result = inner or (..., Any)
        words = "..." if arguments == [...] else f"[{', '.join(map(plain_type, *arguments))}]"
        return f"Callable[{words}, {plain_type(result)}]"
    if origin is not None:
        name = getattr(origin, "__name__", str(origin))
        if name == "ndarray":
            return "ndarray"
        words = ", ".join("..." if item is ... else plain_type(item) for item in inner)
        return f"{name}[{words}]" if words else name
    if isinstance(kind, TypeVar | str):
        return str(kind)
    return str(getattr(kind, "__name__", kind)).replace("typing.", "")
