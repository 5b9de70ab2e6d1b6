"""Springs and dampers between two places, or between a place and the ground."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.connections.joint_base import require_two_ends
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import GROUND, AnyPlace, EndField, PlaceField, end_text
from viscorod.model.connections.spring_laws import (
    Damping,
    DampingTable,
    Law,
    Laws,
    Rest,
    RestTable,
    Stiffness,
    StiffnessTable,
    named_law,
    named_laws,
    require_law_words,
)
from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.directions import OptionalAxes, columns
from viscorod.model.fields.forms import TEXT
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import TRIPLE, OptionalName, OptionalPositive, Triple, choose, vector
from viscorod.typing import Floats

__all__ = ["SPRINGS", "AnySpring", "LineSpring", "ResolvedSpring", "Spring", "spring"]

Anchor: TypeAlias = str | Triple
Places: TypeAlias = tuple[AnyPlace, AnyPlace | None]


@dataclass(frozen=True, eq=False)
class ResolvedSpring:
    """A spring as the analysis needs it.

    Attributes:
        path: key path, ``springs[0]``.
        kind: "bushing" or "line".
        label: name of the spring.
        a, b: the places `at` and `to`; None for the ground.
        at_a, at_b: position of the spring on each side in the reference shape (3,), m, global.
        frame: axes (3, 3), columns, global, in the reference shape, carried by `b`; the unit matrix for a line.
        stiffness, damping, rest: of a bushing: by motion words (of `a` relative to `b`, from the reference shape). Of a
            line: under "ux", the force along the line by its elongation (m) from `length`, and by its rate (m/s).
        length: rest length of a line, m; 0 for a bushing.
    """

    path: str
    kind: str
    label: str
    a: AnyPlace
    b: AnyPlace | None
    at_a: Floats
    at_b: Floats
    frame: Floats
    stiffness: Laws
    damping: Laws
    rest: Rest
    length: float


class AnySpring(Definition):
    """Base class of springs."""

    tag: ClassVar[str | None] = "kind"

    at: PlaceField = Key("place")
    name: OptionalName = Key("of the spring", default=None, kw_only=True)

    @property
    def word(self) -> str:
        """The kind's word in a case file."""
        return str(type(self).model_fields["kind"].default)

    @property
    @abstractmethod
    def ends(self) -> tuple[str, str]:
        """The place and the other one, or "ground"."""

    @property
    def label(self) -> str:
        """The name, by default ``bushing beam.end - ground``."""
        return self.name or f"{self.word} {' - '.join(self.ends)}"

    @abstractmethod
    def resolve(self, path: str, places: Places, positions: tuple[Floats, Floats]) -> ResolvedSpring:
        """Return the spring with its places, those of `ends`, and its position on each side (3,)."""


class Spring(AnySpring):
    """Springs and dampers along the motions of a place relative to another, or to the ground: a bushing."""

    kind: Literal["bushing"] = Field(default="bushing", kw_only=True, repr=False)
    to: EndField = Key('place, or "ground"', default=GROUND)
    stiffness: StiffnessTable = Key("motion words with numbers ({}, {})", "N/m", "N m/rad", default={})
    damping: DampingTable = Key("motion words with numbers ({}, {})", "N s/m", "N m s/rad", default={})
    rest: RestTable = Key(
        "motion words with the coordinates at which the stiffness does not pull ({}, {})",
        "m",
        "rad",
        default={},
    )
    axes: OptionalAxes = Key(
        "of the motions, carried by the other place: directions x and y, perpendicular, global "
        "components in the reference shape; by default the global axes",
        default=None,
    )

    @property
    def ends(self) -> tuple[str, str]:
        """The place and the other one, or "ground"."""
        return self.at, self.to

    def resolve(self, path: str, places: Places, positions: tuple[Floats, Floats]) -> ResolvedSpring:
        """See `AnySpring`."""
        (a, b), (at_a, at_b) = places, positions
        stiffness = named_laws(self.stiffness, "stiffness", self.label)
        damping = named_laws(self.damping, "damping", self.label)
        return ResolvedSpring(
            path,
            self.word,
            self.label,
            a,
            b,
            at_a,
            at_b,
            self.frame(),
            stiffness,
            damping,
            dict(self.rest),
            0.0,
        )

    def frame(self) -> Floats:
        """Return the axes in the reference shape (3, 3), columns, global components."""
        return columns(self.axes)

    @model_validator(mode="after")
    def _acts(self) -> Self:
        require_two_ends(("at", self.at), ("to", self.to), "spring")
        require_law_words(self.stiffness, self.damping, self.rest, MOTIONS, "", "")
        if not self.stiffness and not self.damping:
            raise RefusedError(
                "this spring does nothing",
                f"give stiffness or damping, tables with some of {', '.join(MOTIONS)}",
                found="",
                at=("stiffness",),
            )
        return self


@accepts({"anyOf": [TEXT, TRIPLE]}, "place, in quotes, or 3 numbers")
def _anchor(value: Any) -> Anchor:
    if isinstance(value, str):
        if value == GROUND:
            raise RefusedError(
                "a spring along a line needs a point at its other end",
                "give a place, or three numbers: a point fixed in space",
            )
        return end_text(value)
    if isinstance(value, Sequence | np.ndarray):
        return vector(value)
    raise RefusedError("neither a place nor a point", "give a place in quotes, or three numbers")


class LineSpring(AnySpring):
    """A spring and damper along the straight line between two places, or between a place and a fixed point."""

    kind: Literal["line"] = Field(default="line", kw_only=True, repr=False)
    to: Annotated[Anchor, _anchor] = Key("place, or the position of a point fixed in space", "m")
    stiffness: Stiffness = Key("", "N/m", default=0.0)
    damping: Damping = Key("", "N s/m", default=0.0)
    length: OptionalPositive = Key(
        "without force, {}; by default that of the reference shape", "m", default=None
    )

    @property
    def ends(self) -> tuple[str, str]:
        """The place and the other one, or "ground" for a fixed point."""
        return self.at, self.to if isinstance(self.to, str) else GROUND

    def resolve(self, path: str, places: Places, positions: tuple[Floats, Floats]) -> ResolvedSpring:
        """See `AnySpring`."""
        (a, b), (at_a, at_b) = places, positions
        length = self.length or float(np.linalg.norm(at_a - at_b))
        stiffness = _along_line(named_law(self.stiffness, f"the stiffness of {self.label}"))
        damping = _along_line(named_law(self.damping, f"the damping of {self.label}"))
        return ResolvedSpring(
            path, self.word, self.label, a, b, at_a, at_b, np.eye(3), stiffness, damping, {}, length
        )

    @model_validator(mode="after")
    def _acts(self) -> Self:
        if isinstance(self.to, str):
            require_two_ends(("at", self.at), ("to", self.to), "spring")
        if _is_zero(self.stiffness) and _is_zero(self.damping):
            raise RefusedError(
                "this spring does nothing",
                "give stiffness (N/m) or damping (N s/m)",
                found="",
                at=("stiffness",),
            )
        return self


SPRINGS: dict[str, type[Definition]] = {"bushing": Spring, "line": LineSpring}
"""The springs by their word in a case file; a new one is one class and one line here."""

spring = choose("kind", SPRINGS, default="bushing")
"""A spring from a table or as it is."""


def _is_zero(law: Law) -> bool:
    return not callable(law) and law == 0.0


def _along_line(law: Law) -> Laws:
    return {} if _is_zero(law) else {MOTIONS[0]: law}
