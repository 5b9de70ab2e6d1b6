"""Quantities such as "10 mm", or those of Pint and Astropy, as plain SI numbers: by the forms of the fields."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from viscorod.errors import Fault
from viscorod.model.fields.faulty_value import FaultyValue
from viscorod.model.fields.forms import in_units
from viscorod.model.fields.metadata import accepted, units_of
from viscorod.units import (
    Conversion,
    Measured,
    is_quantity,
    looks_like_quantity,
    si_quantity,
    si_value,
    waiting,
)
from viscorod.wording import RefusedError, path_text, show

__all__ = ["SIWalk", "has_quantity", "in_si"]

PLAIN = "1"


def in_si(kind: Any, data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the values of the fields of a class in SI; one that is refused becomes a mark that says why."""
    if not has_quantity(data):
        return data
    return SIWalk({}, reported=False).table(_form_of(kind, len(kind.model_fields)), data, (), "")


@cache
def _form_of(kind: Any, fields: int) -> Mapping[str, Any]:
    """Return the forms of the fields of a class; how many there are only keys the cache."""
    del fields
    found = {name: (accepted(field), units_of(field)) for name, field in kind.model_fields.items()}
    forms = {
        name: in_units(known.form, units) for name, (known, units) in found.items() if known and known.form
    }
    return {"properties": forms, "x-former": kind.renamed}


def has_quantity(value: Any) -> bool:
    """Say whether a value is, or holds, a quantity."""
    if isinstance(value, int | float):  # most are plain numbers
        return False
    if isinstance(value, str):
        return looks_like_quantity(value)
    if isinstance(value, dict | Mapping):
        return any(map(has_quantity, value.values()))
    if isinstance(value, list | tuple):
        return any(map(has_quantity, value))
    return value is not None and (waits(value) or is_quantity(value))


def waits(value: Any) -> bool:
    """Say whether a value is a function of time with numbers that wait for what they measure."""
    if not getattr(type(value), "of_anything", False):
        return False
    return any(
        isinstance(item, Measured)
        for part in value.__dict__.values()
        for item in (part if isinstance(part, tuple) else (part,))
    )


