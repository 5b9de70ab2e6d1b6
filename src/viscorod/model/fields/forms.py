"""Forms of values as JSON Schema, and the form of a field with its units.

The numbers of a form say which unit of their field is theirs: the first unless stated otherwise. In a schema ``x-unit``
is the SI unit of a number: "*" is that of the quantity which a function of time stands for. ``x-unit-by`` picks it by
another key of the same table.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

__all__ = [
    "NAME",
    "NOT_NEGATIVE",
    "POSITIVE",
    "TEXT",
    "Form",
    "blocks",
    "in_units",
    "listed",
    "named_or",
    "of_kind",
    "quantity",
    "row",
    "word_table",
]

Form: TypeAlias = dict[str, Any]

QUANTITY: Form = {"$ref": "#/definitions/quantity"}
TEXT: Form = {"type": "string"}
POSITIVE: Form = {"exclusiveMinimum": 0}
NOT_NEGATIVE: Form = {"minimum": 0}
NAME: Form = {"type": "string", "pattern": "^[A-Za-z_][A-Za-z0-9_-]{0,59}$"}


def quantity(*others: Form, bounds: Form | None = None, unit: int = 0) -> Form:
    """Return the form of a number.

    Args:
        others: forms that may stand in its place.
        bounds: as in JSON Schema, such as ``{"minimum": 0}``.
        unit: place of its unit among those of the field.
    """
    return {"anyOf": [{"type": "number", **(bounds or {})}, *others], "x-unit": unit}


def listed(item: Form, least: int = 0, most: int | None = None) -> Form:
    """Return the form of a list of values of one form."""
    found: Form = {"type": "array", "items": item}
    return found | ({"minItems": least} if least else {}) | ({"maxItems": most} if most is not None else {})


def row(items: Sequence[Form]) -> Form:
    """Return the form of a list that has a form for each of its values."""
    return {"type": "array", "items": list(items), "minItems": len(items), "maxItems": len(items)}


def word_table(words: Sequence[str], *others: Form, bounds: Form | None = None) -> Form:
    """Return the form of a table from words to numbers: three in the field's first unit, others in its last."""
    numbers = {
        word: quantity(*others, bounds=bounds, unit=-1 if k > 2 else 0) for k, word in enumerate(words)
    }
    return {"type": "object", "properties": numbers, "additionalProperties": False}


def blocks(*others: Form) -> Form:
    """Return the form of six numbers (a diagonal) or 6 rows of 6, in units of force, coupling and moment; or others."""
    rows = [row([quantity(unit=(i > 2) + (j > 2)) for j in range(6)]) for i in range(6)]
    return {"anyOf": [row([quantity(unit=2 * (i > 2)) for i in range(6)]), row(rows), *others]}


def of_kind(name: str) -> Form:
    """Return a reference to a definition of the schema."""
    return {"$ref": f"#/definitions/{name}"}


def named_or(name: str) -> Form:
    """Return the form of what is given by its name or by its table."""
    return {"anyOf": [NAME, of_kind(name)]}


def in_units(form: Any, units: Sequence[str]) -> Any:
    """Return `form` with the units of a field at its numbers; those with one may be texts such as "10 mm"."""
    if isinstance(form, list):
        return [in_units(item, units) for item in form]
    if not isinstance(form, dict):
        return form
    found = {key: in_units(item, units) for key, item in form.items()}
    if "x-unit" not in form:
        return found
    unit = units[form["x-unit"]] if units else "1"
    number, *others = found["anyOf"]
    if unit == "1" and not others:
        return number
    return found | {"anyOf": [number, *([QUANTITY] if unit != "1" else []), *others], "x-unit": unit}
