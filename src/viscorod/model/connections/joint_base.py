"""Base class of joints."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.connections.motion_words import MOTIONS, named_motions
from viscorod.model.connections.place import GROUND, AnyPlace, EndField
from viscorod.model.connections.spring_laws import (
    DampingTable,
    Laws,
    Rest,
    RestTable,
    StiffnessTable,
    named_laws,
    require_law_words,
)
from viscorod.model.connections.support_base import MotionField
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import OptionalName
from viscorod.typing import Floats

__all__ = ["AnyJoint", "Ends", "ResolvedJoint", "require_two_ends"]

Ends: TypeAlias = tuple[str, str]


@dataclass(frozen=True, eq=False)
class ResolvedJoint:
    """A joint as the analysis needs it.

    The motions are those of `a` relative to `b` from the reference shape, along the joint's axes: displacements in m,
    rotations in rad. Where one side is the ground, it is `b`.

    Attributes:
        path: key path, ``joints[0]``.
        kind: word of the kind, ``revolute``.
        label: name of the joint.
        a, b: the places; None for the ground, which `a` never is.
        at_a, at_b: position of the joint on each side in the reference shape (3,), m, global. On a body without a
            named point, and on the ground, it is the position of the other side.
        frame: x, y, z of the joint (3, 3), columns, global, in the reference shape.
        free: motion words that are free, or driven by `motion`, in the order of `MOTIONS`.
        held: the other ones.
        stiffness, damping: of free motions: numbers (N/m, N m/rad; N s/m, N m s/rad), or functions of the coordinate
            less its rest or of the rate that return the resisting force (N) or moment (N m).
        rest: coordinates at which the stiffness does not pull, m or rad; 0 where not given.
        motion: free motions that follow a function of time (m or rad).
    """

    path: str
    kind: str
    label: str
    a: AnyPlace
    b: AnyPlace | None
    at_a: Floats
    at_b: Floats
    frame: Floats
    free: tuple[str, ...]
    held: tuple[str, ...]
    stiffness: Laws
    damping: Laws
    rest: Rest
    motion: dict[str, TimeFunction]

    @property
    def gap(self) -> Floats:
        """Distance from `at_b` to `at_a` along x, y, z of the joint (3,), m; zero along free displacements."""
        along = self.frame.T @ (self.at_a - self.at_b)
        return np.where([word in self.held for word in MOTIONS[:3]], along, 0.0)


def require_two_ends(first: tuple[str, str], second: tuple[str, str], noun: str) -> None:
    """Refuse two sides, each a key and its value, that are the same or both the ground."""
    if first[1] == second[1]:
        ground = first[1] == GROUND
        raise RefusedError(
            f"a {noun} has the ground on one side only" if ground else f"a {noun} joins two different things",
            f"give a place of the model for {first[0]}"
            if ground
            else f'give two places, or "{GROUND}" for one',
            found=show(second[1]),
            at=(second[0],),
        )


class AnyJoint(Definition):
    """Base class of joints: two sides, and springs, dampers and motors along the motions that they leave free."""

    tag: ClassVar[str | None] = "kind"

    a: EndField = Key("place")
    b: EndField = Key('place, or "ground"')
    name: OptionalName = Key("of the joint", default=None, kw_only=True)
    stiffness: StiffnessTable = Key(
        "free motion words with numbers ({}, {})", "N/m", "N m/rad", default={}, kw_only=True
    )
    damping: DampingTable = Key(
        "free motion words with numbers ({}, {})", "N s/m", "N m s/rad", default={}, kw_only=True
    )
    rest: RestTable = Key(
        "motion words with the coordinates at which the stiffness does not pull ({}, {})",
        "m",
        "rad",
        default={},
        kw_only=True,
    )
    motion: MotionField = Key(
        "free motion words that follow functions of time ({} or {}): a motor",
        "m",
        "rad",
        default={},
        kw_only=True,
    )

    @property
    def word(self) -> str:
        """The kind's word in a case file."""
        return str(type(self).model_fields["kind"].default)

    @property
    def label(self) -> str:
        """The name, by default ``revolute arm.end - leg.start``."""
        return self.name or f"{self.word} {self.a} - {self.b}"

    @property
    def ends(self) -> Ends:
        """The places whose relative motion is measured, the moving one first: a and b, but the ground always last."""
        return (self.b, self.a) if self.a == GROUND else (self.a, self.b)

    @abstractmethod
    def free_motions(self) -> tuple[str, ...]:
        """Return the motion words, along the joint's axes, that the joint leaves free, in the order of `MOTIONS`."""

    def held_motions(self) -> tuple[str, ...]:
        """Return the other motion words."""
        return tuple(word for word in MOTIONS if word not in self.free_motions())

    def frame(self) -> Floats:
        """Return the joint's axes x, y, z in the reference shape (3, 3), columns, global components."""
        return np.eye(3)

    def resolve(
        self, path: str, places: tuple[AnyPlace, AnyPlace | None], positions: tuple[Floats, Floats]
    ) -> ResolvedJoint:
        """Return the joint with its places, those of `ends` in their order, and its position on each side."""
        (a, b), (at_a, at_b) = places, positions
        return ResolvedJoint(
            path, self.word, self.label, a, b, at_a, at_b, self.frame(), self.free_motions(),
            self.held_motions(), named_laws(self.stiffness, "stiffness", self.label),
            named_laws(self.damping, "damping", self.label), dict(self.rest), named_motions(self.motion, self.label),
        )  # fmt: skip

    @model_validator(mode="after")
    def _acts_on_what_is_free(self) -> Self:
        require_two_ends(("a", self.a), ("b", self.b), "joint")
        free = self.free_motions()
        what, instead = f"this {self.word} joint does not let go of", "use a joint that leaves it free"
        if free:
            instead = f"the motions that it leaves free are {', '.join(free)}"
        require_law_words(self.stiffness, self.damping, self.rest, free, what, instead)
        for word in self.motion:
            if word not in free:
                raise RefusedError(f"{what} {word}", instead, found=f"a motion {word}", at=("motion", word))
            for key, table in (("stiffness", self.stiffness), ("damping", self.damping)):
                if word in table:
                    raise RefusedError(
                        f"a motion that follows a function of time has no {key}",
                        f"leave {word} out of motion or out of {key}",
                        found=f"{word} in both",
                        at=("motion", word),
                    )
        return self
