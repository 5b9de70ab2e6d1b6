"""Joints, which hold, free, spring or drive the motions of a place relative to another, or to the ground."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from viscorod.given_as import GivenAs, Words
from viscorod.model.connections.axis_joint import Cylindrical, Planar, Prismatic, Revolute
from viscorod.model.connections.joint_base import AnyJoint
from viscorod.model.connections.motion_words import MOTIONS, fixed_motions
from viscorod.model.connections.place import GROUND
from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.directions import OptionalAxes, TwoDirections, columns
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import choose
from viscorod.typing import Floats

__all__ = [
    "JOINTS",
    "Ball",
    "Cylindrical",
    "Joint",
    "Planar",
    "Prismatic",
    "Revolute",
    "Rigid",
    "Universal",
    "joint",
]


class Rigid(AnyJoint):
    """Holds all relative motions."""

    unused: ClassVar[tuple[str, ...]] = ("stiffness", "damping", "rest", "motion")
    kind: Literal["rigid"] = Field(default="rigid", kw_only=True, repr=False)

    def free_motions(self) -> tuple[str, ...]:
        """Return no motion words."""
        return ()


class Ball(AnyJoint):
    """Allows rotation about any axis through a point of b."""

    kind: Literal["ball"] = Field(default="ball", kw_only=True, repr=False)
    axes: OptionalAxes = Key(
        "of the joint, carried by b: directions x and y, perpendicular, global components in the "
        "reference shape; by default the global axes",
        default=None,
        kw_only=True,
    )

    def free_motions(self) -> tuple[str, ...]:
        """Return the rotations."""
        return MOTIONS[3:]

    def frame(self) -> Floats:
        """Return the given axes."""
        return columns(self.axes)


class Universal(AnyJoint):
    """A cardan joint: allows rotation about two perpendicular directions, x and y of the joint."""

    kind: Literal["universal"] = Field(default="universal", kw_only=True, repr=False)
    axes: TwoDirections = Key(
        "two perpendicular directions, global components in the reference shape; the first, x, is "
        "carried by a, the second, y, by b"
    )

    def free_motions(self) -> tuple[str, ...]:
        """Return the rotations about the two directions."""
        return ("rx", "ry")

    def frame(self) -> Floats:
        """Return axes with the two directions as x and y."""
        return columns(self.axes)

    @model_validator(mode="after")
    def _ground_last(self) -> Self:
        if self.a == GROUND:
            raise RefusedError(
                "the first direction of a universal joint is carried by a, which moves",
                "give the part as a, the ground as b, and the direction that stands still second",
                found=f"{GROUND!r}",
                at=("a",),
            )
        return self


class Joint(AnyJoint):
    """Leaves any of the six relative motions free."""

    kind: Literal["general"] = Field(default="general", kw_only=True, repr=False)
    free: Annotated[GivenAs[tuple[str, ...], Words], fixed_motions] = Key(
        "motion words that are free", kw_only=True
    )
    axes: OptionalAxes = Key(
        "of the joint, carried by b: directions x and y, perpendicular, global components in the "
        "reference shape; by default the global axes",
        default=None,
        kw_only=True,
    )

    def free_motions(self) -> tuple[str, ...]:
        """Return the given motion words."""
        return self.free

    def frame(self) -> Floats:
        """Return the given axes."""
        return columns(self.axes)

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        if len(self.free) == len(MOTIONS):
            raise RefusedError(
                "this joint holds nothing",
                "leave out the motions that it holds, or use a spring",
                found="all six motions",
                at=("free",),
            )
        return self


JOINTS: dict[str, type[Definition]] = {
    "general": Joint,
    "rigid": Rigid,
    "ball": Ball,
    "revolute": Revolute,
    "universal": Universal,
    "cylindrical": Cylindrical,
    "prismatic": Prismatic,
    "planar": Planar,
}
"""The joints by their word in a case file; a new one is one class and one line here."""

joint = choose("kind", JOINTS)
"""A joint from a table or as it is."""
