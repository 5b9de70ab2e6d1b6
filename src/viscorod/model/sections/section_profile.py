"""Variation of the section along a rod: one section, pieces, a taper, or a function of the arc length."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Self, TypeAlias

import numpy as np
from pydantic import BeforeValidator, model_validator

from viscorod.model.fields.definition import Definition, RefusedError, base_init, show
from viscorod.model.fields.forms import named_or
from viscorod.model.fields.metadata import Accepts, Key, accepts
from viscorod.model.fields.values import Positive, choose, sequence
from viscorod.model.sections.composite import Composite
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.section_base import SECTION, AnySection
from viscorod.model.sections.section_shapes import SHAPES
from viscorod.model.sections.stiffness_section import StiffnessSection

__all__ = ["AnySection", "Piece", "Piecewise", "SectionProfile", "Taper", "section_profile"]

SECTIONS: Mapping[str, type[AnySection]] = ChainMap(
    {
        "outline": PolygonSection,
        "composite": Composite,
        "given": SectionProperties,
        "stiffness": StiffnessSection,
    },
    SHAPES,
)
"""The sections by their word in a case file: the SHAPES, and those that are not made of one known outline."""

one_section = choose("shape", SECTIONS, form=named_or("section"), words=SECTION)
SectionField = Annotated[AnySection, one_section]


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


class Taper(Definition):
    """A section whose every dimension changes linearly along the rod."""

    start: SectionField = Key("section at s = 0")
    end: SectionField = Key("section at the end, of the same shape")

    @model_validator(mode="after")
    def _same_shape(self) -> Self:
        if type(self.start) is not type(self.end):
            raise RefusedError(
                "a taper joins two sections of the same shape",
                "give start and end the same shape",
                found=f"{type(self.start).__name__} and {type(self.end).__name__}",
            )
        if not self.start.can_taper:
            raise RefusedError(
                "such a section would need a mesh of its own at every station",
                "give pieces, each with its section",
                found=type(self.start).__name__,
                at=("start",),
            )
        for name in type(self.start).model_fields:
            if (getattr(self.start, name) is None) != (getattr(self.end, name) is None):
                raise RefusedError(
                    f"{name} is given at one end only",
                    f"give {name} at both ends or at none",
                    found="",
                    at=(name,),
                )
        return self

    def at(self, fraction: float) -> AnySection:
        """Return the section at a fraction (0 to 1) of the length."""
        mixed: dict[str, Any] = {}
        for name in type(self.start).model_fields:
            first, last = getattr(self.start, name), getattr(self.end, name)
            if name == self.start.tag or first is None:
                mixed[name] = first
            else:
                mixed[name] = ((1.0 - fraction) * np.asarray(first) + fraction * np.asarray(last)).tolist()
        return type(self.start)(**mixed)


SectionProfile: TypeAlias = AnySection | Piecewise | Taper | Callable[[float], AnySection]


@accepts(None, SECTION, "or a function of the arc length")
def section_profile(value: Any) -> SectionProfile:
    """Return `value` as a section, pieces, a taper or a function."""
    if isinstance(value, Piecewise | Taper):
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
