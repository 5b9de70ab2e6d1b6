"""Base class of supports."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.connections.motion_words import (
    MOTIONS,
    Motion,
    motion_functions,
    named_motions,
)
from viscorod.model.connections.place import AnyPlace, PlaceField
from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.metadata import Key
from viscorod.typing import Floats

__all__ = ["AnySupport", "Frame", "ResolvedSupport"]

Frame: TypeAlias = Literal["global", "node", "axes", "body"]


@dataclass(frozen=True, eq=False)
class ResolvedSupport:
    """A support as the analysis needs it.

    Attributes:
        path: key path, ``supports[0]``.
        label: kind and place, ``clamp at beam.start``.
        place: the supported station of a rod, or the supported body.
        frame: "global", "node" (the rod's d1, d2, d3 there), "axes" (the support's own directions, fixed
            in space) or "body" (the axes of the moving section: velocities are held, not positions).
        axes: the directions x, y, z of the motion words as columns (3, 3), global components, in the
            reference shape; the unit matrix for "global", zero for "body".
        fixed: motion words that stay zero, in the order of `MOTIONS`.
        motion: motion words that follow a function of time (m or rad), in the same order.
    """

    path: str
    label: str
    place: AnyPlace
    frame: Frame
    axes: Floats
    fixed: tuple[str, ...]
    motion: dict[str, TimeFunction]

    @property
    def held(self) -> tuple[str, ...]:
        """All motion words that are fixed or prescribed, in the order of `MOTIONS`."""
        return tuple(word for word in MOTIONS if word in self.fixed or word in self.motion)


MotionField = Annotated[Motion, motion_functions]


class AnySupport(Definition):
    """Base class of supports: a place, and motions that follow functions of time."""

    tag: ClassVar[str | None] = "kind"

    at: PlaceField = Key("place")
    motion: MotionField = Key(
        "held motion words, in the support's axes, that follow functions of time ({} or {}) instead of staying zero",
        "m",
        "rad",
        default={},
        kw_only=True,
    )

    @property
    def label(self) -> str:
        """Kind and place, for messages and results: ``clamp at beam.start``."""
        return f"{type(self).model_fields['kind'].default} at {self.at}"

    @abstractmethod
    def held(self) -> tuple[str, ...]:
        """Return the motion words that are fixed or prescribed."""

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """Return the frame's word and axes (3, 3), columns, for the frame `node` (3, 3) of the rod or body there."""
        del node
        return "global", np.eye(3)

    def resolve(self, path: str, place: AnyPlace, node: Floats) -> ResolvedSupport:
        """Return the support with its axes.

        Args:
            path: key path of the support.
            place: the place that `at` names.
            node: the frame of the rod or body there in the reference shape (3, 3), columns.
        """
        frame, axes = self.axes_at(node)
        fixed = tuple(word for word in self.held() if word not in self.motion)
        return ResolvedSupport(
            path, self.label, place, frame, axes, fixed, named_motions(self.motion, f"the {self.label}")
        )

    @model_validator(mode="after")
    def _moves_what_it_holds(self) -> Self:
        for word in self.motion:
            if not self.held():
                raise RefusedError(
                    "this kind of support holds velocities, no positions",
                    "give velocity, a table of functions of time, in place of motion",
                    found=f"a motion {word}",
                    at=("motion", word),
                )
            if word not in self.held():
                raise RefusedError(
                    f"this kind of support does not hold {word}, so it cannot move it",
                    f"move one of {', '.join(self.held())}, or use kind = 'support'",
                    found=f"a motion {word}",
                    at=("motion", word),
                )
        return self
