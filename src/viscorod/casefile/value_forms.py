"""The form of every value of a case file as JSON Schema, from the check that reads it and the documented units.

``x-unit`` is the SI unit of a number: "*" is that of the quantity which a function of time stands for. An
``x-unit-by`` picks it by another key of the same table.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from viscorod.model.connections.motion_words import MOTIONS, VELOCITIES
from viscorod.solve.transient.integrators import INTEGRATORS

__all__ = ["Form", "form_of", "listed", "of_kind", "quantity"]

Form: TypeAlias = dict[str, Any]
Units: TypeAlias = tuple[str, ...]

QUANTITY = {"$ref": "#/definitions/quantity"}
TEXT: Form = {"type": "string"}
NAME: Form = {"type": "string", "pattern": "^[A-Za-z_][A-Za-z0-9_-]{0,59}$"}
BOUNDS: dict[str, Form] = {
    ">= 0": {"minimum": 0},
    "from 0 to 1": {"minimum": 0, "maximum": 1},
    "> -1 and <= 0.5 (0.5 is incompressible)": {"exclusiveMinimum": -1, "maximum": 0.5},
    "> 0": {"exclusiveMinimum": 0},
    "each >= 0": {"minimum": 0},
    "each > 0": {"exclusiveMinimum": 0},
}
POSITIVE: Form = {"exclusiveMinimum": 0}
PART: Form = {"exclusiveMinimum": 0, "exclusiveMaximum": 1}
NOT_NEGATIVE: Form = {"minimum": 0}


def quantity(units: Units, **bounds: Any) -> Form:
    """A number with the unit, if it has one: then also a text such as "10 mm"."""
    number: Form = {"type": "number", **bounds}
    if len(units) > 1:
        raise ValueError(f"one number cannot have the units {', '.join(units)}")
    return {"anyOf": [number, QUANTITY], "x-unit": units[0]} if units and units[0] != "1" else number


def listed(item: Form, least: int = 0, most: int | None = None) -> Form:
    """A list of values of one form."""
    found: Form = {"type": "array", "items": item}
    return found | ({"minItems": least} if least else {}) | ({"maxItems": most} if most is not None else {})


def _row(items: list[Form]) -> Form:
    return {"type": "array", "items": items, "minItems": len(items), "maxItems": len(items)}


def _triple(units: Units, **bounds: Any) -> Form:
    return listed(quantity(units, **bounds), 3, 3)


def _pairs(units: Units, count: int, least: int) -> Form:
    return listed(listed(quantity(units), count, count), least)


def _blocks(units: Units) -> Form:
    """Six numbers (a diagonal) or 6 rows of 6, in the units of the blocks force, coupling and moment."""

    def entry(i: int, j: int) -> Form:
        return quantity((units[(i > 2) + (j > 2)],))

    rows = [_row([entry(i, j) for j in range(6)]) for i in range(6)]
    return {"anyOf": [_row([entry(i, i) for i in range(6)]), _row(rows)]}


def _words(words: tuple[str, ...], units: Units, **bounds: Any) -> Form:
    """Numbers by words, of which the first three have the first unit and the others the last."""
    each = {word: quantity((units[-1 if k > 2 else 0],), **bounds) for k, word in enumerate(words)}
    return {"type": "object", "properties": each, "additionalProperties": False}


def _time(units: Units) -> Form:
    unit = units[0] if units else "1"
    alternatives = [{"type": "number"}, *([QUANTITY] if unit != "1" else []), of_kind("time")]
    return {"anyOf": alternatives, "x-unit": unit}


def _functions(words: tuple[str, ...], units: Units) -> Form:
    each = {word: _time((units[-1 if k > 2 else 0],)) for k, word in enumerate(words)}
    return {"type": "object", "properties": each, "additionalProperties": False}


def of_kind(name: str) -> Form:
    """A reference to a definition."""
    return {"$ref": f"#/definitions/{name}"}


def _named_or(name: str) -> Form:
    return {"anyOf": [NAME, of_kind(name)]}


Maker: TypeAlias = Callable[[Units], Form]

FORMS: dict[str, Maker] = {
    "number": quantity,
    "positive": lambda units: quantity(units, **POSITIVE),
    "word": lambda _: TEXT,
    "name_of_part": lambda _: NAME,
    "place_text": lambda _: TEXT,
    "end_text": lambda _: TEXT,
    "true_or_false": lambda _: {"type": "boolean"},
    "vector": _triple,
    "direction": _triple,
    "axes_of": lambda _: listed(_triple(()), 2, 3),
    "two_directions": lambda _: listed(_triple(()), 2, 2),
    "_sides": lambda units: _triple(units, **POSITIVE),
    "_density": _triple,
    "_anchor": lambda units: {"anyOf": [TEXT, _triple(units)]},
    "named_points": lambda units: {"type": "object", "additionalProperties": _triple(units)},
    "frequency_band": lambda units: listed(quantity(units, **POSITIVE), 2, 2),
    "_column": lambda units: listed(quantity(units), 1),
    "_several": lambda units: listed(quantity(units), 2),
    "_points": lambda units: _pairs(units, 3, 2),
    "corners": lambda units: _pairs(units, 2, 3),
    "rings": lambda units: listed(_pairs(units, 2, 3)),
    "pair": lambda units: listed(quantity(units), 2, 2),
    "_times": lambda units: listed(quantity(units, **NOT_NEGATIVE), 6, 6),
    "_strain": lambda units: _row([quantity((units[k > 2],)) for k in range(6)]),
    "_stiffness": _blocks,
    "_branch_stiffness": _blocks,
    "_inertia": _blocks,
    "stiffness_section._damping": _blocks,
    "body._inertia": lambda units: {"anyOf": [_triple(units, **POSITIVE), listed(_triple(units), 3, 3)]},
    "stiffness": quantity,
    "damping": lambda units: quantity(units, **NOT_NEGATIVE),
    "motion_functions": lambda units: _functions(MOTIONS, units),
    "velocity_functions": lambda units: _functions(VELOCITIES, units),
    "fixed_motions": lambda _: listed({"enum": list(MOTIONS)}),
    "fixed_velocities": lambda _: listed({"enum": list(VELOCITIES)}),
    "time_function": _time,
    "constraint_words": lambda _: {"anyOf": [TEXT, listed(TEXT)]},
    "_twist": quantity,
    "_ratio": lambda units: quantity(units, **PART),
    "_part": lambda units: quantity(units, **PART),
    "_decrement": lambda units: quantity(units, **POSITIVE),
    "_mode": lambda _: {"anyOf": [{"type": "integer", "minimum": 1, "maximum": 50}, TEXT]},
    "integrator_name": lambda _: {"enum": list(INTEGRATORS)},
    "_spin": lambda units: {
        "anyOf": [*quantity(units, **POSITIVE)["anyOf"], _triple(units)],
        "x-unit": units[0],
    },
    "material._damping": lambda _: of_kind("damping"),
    "_modulus_table": lambda _: of_kind("damping.other"),
    "composite._material": lambda _: _named_or("material"),
    "_some_regions": lambda _: listed(of_kind("sections.region"), 1),
    "_some_branches": lambda _: listed(of_kind("sections.branch")),
    "_some_events": lambda _: listed(of_kind("event")),
}
"""Checks of values by name (with the module where two share one) and the form of what they let through."""  # fmt: skip


def form_of(check: Callable[..., Any], units: Units) -> Form:
    """The form of what a check lets through.

    Raises:
        KeyError: the check is not known here.
    """
    name: str = check.__qualname__
    inside: Mapping[str, Any] = inspect.getclosurevars(check).nonlocals
    match name:
        case "optional.<locals>.<lambda>":
            return form_of(inside["check"], units)
        case "_bounded.<locals>.check":
            return quantity(units, **BOUNDS[inside["allowed"].split(", or")[0]])
        case "_numbers.<locals>.check":
            return listed(quantity(units, **BOUNDS[inside["allowed"]]))
        case "whole_number.<locals>.check":
            return {"type": "integer", "minimum": inside["low"], "maximum": inside["high"]}
        case "_whole_or_auto.<locals>.parse":
            return {"anyOf": [form_of(inside["check"], ()), {"const": "auto"}]}
        case "one_of.<locals>.check":
            return {"enum": list(inside["allowed"])}
        case "choose.<locals>.parse":
            return _named_or("section")
        case "_table.<locals>.parse":
            bounds = NOT_NEGATIVE if inside["check"].__name__ == "damping" else {}
            return _words(MOTIONS, units, **bounds)
    module = check.__module__.rpartition(".")[2]
    return (FORMS.get(f"{module}.{name}") or FORMS[name])(units)