class SIWalk:
    """A walk through a content and the schema side by side.

    Args:
        definitions: of the schema; what refers to others is left as it is, for its own class to read.
        reported: whether ``problems`` are reported from here, and not where the values are checked.
    """

    def __init__(self, definitions: Mapping[str, Any], *, reported: bool) -> None:
        self.definitions, self.reported = definitions, reported
        self.found: list[Conversion] = []
        self.problems: list[Fault] = []

    def value(self, form: Mapping[str, Any], value: Any, path: tuple[str | int, ...], around: str) -> Any:
        """Return `value` in SI. `around` is the unit of what a function of time stands for."""
        unit = form.get("x-unit", "")
        unit = unit.replace("*", around) if "*" in unit and around else unit
        if waits(value):
            return self.function_of_time(value, _written(unit) or PLAIN, path)
        if is_quantity(value):
            units = [unit] if unit else list(_units_in(form))
            return self.number(value, " or ".join(map(_written, units)) or PLAIN, path)
        if isinstance(value, str):
            if unit and looks_like_quantity(value):
                return self.number(value, _written(unit), path)
            return self.number(value, PLAIN, path) if _numeric(form) and looks_like_quantity(value) else value
        if not isinstance(value, Mapping | list | tuple):
            return value
        choice = "oneOf" in form and "properties" not in form
        if choice or any(key in form for key in ("$ref", "allOf", "anyOf")):
            branch = self.branch(form, value)
            return value if branch is None else self.value(branch, value, path, unit or around)
        if isinstance(value, Mapping):
            return self.table(form, value, path, around) if form.get("type") == "object" else value
        return self.items(form, value, path, around) if form.get("type") == "array" else value

    def table(
        self, form: Mapping[str, Any], table: Mapping[str, Any], path: tuple[str | int, ...], around: str
    ) -> dict[str, Any]:
        """Return a table in SI; keys that are not known stay."""
        keys, others = form.get("properties", {}), form.get("additionalProperties")
        former = form.get("x-former", {})
        found = {}
        for key, item in table.items():
            inner = keys.get(former.get(key, key), others if isinstance(others, Mapping) else None)
            if inner is not None and "x-unit-by" in inner:
                other, units = inner["x-unit-by"]
                word = table.get(other)
                unit = units.get(word) if isinstance(word, str) else None
                inner = {**inner, **({"x-unit": unit} if unit else {})}
            found[key] = item if inner is None else self.value(inner, item, (*path, key), around)
        return found

    def items(
        self, form: Mapping[str, Any], items: Any, path: tuple[str | int, ...], around: str
    ) -> list[Any]:
        """Return the items of a list in SI."""
        each = form.get("items", {})
        forms = each if isinstance(each, list) else [each] * len(items)
        forms = [*forms, *([{}] * (len(items) - len(forms)))]
        return [
            self.value(inner, item, (*path, index), around)
            for index, (inner, item) in enumerate(zip(forms, items, strict=False))
        ]

    def function_of_time(self, value: Any, unit: str, path: tuple[str | int, ...]) -> Any:
        """Return a function of time in the unit of what it describes."""
        changes: dict[str, Any] = {}
        kind: Any = type(value)
        for name, form in _form_of(kind, len(kind.model_fields))["properties"].items():
            own = next((one for one in _units_in(form) if "*" in one), None)
            item = value.__dict__[name]
            if own is None or item is None:
                continue
            needed = _written(own.replace("*", unit))
            each = [
                self.number(one.given, needed, (*path, name)) if isinstance(one, Measured) else one
                for one in (item if isinstance(item, tuple) else (item,))
            ]
            refused = next((one for one in each if isinstance(one, FaultyValue)), None)
            if refused is not None:
                return refused
            changes[name] = each if isinstance(item, tuple) else each[0]
        return value.replaced(**changes)

    def branch(self, form: Mapping[str, Any], value: Any) -> Mapping[str, Any] | None:
        """Find the one of several forms that a table or list is meant to have."""
        if "$ref" in form:
            return self.definitions.get(form["$ref"].removeprefix("#/definitions/"))
        for key in ("allOf", "anyOf", "oneOf"):
            for inner in form.get(key, ()):
                if self.fits(inner, value):
                    return self.branch(inner, value) if "$ref" in inner else dict(inner)
        return None

    def fits(self, form: Mapping[str, Any], value: Any) -> bool:
        """Say whether a table or list may have a form."""
        while "$ref" in form:
            form = self.definitions.get(form["$ref"].removeprefix("#/definitions/"), {"type": ""})
        if "type" not in form:
            return any(
                self.fits(inner, value) for key in ("allOf", "anyOf", "oneOf") for inner in form.get(key, ())
            )
        if isinstance(value, Mapping):
            if form["type"] != "object":
                return False
            words = {
                key: inner["const"] for key, inner in form.get("properties", {}).items() if "const" in inner
            }
            required = form.get("required", ())
            return all(
                value[key] == word if key in value else key not in required for key, word in words.items()
            )
        if form["type"] != "array":
            return False
        first = form["items"][0] if isinstance(form["items"], list) else form["items"]
        nested = bool(value) and isinstance(value[0], list | tuple)
        return nested is bool(first.get("type") == "array")

    def number(self, given: Any, unit: str, path: tuple[str | int, ...]) -> Any:
        """Return a quantity, as text or as an object of a library of units, in the SI unit that is needed."""
        key = next(str(part) for part in reversed(path) if isinstance(part, str))
        where = path_text(path)
        try:
            if "*" in unit and not self.reported:
                return waiting(given)
            if "*" in unit:
                raise RefusedError(
                    "the unit is that of what the function of time describes, which is not known here",
                    "give a plain number, in SI",
                )
            if " or " in unit:
                raise RefusedError(
                    f"its numbers have different units, {unit}", "give them one by one, each with its own"
                )
            value = si_value(given, unit, key) if isinstance(given, str) else si_quantity(given, unit, key)
        except RefusedError as error:
            self.problems.append(Fault(where, show(given), error.why, error.instead))
            return FaultyValue(given, error.why, error.instead, reported=self.reported)
        if isinstance(value, float):
            self.found.append(Conversion(where, str(given), value, unit))
        return value


def _numeric(form: Mapping[str, Any]) -> bool:
    """Say whether a plain number is meant."""
    return form.get("type") == "number"


def _units_in(form: Any) -> dict[str, None]:
    """Return the units of all numbers of a form, each once."""
    if isinstance(form, Mapping):
        own = form.get("x-unit")
        return {str(own): None} if own else _units_in(list(form.values()))
    found: dict[str, None] = {}
    for part in form if isinstance(form, list) else ():
        found |= _units_in(part)
    return found


def _written(unit: str) -> str:
    """Write the unit of a rate in one piece."""
    return unit.replace("/s/s", "/s^2")
