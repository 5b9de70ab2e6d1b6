"""A support that holds velocities along the axes of the moving section."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_table import time_function
from viscorod.model.connections.motion_words import (
    MOTIONS,
    VELOCITIES,
    Motion,
    fixed_velocities,
    velocity_functions,
)
from viscorod.model.connections.place import AnyPlace
from viscorod.model.connections.support_base import AnySupport, ResolvedSupport
from viscorod.model.fields.definition import RefusedError
from viscorod.model.fields.metadata import Key
from viscorod.typing import Floats

__all__ = ["VelocitySupport"]


class _Travelled(TimeFunction):
    """The motion that belongs to a prescribed velocity of a support that measures no position: only its rate counts."""

    kind: Literal["travelled"] = Field(default="travelled", kw_only=True, repr=False)
    speed: TimeFunction

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Those of the velocity."""
        return self.speed.breakpoints

    def value(self, t: float, before: bool = False) -> float:
        """Zero: there is no position to be at."""
        del t, before
        return 0.0

    def rate(self, t: float, before: bool = False) -> float:
        """The velocity."""
        return self.speed.value(t, before)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Its derivative."""
        return self.speed.rate(t, before)


class VelocitySupport(AnySupport):
    """Holds velocities of the section along its own moving axes, as in the intrinsic equations of beams.

    What turns with the section is no position: the place may wander. Three zero velocities v1, v2, v3 are a ball joint,
    all six a clamp. Total section forces along the other components are following forces and moments.
    """

    unused: ClassVar[tuple[str, ...]] = ("motion",)  # positions are free
    kind: Literal["body_velocity"] = Field(default="body_velocity", kw_only=True, repr=False)
    fixed: Annotated[tuple[str, ...], fixed_velocities] = Key(
        "velocity words v1, v2, v3 (m/s), w1, w2, w3 (rad/s) that stay zero", default=()
    )
    velocity: Annotated[Motion, velocity_functions] = Key(
        "velocity words with functions of time ({}, {}). They are continuous",
        "m/s",
        "rad/s",
        default={},
        kw_only=True,
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        both = [word for word in self.fixed if word in self.velocity]
        if both:
            raise RefusedError(
                "a velocity cannot be both fixed and prescribed",
                f"leave {both[0]} out of fixed or out of velocity",
                found=f"{both[0]} in both",
                at=("velocity", both[0]),
            )
        if not self.fixed and not self.velocity:
            raise RefusedError(
                "this support holds nothing",
                f"give fixed, a list of some of {', '.join(VELOCITIES)}, or velocity",
                found="",
                at=("fixed",),
            )
        return self

    def held(self) -> tuple[str, ...]:
        """None: positions are free."""
        return ()

    def resolve(self, path: str, place: AnyPlace, node: Floats) -> ResolvedSupport:
        """See `AnySupport`; the words are those of the motions along the same axes."""
        del node
        word = dict(zip(VELOCITIES, MOTIONS, strict=True))
        motion: dict[str, TimeFunction] = {
            word[name]: _Travelled(speed=time_function(speed)) for name, speed in self.velocity.items()
        }
        fixed = tuple(word[name] for name in self.fixed)
        return ResolvedSupport(path, self.label, place, "body", np.zeros((3, 3)), fixed, motion)
