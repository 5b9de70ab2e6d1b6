"""The base of everything that a user describes: frozen, strict, positional, with readable errors.

Pydantic checks the fields; this module turns what it reports into `InputError`s in the words of the user. The
same classes serve the Python API (``Rectangle(0.01, 0.02)``) and the case files (``shape = "rectangle"``).
"""

from __future__ import annotations

import inspect
import math
import textwrap
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar, dataclass_transform

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from viscorod.attributes import UnknownAttributeError
from viscorod.errors import Fault, InputError, users_level
from viscorod.model.fields.faults import at_key, problems_from, problems_of
from viscorod.model.fields.faulty_value import FaultyValue
from viscorod.model.fields.metadata import Key, accepted, expected, meaning, units_of
from viscorod.model.fields.quantities import in_si
from viscorod.model.fields.signature import Words, parameters, signature
from viscorod.quantity_text import quantity
from viscorod.shown import Shown
from viscorod.units import looks_like_quantity
from viscorod.wording import RefusedError, did_you_mean, nearest_key, path_text, show, some_of

__all__ = [
    "Definition",
    "FaultyValue",
    "RefusedError",
    "at_key",
    "base_init",
    "did_you_mean",
    "path_text",
    "plain_value",
    "problems_from",
    "problems_of",
    "show",
    "some_of",
]

F = TypeVar("F", bound=Callable[..., Any])

_LINE = 110
"""Letters of a line for ``repr``."""
_ARGUMENT = textwrap.TextWrapper(100, " " * 4, " " * 8, break_long_words=False, break_on_hyphens=False)


def base_init(function: F) -> F:
    """Mark an ``__init__`` that pydantic need not call for nested tables: their errors keep their paths."""
    function.__dict__["__pydantic_base_init__"] = True
    return function


def _documented(cls: type[Definition]) -> str | None:
    """Return the docstring of a class, with its arguments from the descriptions and units of its fields.

    It is made when it is read: for all classes that takes a twelfth of what importing this package does.
    """
    text: str | None = cls.__dict__.get("__doc__")
    lines = _arguments(cls) if text else []
    return "\n".join([inspect.cleandoc(text), "", "Args:", *lines]) if text and lines else text


def _reworded(cls: type[Definition], text: str | None) -> None:
    """Give a class another docstring."""
    type.__dict__["__doc__"].__set__(cls, text)


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as DefinitionType
else:

    class DefinitionType(type(BaseModel)):  # the class of the classes: shows what they have beside Pydantic's
        __doc__ = property(_documented, _reworded)

        @property
        def __signature__(cls) -> inspect.Signature:
            """The arguments; a property, since Pydantic sets its own when it builds the validator of a class."""
            own = list(inspect.signature(cls.__init__).parameters.values())[1:]
            if all(one.kind is not one.VAR_KEYWORD for one in own):
                return signature([one.replace(annotation=Words(one.annotation)) for one in own])
            left_out = (*cls.unused, *([cls.tag] if cls.tag else []))
            return signature(parameters(cls.model_fields, left_out))

        @__signature__.setter
        def __signature__(cls, _given: object) -> None:
            pass

        def __dir__(cls) -> list[str]:
            return _own_names(type.__dir__(cls))

        def __getattr__(cls, name: str) -> Any:
            """Refuse a name that is not there, with the nearest one that is."""
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name.startswith("_") or name in _INHERITED:
                    raise
                raise UnknownAttributeError.of(cls, name, called=cls.__name__) from None


_INHERITED = frozenset(dir(BaseModel))


def _own_names(names: Iterable[str]) -> list[str]:
    """Return the names for editors and ``help``."""
    return sorted(name for name in names if not name.startswith("_") and name not in _INHERITED)


