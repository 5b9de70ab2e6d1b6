"""The part of a model that attachments, joints and springs make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from viscorod.model.any_joint import AnyJoint
from viscorod.model.attachment import Attachment
from viscorod.model.axis_joint import Cylindrical, Planar, Prismatic, Revolute
from viscorod.model.given import Motion, Vector, given
from viscorod.model.joint import Ball, Rigid, Universal, joint
from viscorod.model.laws import Law, Laws, Rest
from viscorod.model.place import GROUND
from viscorod.model.spring import AnySpring, LineSpring, Spring

__all__ = ["Joined"]


class Joined:
    """Methods that add attachments, joints and springs; a part of `ModelDescription`."""

    attachments: list[Attachment]
    joints: list[AnyJoint]
    springs: list[AnySpring]

    def attach(self, a: str, b: str) -> None:
        """Join two coinciding places, or a place of a rod and a body, into one rigid node; see `Attachment`."""
        self.attachments.append(Attachment(a, b))

    def joint(self, kind: str, a: str, b: str, **fields: Any) -> None:
        """Join two places, or a place and the "ground", by a joint of any kind, with its fields by name."""
        made = joint({"kind": kind, "a": a, "b": b, **fields})
        assert isinstance(made, AnyJoint)
        self.joints.append(made)

    def rigid(self, a: str, b: str, *, name: str | None = None) -> None:
        """Hold all relative motions; see `Rigid`."""
        self.joints.append(Rigid(**given(a=a, b=b, name=name)))

    def ball(
        self,
        a: str,
        b: str,
        *,
        axes: Sequence[Vector] | None = None,
        name: str | None = None,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Let a turn in every direction about a point; see `Ball`."""
        fields = given(a=a, b=b, axes=axes, name=name)
        self.joints.append(
            Ball(**fields, **given(stiffness=stiffness, damping=damping, rest=rest, motion=motion))
        )

    def revolute(
        self,
        a: str,
        b: str,
        axis: Vector,
        *,
        name: str | None = None,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Let a turn about an axis; see `Revolute`."""
        fields = given(a=a, b=b, axis=axis, name=name)
        self.joints.append(
            Revolute(**fields, **given(stiffness=stiffness, damping=damping, rest=rest, motion=motion))
        )

    def universal(
        self,
        a: str,
        b: str,
        axes: Sequence[Vector],
        *,
        name: str | None = None,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Let a turn about two perpendicular directions; see `Universal`."""
        fields = given(a=a, b=b, axes=axes, name=name)
        self.joints.append(
            Universal(**fields, **given(stiffness=stiffness, damping=damping, rest=rest, motion=motion))
        )

    def cylindrical(
        self,
        a: str,
        b: str,
        axis: Vector,
        *,
        name: str | None = None,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Let a turn about and slide along an axis; see `Cylindrical`."""
        fields = given(a=a, b=b, axis=axis, name=name)
        self.joints.append(
            Cylindrical(**fields, **given(stiffness=stiffness, damping=damping, rest=rest, motion=motion))
        )

    def prismatic(
        self,
        a: str,
        b: str,
        axis: Vector,
        *,
        name: str | None = None,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Let a slide along an axis; see `Prismatic`."""
        fields = given(a=a, b=b, axis=axis, name=name)
        self.joints.append(
            Prismatic(**fields, **given(stiffness=stiffness, damping=damping, rest=rest, motion=motion))
        )

    def planar(
        self,
        a: str,
        b: str,
        normal: Vector,
        *,
        name: str | None = None,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Let a slide and turn in a plane; see `Planar`."""
        fields = given(a=a, b=b, normal=normal, name=name)
        self.joints.append(
            Planar(**fields, **given(stiffness=stiffness, damping=damping, rest=rest, motion=motion))
        )

    def spring(
        self,
        at: str,
        to: str = GROUND,
        stiffness: Laws | None = None,
        damping: Laws | None = None,
        rest: Rest | None = None,
        axes: Sequence[Vector] | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Pull a place towards another, or towards where it was, along some motions; see `Spring`."""
        laws = given(stiffness=stiffness, damping=damping, rest=rest)
        self.springs.append(Spring(**given(at=at, to=to, axes=axes, name=name), **laws))

    def line_spring(
        self,
        at: str,
        to: str | Vector,
        stiffness: Law = 0.0,
        damping: Law = 0.0,
        length: float | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Join a place to another, or to a fixed point, by a spring along the line between; see `LineSpring`."""
        laws = given(stiffness=stiffness, damping=damping, length=length)
        self.springs.append(LineSpring(**given(at=at, to=to, name=name), **laws))
