"""Stages of an equilibrium, as a user gives them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator

from viscorod.given_as import Amount, GivenAs
from viscorod.model.fields.definition import Definition, RefusedError, at_key
from viscorod.model.fields.forms import TEXT, listed, of_kind
from viscorod.model.fields.metadata import TABLES, Accepts, Key, accepts
from viscorod.model.fields.values import each, items, number, word

__all__ = ["Stage", "Stages"]


Parts: TypeAlias = Sequence[str] | Mapping[str, Amount]


@accepts(
    {"anyOf": [listed(TEXT), {"type": "object", "additionalProperties": {"type": "number"}}]},
    "list of names, or table of factors by name",
)
def _parts(value: Any) -> Mapping[str, float]:
    if not isinstance(value, Mapping):
        return dict.fromkeys(each(value, word), 1.0)
    found = {}
    for name, part in value.items():
        with at_key(str(name), part):
            found[str(name)] = number(part)
    if not all(isinstance(name, str) for name in value):
        raise RefusedError("names are texts", 'give them in quotes, such as { "gravity" = 0.5 }')
    return found


class Stage(Definition):
    """One stage of an equilibrium: what grows in it, from the end of the stage before.

    What it does not name stays as it is. A stage that names nothing takes all that no stage names.
    """

    loads: Annotated[GivenAs[Mapping[str, float], Parts], _parts] = Key(
        "loads that grow to their whole, or to a part of it (0 takes them away), by their `name` or kind, such as "
        '"gravity"; `rest_strains` are one of them',
        default={},
    )
    motions: Annotated[GivenAs[Mapping[str, float], Parts], _parts] = Key(
        'the same of prescribed motions: by place and motion word, such as "string.end.rx", by place alone, or by the '
        "name of a driven joint",
        default={},
    )


Stages = Annotated[
    GivenAs[tuple[Stage, ...], Sequence[Stage | Mapping[str, Any]]],
    BeforeValidator(items),
    Accepts(listed(of_kind("equilibrium.stage")), TABLES),
]
"""A list of stages, or of tables that describe them."""
