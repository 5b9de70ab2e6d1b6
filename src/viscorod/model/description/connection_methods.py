"""Methods of a model that add attachments, joints and springs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypedDict, Unpack

from viscorod.argument_names import known_arguments
from viscorod.given_as import Amount
from viscorod.model.connections.axis_joint import Cylindrical, Planar, Prismatic, Revolute
from viscorod.model.connections.joint import Ball, Rigid, Universal, joint
from viscorod.model.connections.joint_base import AnyJoint
from viscorod.model.connections.place import GROUND
from viscorod.model.connections.rigid_attachment import Attachment
from viscorod.model.connections.spring import AnySpring, LineSpring, Spring
from viscorod.model.connections.spring_laws import Law, Laws, Rest
from viscorod.model.description.given_places import placed
from viscorod.model.fields.arguments import Motion, Vector, given

__all__ = ["Joined"]


class Acting(TypedDict, total=False):
    """Springs, dampers and motors along the free motions of a joint, by motion word, and its name; see `AnyJoint`."""

    name: str | None
    stiffness: Laws | None
    damping: Laws | None
    rest: Rest | None
    motion: Motion | None


@known_arguments
class Joined:
    """Methods that add attachments, joints and springs; a part of `ModelDescription`."""

    attachments: list[Attachment]
    joints: list[AnyJoint]
    springs: list[AnySpring]

    def attach(self, a: str, b: str) -> None:
        """Join two coinciding places, or a place of a rod and a body, into one rigid node; see `Attachment`."""
        self.attachments.append(placed(self, Attachment(a, b)))

    def joint(self, kind: str, a: str, b: str, **fields: Any) -> None:
        """Join two places, or a place and the "ground", by a joint of any kind, with its fields by name."""
        made = joint({"kind": kind, "a": a, "b": b, **fields})
        assert isinstance(made, AnyJoint)
        self.joints.append(placed(self, made))

    def rigid(self, a: str, b: str, *, name: str | None = None) -> None:
        """Hold all relative motions; see `Rigid`."""
        self.joints.append(placed(self, Rigid(**given(a=a, b=b, name=name))))

    def ball(self, a: str, b: str, *, axes: Sequence[Vector] | None = None, **acting: Unpack[Acting]) -> None:
        """Allow rotation about any axis through a point; see `Ball`."""
        self.joints.append(placed(self, Ball(**given(a=a, b=b, axes=axes, **acting))))

    def revolute(self, a: str, b: str, axis: Vector, **acting: Unpack[Acting]) -> None:
        """Allow rotation about an axis; see `Revolute`."""
        self.joints.append(placed(self, Revolute(**given(a=a, b=b, axis=axis, **acting))))

    def universal(self, a: str, b: str, axes: Sequence[Vector], **acting: Unpack[Acting]) -> None:
        """Allow rotation about two perpendicular directions; see `Universal`."""
        self.joints.append(placed(self, Universal(**given(a=a, b=b, axes=axes, **acting))))

    def cylindrical(self, a: str, b: str, axis: Vector, **acting: Unpack[Acting]) -> None:
        """Allow rotation about an axis and sliding along it; see `Cylindrical`."""
        self.joints.append(placed(self, Cylindrical(**given(a=a, b=b, axis=axis, **acting))))

    def prismatic(self, a: str, b: str, axis: Vector, **acting: Unpack[Acting]) -> None:
        """Allow sliding along an axis; see `Prismatic`."""
        self.joints.append(placed(self, Prismatic(**given(a=a, b=b, axis=axis, **acting))))

    def planar(self, a: str, b: str, normal: Vector, **acting: Unpack[Acting]) -> None:
        """Allow sliding and rotation in a plane; see `Planar`."""
        self.joints.append(placed(self, Planar(**given(a=a, b=b, normal=normal, **acting))))

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
        """Pull a place towards another, or towards its reference position, along some motions; see `Spring`."""
        laws = {"stiffness": stiffness, "damping": damping, "rest": rest}
        self.springs.append(placed(self, Spring(**given(at=at, to=to, axes=axes, name=name, **laws))))

    def line_spring(
        self,
        at: str,
        to: str | Vector,
        stiffness: Law = 0.0,
        damping: Law = 0.0,
        length: Amount | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Join a place to another, or to a fixed point, by a spring along the line between; see `LineSpring`."""
        laws = {"stiffness": stiffness, "damping": damping, "length": length}
        self.springs.append(placed(self, LineSpring(**given(at=at, to=to, name=name, **laws))))
