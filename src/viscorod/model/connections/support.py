"""Supports, which fix or prescribe motions of a place along given axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.given_as import Amounts, GivenAs, Words
from viscorod.model.connections.motion_words import (
    MOTIONS,
    fixed_motions,
)
from viscorod.model.connections.support_base import AnySupport, Frame, MotionField
from viscorod.model.connections.velocity_support import VelocitySupport
from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.directions import axes_from, columns, two_directions
from viscorod.model.fields.metadata import Key, optional
from viscorod.model.fields.values import (
    Direction,
    OptionalDirection,
    Triple,
    choose,
    one_of,
)
from viscorod.typing import Floats

__all__ = ["SUPPORTS", "Clamp", "Guide", "Pin", "Roller", "Support", "support"]


class Support(AnySupport):
    """Any subset of the six motions."""

    kind: Literal["support"] = Field(default="support", kw_only=True, repr=False)
    fixed: Annotated[GivenAs[tuple[str, ...], Words], fixed_motions] = Key(
        "motion words that stay zero", default=()
    )
    motion: MotionField = Key(
        "motion words with functions of time ({} or {}). Rotations may be of any size; free ones are measured from "
        "where the prescribed ones alone would turn the place",
        "m",
        "rad",
        default={},
        kw_only=True,
    )
    frame: Annotated[Literal["global", "node"], one_of("global", "node")] = Key(
        '"global" axes, or "node": the rod\'s d1, d2, d3 at the place', default="global"
    )
    axes: Annotated[
        GivenAs[tuple[Triple, Triple] | None, Sequence[Amounts] | None], optional(two_directions)
    ] = Key(
        "other axes for the motion words: directions x and y, perpendicular, global components (z = x cross y)",
        default=None,
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.axes is not None and self.frame == "node":
            raise RefusedError(
                "a support has either the node's axes or its own",
                "leave frame or axes out",
                found="",
                at=("axes",),
            )
        both = [word for word in self.fixed if word in self.motion]
        if both:
            raise RefusedError(
                "a motion cannot be both fixed and prescribed",
                f"leave {both[0]} out of fixed or out of motion",
                found=f"{both[0]} in both",
                at=("motion", both[0]),
            )
        if not self.held():
            raise RefusedError(
                "this support holds nothing",
                f"give fixed, a list of some of {', '.join(MOTIONS)}",
                found="",
                at=("fixed",),
            )
        return self

    def held(self) -> tuple[str, ...]:
        """Return the motion words in `fixed` and in `motion`."""
        return tuple(word for word in MOTIONS if word in self.fixed or word in self.motion)

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """Return the global axes, the node's or the given ones."""
        if self.frame == "node":
            return "node", node
        if self.axes is None:
            return "global", np.eye(3)
        return "axes", columns(self.axes)


class Clamp(AnySupport):
    """Holds all six motions in the global axes."""

    kind: Literal["clamp"] = Field(default="clamp", kw_only=True, repr=False)

    def held(self) -> tuple[str, ...]:
        """Return all six motion words."""
        return MOTIONS


class Pin(AnySupport):
    """Holds the three displacements in the global axes; rotation is free."""

    kind: Literal["pin"] = Field(default="pin", kw_only=True, repr=False)

    def held(self) -> tuple[str, ...]:
        """Return the displacements."""
        return MOTIONS[:3]


class Guide(AnySupport):
    """Allows sliding along a fixed direction, x of the support's axes, and holds all other motions."""

    kind: Literal["guide"] = Field(default="guide", kw_only=True, repr=False)
    along: OptionalDirection = Key(
        "the direction, global axes; by default the rod's tangent there in the reference shape", default=None
    )

    def held(self) -> tuple[str, ...]:
        """Return all motion words but ux."""
        return MOTIONS[1:]

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """Return axes with the direction of sliding first."""
        return "axes", node[:, [2, 0, 1]] if self.along is None else axes_from(self.along)


class Roller(AnySupport):
    """Holds the displacement along one direction, x of the support's axes; all else is free."""

    kind: Literal["roller"] = Field(default="roller", kw_only=True, repr=False)
    normal: Direction = Key("the direction, global axes")

    def held(self) -> tuple[str, ...]:
        """Return the displacement along the normal."""
        return MOTIONS[:1]

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """Return axes with the normal first."""
        del node
        return "axes", axes_from(self.normal)


SUPPORTS: dict[str, type[Definition]] = {
    "support": Support,
    "clamp": Clamp,
    "pin": Pin,
    "guide": Guide,
    "roller": Roller,
    "body_velocity": VelocitySupport,
}
"""The supports by their word in a case file; a new one is one class and one line here."""

support = choose("kind", SUPPORTS, default="support")
"""A support from a table or as it is."""
