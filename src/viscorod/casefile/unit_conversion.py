"""Convert the quantities of a case file ("10 mm") to plain SI numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from viscorod.errors import Fault
from viscorod.model.fields.quantities import SIWalk, has_quantity
from viscorod.units import Conversion

__all__ = ["converted"]


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