@dataclass_transform(kw_only_default=False, field_specifiers=(Field, Key))
class Definition(BaseModel, Shown, metaclass=DefinitionType):
    """Base class of the user's objects: immutable; unknown keys refused; errors are `InputError`.

    Constructor arguments may be given by position, in the order of the fields, or by name.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True, defer_build=True)

    #: The field with the kind of an object in a case file (``shape`` or ``kind``); always written out.
    tag: ClassVar[str | None] = None

    #: Former names of fields, which are understood with a warning, and the present ones.
    renamed: ClassVar[dict[str, str]] = {}

    #: Words that are no fields and are often taken for one, and what to give instead.
    hints: ClassVar[dict[str, str]] = {}

    #: Whether it is a function of time, of anything: its numbers may wait for what they measure.
    of_anything: ClassVar[bool] = False

    #: Fields that the class inherits and refuses to fill: its users need not know of them.
    unused: ClassVar[tuple[str, ...]] = ()

    @base_init
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        cls = type(self)
        named = _bind(cls, args, kwargs)
        try:
            super().__init__(**named)
        except ValidationError as error:
            raise InputError(p.within(cls.__name__) for p in problems_from(error)) from None

    if not TYPE_CHECKING:  # or every name would pass for an attribute

        def __getattr__(self, name: str) -> Any:
            """Refuse a name that is not there, with the nearest one that is."""
            try:  # Pydantic finds what is private too, in ten times as long
                private = object.__getattribute__(self, "__pydantic_private__")
            except AttributeError:  # of an object that was refused
                private = None
            if private is not None and name in private:
                return private[name]
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name.startswith("_") or hasattr(type(self), name):
                    raise
                raise UnknownAttributeError.of(self, name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse a change, for what was checked together stays as it is."""
        private = name.startswith("_")
        if name in type(self).model_fields or not (private or hasattr(type(self), name)):
            raise InputError(
                Fault(
                    f"{type(self).__name__}.{name}",
                    "",
                    "it is frozen, and cannot be changed",
                    f"make another: replaced({name}={show(value)})"
                    if name in type(self).model_fields
                    else "make another",
                )
            )
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return _own_names(super().__dir__())

    def replaced(self, **changes: Any) -> Self:
        """Return another that was given other values for some of its arguments, which are checked again.

        Raises:
            InputError: there is no such argument, or it cannot have this value.
        """
        kept = {name: getattr(self, name) for name in self.model_fields_set if name not in changes}
        return type(self)(**kept, **changes)

    def __repr__(self) -> str:
        """Return one line: what it was given, without what was left out."""
        whole = f"{type(self).__name__}({', '.join(self._words_given(_written))})"
        if len(whole) <= _LINE:
            return whole
        short = ", ".join(self._words_given(_in_short))
        return (
            f"{type(self).__name__}({short if len(short) <= 2 * _LINE else short[: 2 * _LINE - 3] + '...'})"
        )

    def __str__(self) -> str:
        return repr(self)

    def _words_given(self, text: Callable[[Any], str]) -> Iterator[str]:
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            same = not field.is_required() and (value is field.default or _same(value, field.default))
            if name != self.tag and name in self.model_fields_set and not same:
                yield f"{name}={text(value)}"

    def _facts(self) -> Iterator[str]:
        for name, field in type(self).model_fields.items():
            value, units = getattr(self, name), units_of(field)
            if name == self.tag or name not in self.model_fields_set or value is None:
                continue
            unit = f" {units[0]}" if len(units) == 1 and units[0] not in ("1", "*") else ""
            told = (
                quantity(value, units[0])
                if unit and isinstance(value, float)
                else f"{_in_words(value)}{unit}"
            )
            yield f"{name.replace('_', ' ')}: {told}"

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy, with other fields; what was computed of the fields before is left behind."""
        copied = super().model_copy(update=update, deep=deep)
        for name in copied.__dict__.keys() - type(self).model_fields.keys():
            del copied.__dict__[name]
        return copied

    def __eq__(self, other: object) -> bool:
        """Return whether both are of one class and were given the same; values computed since are ignored."""
        if not isinstance(other, Definition):
            return NotImplemented
        if type(self) is not type(other) or self.__pydantic_private__ != other.__pydantic_private__:
            return False
        return all(_same(getattr(self, name), getattr(other, name)) for name in type(self).model_fields)

    def __hash__(self) -> int:
        return hash((type(self), *(getattr(self, name) for name in type(self).model_fields)))

    @model_validator(mode="before")
    @classmethod
    def _mark_keys(cls, data: Any) -> Any:
        if isinstance(data, cls):
            return data
        if not isinstance(data, Mapping):
            raise RefusedError("a table of keys and values is needed here", f"give {_keys(cls)}")
        data = in_si(cls, _with_present_names(cls, data))
        marked = {str(key): value for key, value in data.items()}
        for key in data:
            if key not in cls.model_fields and not isinstance(data[key], FaultyValue):
                marked[str(key)] = _unknown(cls, str(key), data)
        for name, field in cls.model_fields.items():
            if field.is_required() and name not in data:
                words = expected(field)
                what = f"add {name} ({words})" if words else f"add {name}"
                marked[name] = FaultyValue(None, "this key is required and missing", what)
        return marked

    def to_dict(self) -> dict[str, Any]:
        """Return the object as plain data in the words of the case file; defaults are left out."""
        plain: dict[str, Any] = {}
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if name == self.tag or (
                name in self.model_fields_set and (field.is_required() or value != field.default)
            ):
                plain[name] = plain_value(value)
        return plain


def _same(one: Any, other: Any) -> bool:
    """Say whether two values are the same; numbers that were not given (NaN) are."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


