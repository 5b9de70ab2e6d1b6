"""Convert the quantities of a case file ("10 mm") to plain SI numbers."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from viscorod.errors import Fault
from viscorod.model.fields.quantities import SIWalk, has_quantity
from viscorod.units import Conversion

__all__ = ["converted", "unit_at"]


def converted(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], list[Conversion], list[Fault]]:
    """Return the content in SI, what was converted, and what is wrong with quantities.

    A quantity that is refused becomes a mark, so that it is reported once. Texts stay where texts are meant, and
    where no key is known.
    """
    if not has_quantity(data):
        return data, [], []
    from viscorod.casefile.json_schema import forms

    schema = forms()
    walk = SIWalk(schema["definitions"], reported=True)
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


class _UnitWalk(SIWalk):
    """A walk that notes the unit of what stands at one key."""

    def __init__(self, definitions: Mapping[str, Any], wanted: tuple[str | int, ...]) -> None:
        super().__init__(definitions, reported=True)
        self.wanted, self.unit = wanted, ""

    def number(self, given: Any, unit: str, path: tuple[str | int, ...]) -> Any:
        """Note the unit if this is the key."""
        if path == self.wanted:
            self.unit = unit
        return given
