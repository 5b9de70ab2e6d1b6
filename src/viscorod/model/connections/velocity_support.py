"""A support that holds velocities along the axes of the moving section."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.given_as import GivenAs, Words
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_function_kinds import time_function
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
    """The motion of a support that prescribes a velocity and does not measure a position: only its rate is used."""

    kind: Literal["travelled"] = Field(default="travelled", kw_only=True, repr=False)
    speed: TimeFunction

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Breakpoints of the velocity, s."""
        return self.speed.breakpoints

    def value(self, t: float, before: bool = False) -> float:
        """Return zero: no position is prescribed."""
        del t, before
        return 0.0

    def rate(self, t: float, before: bool = False) -> float:
        """Return the velocity."""
        return self.speed.value(t, before)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return the derivative of the velocity."""
        return self.speed.rate(t, before)


class VelocitySupport(AnySupport):
    """Holds velocities of the section along its own moving axes, as in the intrinsic equations of beams.

    The support does not hold a position: the place may drift. Three zero velocities v1, v2, v3 are a ball joint,
    all six a clamp. Total section forces along the other components are following forces and moments.
    """

    unused: ClassVar[tuple[str, ...]] = ("motion",)  # positions are free
    kind: Literal["body_velocity"] = Field(default="body_velocity", kw_only=True, repr=False)
    fixed: Annotated[GivenAs[tuple[str, ...], Words], fixed_velocities] = Key(
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
        """Return no motion words: positions are free."""
        return ()

    def resolve(self, path: str, place: AnyPlace, node: Floats) -> ResolvedSupport:
        """See `AnySupport`; the words are those of the motions along the same axes."""
        del node
        word = dict(zip(VELOCITIES, MOTIONS, strict=True))
        motion: dict[str, TimeFunction] = {
            word[name]: _Travelled(speed=time_function(speed).of(f"the velocity {name} of the {self.label}"))
            for name, speed in self.velocity.items()
        }
        fixed = tuple(word[name] for name in self.fixed)
        return ResolvedSupport(path, self.label, place, "body", np.zeros((3, 3)), fixed, motion)