def _written(value: Any) -> str:
    """Return a value as it is typed, numbers without digits that say nothing."""
    if isinstance(value, float) and float(f"{value:g}") == value:
        return f"{value:g}"
    if isinstance(value, tuple):
        items = ", ".join(map(_written, value))
        return f"({items},)" if len(value) == 1 else f"({items})"
    return repr(value)


def _in_short(value: Any) -> str:
    """Return a value as it is typed, and a definition or a long list in short."""
    return _written(value) if isinstance(value, float) else show(value)


def _in_words(value: Any) -> str:
    """Return a value for a card."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple) and value and all(isinstance(item, float) for item in value):
        return show([float(f"{item:.6g}") for item in value])
    return repr(value) if isinstance(value, Definition) else show(value)


def _arguments(cls: type[Definition]) -> list[str]:
    """Return lines of a docstring about the fields of a class, those given by position first."""
    lines: list[str] = []
    for name, field in sorted(cls.model_fields.items(), key=lambda item: item[1].kw_only is True):
        check, text = accepted(field), meaning(field)
        if not text or name == cls.tag or name in cls.unused:
            continue
        python = f", {check.python} (in Python only)" if check and check.python else ""
        text = f"{name}: {text}{python}{'; by name only' if field.kw_only else ''}."
        lines += _ARGUMENT.wrap(text)
    return lines


def _with_present_names(cls: type[Definition], data: Mapping[Any, Any]) -> Mapping[Any, Any]:
    """Return the values of a table under the present names of its keys; a former name beside the present one stays."""
    former = {key: cls.renamed[key] for key in data if key in cls.renamed and cls.renamed[key] not in data}
    for key, name in former.items():
        warnings.warn(f"{key} is now {name}", DeprecationWarning, stacklevel=users_level())
    return {former.get(key, key): value for key, value in data.items()} if former else data


def plain_value(value: Any) -> Any:
    """Return `value` with tuples as lists, described objects as dicts and functions as a note."""
    if isinstance(value, Definition):
        return value.to_dict()
    if isinstance(value, Mapping):
        return {str(key): plain_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_value(item) for item in value]
    if callable(value):
        return f"<Python function {getattr(value, '__qualname__', type(value).__name__)}>"
    return value


def _unknown(cls: type[Definition], key: str, data: Mapping[Any, Any]) -> FaultyValue:
    close = nearest_key(key, cls.model_fields, data)
    advice = (
        f"did you mean {close}? The keys here are {_keys(cls)}"
        if close
        else f"the keys here are {_keys(cls)}"
    )
    advice = cls.hints.get(key, advice)
    return FaultyValue(data.get(key), "no such key", advice, replaces=close or "")


def _keys(cls: type[Definition]) -> str:
    """Return the keys, those first that are given by position."""
    return ", ".join(sorted(cls.model_fields, key=lambda name: cls.model_fields[name].kw_only is True))


def _bind(cls: type[Definition], args: tuple[Any, ...], kwargs: dict[str, Any]) -> dict[str, Any]:
    """Return positional arguments by the names of the fields, in their order."""
    if not args:
        return kwargs
    names = [name for name, field in cls.model_fields.items() if not field.kw_only]
    if len(args) > len(names):
        raise InputError(
            Fault(cls.__name__, f"{len(args)} positional arguments", f"at most {len(names)} are understood",
                    f"give them in the order {', '.join(names) or '(none)'} or by name")
        )  # fmt: skip
    by_name = "file" in cls.model_fields and names[0] != "file"
    if by_name and isinstance(args[0], str) and not looks_like_quantity(args[0]):
        raise InputError(
            Fault(
                f"{cls.__name__}.{names[0]}",
                show(args[0]),
                "a text by position",
                f"give a file by name: file={args[0]!r}",
            )
        )
    named = dict(zip(names, args, strict=False))
    twice = sorted(named.keys() & kwargs.keys())
    if twice:
        found, why = show(kwargs[twice[0]]), "given twice, by position and by name"
        raise InputError(Fault(f"{cls.__name__}.{twice[0]}", found, why, "give it once"))
    return named | kwargs
