"""Variation of the section along a rod: one section, pieces, a taper, stations, or a function of the arc length."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Self, TypeAlias

from pydantic import BeforeValidator, model_validator

from viscorod.model.fields.definition import Definition, RefusedError, base_init, show
from viscorod.model.fields.metadata import Accepts, Key, accepts
from viscorod.model.fields.values import Positive, sequence
from viscorod.model.sections.section_base import SECTION, AnySection
from viscorod.model.sections.section_kinds import SECTIONS, SectionField, one_section
from viscorod.model.sections.section_stations import Stations
from viscorod.model.sections.taper import Taper

__all__ = ["AnySection", "Piece", "Piecewise", "SectionProfile", "one_of_sections", "section_profile"]


class Piece(Definition):
    """One section up to a station."""

    until: Positive = Key("arc length where the piece ends", "m")
    section: SectionField = Key("of the piece")


def _as_pieces(value: Any) -> list[Any]:
    """Turn pairs (until, section) into tables."""
    items = sequence(value)
    if not items:
        raise RefusedError("at least one piece is needed", "give pieces with until and section")
    pairs = (isinstance(item, list | tuple) and len(item) == 2 for item in items)
    return [
        {"until": item[0], "section": item[1]} if pair else item
        for item, pair in zip(items, pairs, strict=True)
    ]


class Piecewise(Definition):
    """Different sections one after the other."""

    pieces: Annotated[tuple[Piece, ...], BeforeValidator(_as_pieces), Accepts(None)] = Key(
        "pairs (until, section), in order; the last ends at the length of the rod"
    )

    @base_init
    def __init__(self, pieces: Sequence[Piece | tuple[float, AnySection]]) -> None:
        given: dict[str, Any] = {"pieces": pieces}
        super().__init__(**given)

    @model_validator(mode="after")
    def _forward(self) -> Self:
        for index, (before, after) in enumerate(pairwise(self.pieces)):
            if after.until <= before.until:
                raise RefusedError(
                    "each piece must end further along than the one before",
                    f"give a number above {show(before.until)}",
                    found=show(after.until),
                    at=("pieces", index + 1, "until"),
                )
        return self

    def at(self, s: float) -> AnySection:
        """Return the section at `s`; at a break, the one that starts there."""
        return next((piece.section for piece in self.pieces if s < piece.until), self.pieces[-1].section)


SectionProfile: TypeAlias = AnySection | Piecewise | Taper | Stations | Callable[[float], AnySection]


def one_of_sections(value: Any) -> AnySection:
    """Return `value`, which must be a section."""
    if not isinstance(value, AnySection):
        raise RefusedError("this is no section", "give one, such as Rectangle(0.02, 0.01)")
    return value


@accepts(None, SECTION, "or a function of the arc length")
def section_profile(value: Any) -> SectionProfile:
    """Return `value` as a section, pieces, a taper, stations or a function."""
    if isinstance(value, Piecewise | Taper | Stations):
        return value
    if callable(value) and not isinstance(value, Definition | type):
        profile: SectionProfile = value
        return profile
    if not isinstance(value, Mapping | Definition):
        raise RefusedError(
            "a section is needed here", f"give a table with shape = one of {', '.join(SECTIONS)}"
        )
    section = one_section(value)
    assert isinstance(section, AnySection)
    return section
