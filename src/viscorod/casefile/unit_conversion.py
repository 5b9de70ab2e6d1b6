"""Convert the quantities of a case file ("10 mm") to plain SI numbers."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from viscorod.casefile.units import Conversion, looks_like_quantity, si_value
from viscorod.errors import Fault
from viscorod.model.fields.definition import FaultyValue, RefusedError, path_text, show

__all__ = ["converted", "unit_at"]

PLAIN = "1"


def converted(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], list[Conversion], list[Fault]]:
    """Return the content in SI, what was converted, and what is wrong with quantities.

    A quantity that is refused becomes a mark, so that it is reported once. Texts stay where texts are meant, and
    where no key is known.
    """
    if not _has_quantity(data):
        return data, [], []
    from viscorod.casefile.json_schema import forms

    schema = forms()
    walk = _Walk(schema["definitions"])
    return walk.table(schema, data, (), ""), walk.found, walk.problems


def unit_at(data: Mapping[str, Any], key: str) -> str:
    """Return the SI unit of the number at a key of a content, "1" of a plain number, empty where none is known."""
    from viscorod.casefile.case_keys import parts_of, put
    from viscorod.casefile.json_schema import forms

    content = copy.deepcopy(dict(data))
    put(content, key, "1 m")
    schema = forms()
    walk = _UnitWalk(schema["definitions"], tuple(parts_of(key)))
    walk.table(schema, content, (), "")
    return walk.unit


def _has_quantity(value: Any) -> bool:
    if isinstance(value, Mapping):
        return any(map(_has_quantity, value.values()))
    if isinstance(value, list | tuple):
        return any(map(_has_quantity, value))
    return isinstance(value, str) and looks_like_quantity(value)


class _Walk:
    """A walk through a content and the schema side by side."""

    def __init__(self, definitions: Mapping[str, Any]) -> None:
        self.definitions = definitions
        self.found: list[Conversion] = []
        self.problems: list[Fault] = []

    def value(self, form: Mapping[str, Any], value: Any, path: tuple[str | int, ...], around: str) -> Any:
        """Return `value` in SI. `around` is the unit of what a function of time stands for."""
        unit = form.get("x-unit", "")
        unit = unit.replace("*", around) if "*" in unit else unit
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
        each = form.get("items", {})
        forms = each if isinstance(each, list) else [each] * len(items)
        forms = [*forms, *([{}] * (len(items) - len(forms)))]
        return [
            self.value(inner, item, (*path, index), around)
            for index, (inner, item) in enumerate(zip(forms, items, strict=False))
        ]

    def branch(self, form: Mapping[str, Any], value: Any) -> Mapping[str, Any] | None:
        """Find the one of several forms that a table or list is meant to have."""
        if "$ref" in form:
            found: Mapping[str, Any] = self.definitions[form["$ref"].removeprefix("#/definitions/")]
            return found
        for key in ("allOf", "anyOf", "oneOf"):
            for inner in form.get(key, ()):
                if self.fits(inner, value):
                    return self.branch(inner, value) if "$ref" in inner else dict(inner)
        return None

    def fits(self, form: Mapping[str, Any], value: Any) -> bool:
        while "$ref" in form:
            form = self.definitions[form["$ref"].removeprefix("#/definitions/")]
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

    def number(self, text: str, unit: str, path: tuple[str | int, ...]) -> Any:
        key = next(str(part) for part in reversed(path) if isinstance(part, str))
        where = path_text(path)
        try:
            value = si_value(text, unit, key)
        except RefusedError as error:
            self.problems.append(Fault(where, show(text), error.why, error.instead))
            return FaultyValue(text, reported=True)
        self.found.append(Conversion(where, text, value, unit))
        return value


class _UnitWalk(_Walk):
    """A walk that notes the unit of what stands at one key."""

    def __init__(self, definitions: Mapping[str, Any], wanted: tuple[str | int, ...]) -> None:
        super().__init__(definitions)
        self.wanted, self.unit = wanted, ""

    def number(self, text: str, unit: str, path: tuple[str | int, ...]) -> Any:
        if path == self.wanted:
            self.unit = unit
        return text


def _numeric(form: Mapping[str, Any]) -> bool:
    """Say whether a plain number is meant."""
    return form.get("type") == "number"


def _written(unit: str) -> str:
    """Write the unit of a rate in one piece."""
    return unit.replace("/s/s", "/s^2")
