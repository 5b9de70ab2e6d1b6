"""The laws of sections by their word in a case file."""

from __future__ import annotations

from typing import Any, cast

from viscorod.model.fields.definition import Definition
from viscorod.model.fields.forms import of_kind
from viscorod.model.fields.metadata import accepts
from viscorod.model.fields.values import choose
from viscorod.model.sections.cubic_bending import CubicBending
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.model.sections.trapeze_effect import TrapezeEffect

__all__ = ["SECTION_LAWS", "section_law"]

SECTION_LAWS: dict[str, type[Definition]] = {
    "cubic_bending": CubicBending,
    "trapeze_effect": TrapezeEffect,
}
"""A new law is one class and one line here."""

_one_law = choose("kind", SECTION_LAWS)


@accepts(of_kind("law"), "table with the `kind` of a law, see below")
def section_law(value: Any) -> AnySectionLaw | None:
    """Return `value` as a law of a section."""
    return None if value is None else cast(AnySectionLaw, _one_law(value))
