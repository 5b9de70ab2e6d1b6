"""Drag of the medium around a rod: the load that resists motion, and that a wind or current exerts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.load_base import AlongRod
from viscorod.model.actions.load_effects import Arrows, CompiledLaw, Placing
from viscorod.model.connections.place import Place
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import NonNegative, OptionalNonNegative, OptionalPositive, Vector
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["Drag"]

_COEFFICIENTS = ("coefficient_across", "coefficient_along")
_MEDIUM = ("density", "width")
SAMPLES = 257
"""Times at which the factor is looked at."""


class Drag(AlongRod):
    """The drag of a medium per reference length of a rod, linear and quadratic in the velocity past the medium.

    Across and along the axis d3 of the section it is, with the velocity u of the section past the medium::

        -(linear_across + density coefficient_across width |u_across| / 2) u_across
        -(linear_along + density coefficient_along pi width |u_along| / 2) u_along

    and about it -linear_about times the angular velocity (Morison et al. 1950; Taylor 1952). Drag acts at the nodes,
    each for its part of the length. It resists motion in all analyses, and a medium that moves loads what is at rest;
    what motion loses to it is `run.energy.outside`.
    """

    sees_motion: ClassVar[bool] = True
    kind: Literal["drag"] = Field(default="drag", kw_only=True, repr=False)
    linear_across: NonNegative = Key(
        "force per length and velocity across the axis", "Pa s", default=0.0, kw_only=True
    )
    linear_along: NonNegative = Key("the same along the axis", "Pa s", default=0.0, kw_only=True)
    linear_about: NonNegative = Key(
        "moment per length and angular velocity about the axis", "N s", default=0.0, kw_only=True
    )
    coefficient_across: OptionalNonNegative = Key(
        "drag coefficient across the axis, 1.2 or so of a round rod in air", default=None, kw_only=True
    )
    coefficient_along: OptionalNonNegative = Key(
        "drag coefficient along the axis, of the surface `pi width`, 0.01 or so", default=None, kw_only=True
    )
    density: OptionalPositive = Key(
        "of the medium, {}; with coefficients", "kg/m^3", default=None, kw_only=True
    )
    width: OptionalPositive = Key(
        "diameter, or width across the flow, {}; with coefficients", "m", default=None, kw_only=True
    )
    velocity: Vector = Key("of the medium, {}, global axes", "m/s", default=(0.0, 0.0, 0.0), kw_only=True)

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield why there is no such rod, or no such part of it, or its axis is not d3."""
        yield from super().misfits(model)
        if self.rod in model.rods and model.rods[self.rod].tilted:
            yield RefusedError(
                "drag takes the normals of the sections as the axis of the rod, and these are tilted",
                "leave tilt out",
                found=show(self.rod),
                at=("rod",),
            )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        coefficients = [key for key in _COEFFICIENTS if getattr(self, key) is not None]
        for key in _MEDIUM:
            if coefficients and getattr(self, key) is None:
                raise RefusedError(
                    f"quadratic drag needs the {key}"
                    + (" of the medium" if key == "density" else " of the rod"),
                    f"give {key}, or leave out {' and '.join(coefficients)}",
                    found="",
                    at=(key,),
                )
            if not coefficients and getattr(self, key) is not None:
                raise RefusedError(
                    f"{key} goes with a drag coefficient",
                    "give coefficient_across or coefficient_along",
                    found=show(getattr(self, key)),
                    at=(key,),
                )
        if not any(self.numbers[:5]):
            raise RefusedError(
                "drag without any coefficient",
                f"give linear_across or {_COEFFICIENTS[0]}, for example",
                found="",
            )
        negative = self._negative_at()
        if negative is not None:
            raise RefusedError(
                f"the factor of drag is negative at {negative:.6g} s, where it would drive the motion",
                "give a function of time that is nowhere negative, or turn the velocity round",
                found="",
                at=("time",),
            )
        return self

    def _negative_at(self) -> float | None:
        """Return a time at which its factor is negative, s, among some that are tried; functions are not called."""
        if self.time is None or isinstance(self.time, FunctionOfTime):
            return None
        period = 1.0 / (getattr(self.time, "frequency", 0.0) or 1.0)
        tried = np.linspace(0.0, max([0.0, *self.time.breakpoints]) + period, SAMPLES)
        return next((float(t) for t in tried if self.time.value(float(t)) < 0.0), None)

    @property
    def numbers(self) -> tuple[float, ...]:
        """What the law takes: linear across, along, about; quadratic across and along, kg/m^2; velocity."""
        pressure = 0.5 * (self.density or 0.0) * (self.width or 0.0)
        across = pressure * (self.coefficient_across or 0.0)
        along = math.pi * pressure * (self.coefficient_along or 0.0)
        return (self.linear_across, self.linear_along, self.linear_about, across, along, *self.velocity)

    def figures(self) -> dict[str, float | str]:
        """Return the coefficients of the law, and the velocity of the medium."""
        across, along, about, square_across, square_along, *velocity = self.numbers
        return {
            "across [Pa s]": across,
            "along [Pa s]": along,
            "about [N s]": about,
            "across [kg/m2]": square_across,
            "along [kg/m2]": square_along,
            "medium [m/s]": f"({', '.join(f'{value:.4g}' for value in velocity)})",
        }

    def place(self, model: ModelDescription, placing: Placing) -> None:
        """Let it act on the nodes."""
        del model
        law = CompiledLaw("drag", self.numbers, self.velocity, at_rest=any(self.velocity))
        placing.seeing_motion(self.rod, law, self.factor, start=self.from_s or 0.0, end=self.to_s)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        """Return what the medium exerts on the reference shape at rest: nothing unless it moves."""
        del t
        stations = self.feet(model)
        _, frames = model.rods[self.rod].frames(stations)
        values = np.array([self._at_rest(axis) for axis in frames[:, :, 2]])
        return Arrows(f"drag along {self.rod}", "N/m", tuple(Place(self.rod, s) for s in stations), values)

    def _at_rest(self, axis: Floats) -> Floats:
        """Return the force per length (3,) on a section at rest with this normal, global axes."""
        across, along, _, square_across, square_along = self.numbers[:5]
        speed = float(axis @ np.array(self.velocity))
        sideways = np.array(self.velocity) - speed * axis
        return np.asarray(
            (across + square_across * np.linalg.norm(sideways)) * sideways
            + (along + square_along * abs(speed)) * speed * axis
        )
