"""Metadata of fields: the check of the values with their form, what the field means, and its units.

    width: Positive = Key("along d1", "m")

is a whole field. Its documentation, its JSON Schema and the conversion of quantities such as "10 mm" all read this
line. `Positive` is a number with its `Check`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from pydantic import Field, GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from viscorod.model.fields.forms import Form

__all__ = [
    "Accepts",
    "Check",
    "Key",
    "accepted",
    "accepts",
    "expected",
    "meaning",
    "optional",
    "units_of",
]

T = TypeVar("T")

TABLES = "list of tables, see below"
"""A list of objects, in words."""


@dataclass(frozen=True, eq=False, repr=False)
class Accepts:
    """What a field accepts.

    Attributes:
        form: in a case file, as JSON Schema without units (see ``forms``); None for what only Python can give.
        words: the same for people.
        python: what else it accepts in Python.
    """

    form: Form | None
    words: str = ""
    python: str = ""

    def __repr__(self) -> str:
        """Return what stands in the signature of a class."""
        return self.words or type(self).__name__


@dataclass(frozen=True, eq=False, repr=False)
class Check(Accepts, Generic[T]):
    """A function that checks and converts the values of a field, and what it accepts.

    Attributes:
        read: value as given -> value of the field; raises `RefusedError`.
    """

    read: Callable[[Any], T] = field(kw_only=True)

    def __call__(self, value: Any) -> T:
        """Return the checked value."""
        return self.read(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of Pydantic: nothing but this check."""
        return core_schema.no_info_plain_validator_function(self.read)


def accepts(form: Form | None, words: str = "", python: str = "") -> Callable[[Callable[[Any], T]], Check[T]]:
    """Make a `Check` of a function."""
    return lambda read: Check(form, words, python, read=read)


def optional(check: Check[T]) -> Check[T | None]:
    """Return `check` with None let through."""
    return Check(
        check.form, check.words, check.python, read=lambda value: None if value is None else check(value)
    )


def Key(text: str, *units: str, **more: Any) -> Any:
    """Declare a field, as Pydantic's ``Field`` does, with what its users need to know.

    Args:
        text: what it means, in the words of the case file, without a full stop. The units stand at its end, or where
            it has braces for them.
        units: SI units of its numbers, such as "N/m"; which number has which of several, its form says. "1" is that of
            numbers without a unit beside others with one, "*" that of what a function of time describes.
        more: arguments of ``Field``, such as ``default`` and ``kw_only``.
    """
    return Field(description=text, json_schema_extra={"units": list(units)}, **more)


def accepted(info: FieldInfo) -> Accepts | None:
    """Return what a field accepts."""
    return next((item for item in info.metadata if isinstance(item, Accepts)), None)


def units_of(info: FieldInfo) -> tuple[str, ...]:
    """Return the units of a field."""
    extra: Any = info.json_schema_extra or {}
    return tuple(extra.get("units", ()))


def meaning(info: FieldInfo) -> str:
    """Return the description of a field with its units: where it has braces for them, else at its end."""
    symbols, text = units_of(info), info.description or ""
    if not symbols or "*" in symbols[0]:
        return text
    return text.format(*symbols) if "{" in text else ", ".join([*([text] if text else []), *symbols])


def expected(info: FieldInfo) -> str:
    """Return what a value of the field must be, for a message: "number > 0, m"."""
    found, symbols = accepted(info), units_of(info)
    words = [found.words.replace("`", "") if found else "", " or ".join(symbols)]
    return ", ".join(word for word in words if word and "*" not in word)
