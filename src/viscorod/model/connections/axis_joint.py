"""Joints along or about one axis, or in one plane."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from viscorod.model.connections.joint_base import AnyJoint
from viscorod.model.fields.directions import axes_from
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Direction
from viscorod.typing import Floats

__all__ = ["Cylindrical", "Planar", "Prismatic", "Revolute"]


class _AlongAxis(AnyJoint):
    axis: Direction = Key("z of the joint, global components in the reference shape")

    def frame(self) -> Floats:
        """Return axes with the axis as z."""
        return axes_from(self.axis)[:, [1, 2, 0]]


class Revolute(_AlongAxis):
    """A hinge: allows rotation about an axis of b."""

    kind: Literal["revolute"] = Field(default="revolute", kw_only=True, repr=False)

    def free_motions(self) -> tuple[str, ...]:
        """Return the rotation about the axis."""
        return ("rz",)


class Cylindrical(_AlongAxis):
    """Allows rotation about an axis of b and sliding along it."""

    kind: Literal["cylindrical"] = Field(default="cylindrical", kw_only=True, repr=False)

    def free_motions(self) -> tuple[str, ...]:
        """Return the displacement along and the rotation about the axis."""
        return ("uz", "rz")


class Prismatic(_AlongAxis):
    """Allows sliding along an axis of b."""

    kind: Literal["prismatic"] = Field(default="prismatic", kw_only=True, repr=False)

    def free_motions(self) -> tuple[str, ...]:
        """Return the displacement along the axis."""
        return ("uz",)


class Planar(AnyJoint):
    """Allows sliding and rotation in a plane of b."""

    kind: Literal["planar"] = Field(default="planar", kw_only=True, repr=False)
    normal: Direction = Key("of the plane, z of the joint, global components in the reference shape")

    def free_motions(self) -> tuple[str, ...]:
        """Return the displacements in the plane and the rotation about its normal."""
        return ("ux", "uy", "rz")

    def frame(self) -> Floats:
        """Return axes with the normal as z."""
        return axes_from(self.normal)[:, [1, 2, 0]]
