"""How the section goes along a rod: one section, pieces, a taper, or a function of the arc length."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Self, TypeAlias

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from viscorod.model.described import Described, RefusedError, show
from viscorod.model.section import MaterialSection, Section
from viscorod.model.shapes import Annulus, Circle, Ellipse, Rectangle, SquareTube
from viscorod.model.stiffness_section import StiffnessSection
from viscorod.model.values import Positive, choose, sequence

__all__ = ["AnySection", "Piece", "Piecewise", "SectionProfile", "Taper", "section_profile"]

AnySection: TypeAlias = MaterialSection | StiffnessSection

SECTIONS: dict[str, type[Described]] = {
    "circle": Circle,
    "annulus": Annulus,
    "rectangle": Rectangle,
    "ellipse": Ellipse,
    "square_tube": SquareTube,
    "given": Section,
    "stiffness": StiffnessSection,
}
"""The sections by their word in a case file; a new section is one class and one line here."""

one_section = choose("shape", SECTIONS)
SectionField = Annotated[AnySection, PlainValidator(one_section)]


class Piece(Described):
    """One section up to a station.

    Args:
        until: arc length where the piece ends, m.
        section: of the piece.
    """

    until: Positive = Field(description="arc length where the piece ends, m")
    section: SectionField = Field(description="of the piece")


def _pieces(value: Any) -> tuple[Piece, ...]:
    pieces = []
    for item in sequence(value):
        if isinstance(item, list | tuple) and len(item) == 2:
            pieces.append(Piece.model_validate({"until": item[0], "section": item[1]}))
        else:
            pieces.append(item if isinstance(item, Piece) else Piece.model_validate(item))
    if not pieces:
        raise RefusedError("at least one piece is needed", "give pieces with until and section")
    for before, after in pairwise(pieces):
        if after.until <= before.until:
            raise RefusedError(
                "each piece must end further along than the one before",
                f"give a number above {show(before.until)}",
                found=show(after.until),
                at=(pieces.index(after), "until"),
            )
    return tuple(pieces)


class Piecewise(Described):
    """Different sections one after the other.

    Args:
        pieces: pairs (until, section), in order; the last ends at the length of the rod.
    """

    pieces: Annotated[Sequence[Piece | tuple[float, AnySection]], PlainValidator(_pieces)]

    @property
    def parts(self) -> tuple[Piece, ...]:
        """The pieces."""
        return tuple(piece for piece in self.pieces if isinstance(piece, Piece))

    def at(self, s: float) -> AnySection:
        """The section at `s`; at a break, the one that starts there."""
        return next((piece.section for piece in self.parts if s < piece.until), self.parts[-1].section)


class Taper(Described):
    """A section whose every dimension changes linearly along the rod.

    Args:
        start: section at s = 0.
        end: section at the end, of the same shape.
    """

    start: SectionField = Field(description="section at the start")
    end: SectionField = Field(description="section at the end")

    @model_validator(mode="after")
    def _same_shape(self) -> Self:
        if type(self.start) is not type(self.end):
            raise RefusedError(
                "a taper joins two sections of the same shape",
                "give start and end the same shape",
                found=f"a {type(self.start).__name__} and a {type(self.end).__name__}",
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
        """The section at a fraction (0 to 1) of the length."""
        mixed: dict[str, Any] = {}
        for name in type(self.start).model_fields:
            first, last = getattr(self.start, name), getattr(self.end, name)
            if name == self.start.tag or first is None:
                mixed[name] = first
            else:
                mixed[name] = ((1.0 - fraction) * np.asarray(first) + fraction * np.asarray(last)).tolist()
        return type(self.start)(**mixed)


SectionProfile: TypeAlias = AnySection | Piecewise | Taper | Callable[[float], AnySection]


def section_profile(value: Any) -> SectionProfile:
    """`value` as a section, pieces, a taper or a function."""
    if isinstance(value, Piecewise | Taper):
        return value
    if callable(value) and not isinstance(value, Described | type):
        profile: SectionProfile = value
        return profile
    if not isinstance(value, Mapping | Described):
        raise RefusedError(
            "a section is needed here", f"give a table with shape = one of {', '.join(SECTIONS)}"
        )
    section = one_section(value)
    assert isinstance(section, MaterialSection | StiffnessSection)
    return section
