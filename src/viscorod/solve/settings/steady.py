"""Settings of a steady rotation."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from viscorod.given_as import Amount, Amounts, GivenAs
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import POSITIVE, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import (
    TRIPLE,
    OptionalDirection,
    OptionalPositive,
    Triple,
    one_of,
    positive,
    vector,
    whole_number,
)
from viscorod.solve.formulations.registry import FORMULATIONS, dampings
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.start import OptionalStart

__all__ = ["SteadySettings"]


@accepts(quantity(TRIPLE, bounds=POSITIVE), "number > 0, or 3 numbers")
def _spin(value: Any) -> float | Triple:
    """Return an angular speed, or an angular velocity."""
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        given = vector(value)
        if not any(given):
            raise RefusedError("nothing turns", "give an angular velocity such as [0, 0, 4.0]")
        positive(math.hypot(*given))
        return given
    return positive(value)


class SteadySettings(Meshed):
    """Which steady rotation is sought.

    Exactly one of `spin`, `energy` and `momentum` is given.
    """

    needs: ClassVar[str] = "a spin"
    renamed: ClassVar[dict[str, str]] = {"about": "centre"}

    spin: Annotated[GivenAs[float | Triple | None, Amount | Amounts | None], optional(_spin)] = Key(
        "{}. Three numbers: the angular velocity, global axes, with which the supports turn, or about which a rod on "
        "a ball joint or without supports does. One number: how fast such a rod turns, about an axis that is found",
        "rad/s",
        default=None,
    )
    energy: OptionalPositive = Key("kinetic and elastic energy of a rod that turns freely", "J", default=None)
    momentum: OptionalPositive = Key(
        "its angular momentum about the ball joint or the mass centre", "N m s", default=None
    )
    axis: OptionalDirection = Key(
        "of a rod that turns freely: the reference shape about this axis, global axes, is the first "
        "guess; without it a bent shape is sought",
        default=None,
    )
    centre: Annotated[GivenAs[Triple | None, Amounts | None], optional(vector)] = Key(
        "a point on the axis of a given angular velocity, {}. Unless given it is the origin, for a "
        "rod that turns freely the ball joint or the mass centre",
        "m",
        default=None,
    )
    formulation: Annotated[Literal["geometric", "intrinsic"], one_of("geometric", "intrinsic")] = Key(
        '"geometric" (positions and rotations) or "intrinsic" (body velocities and strains)',
        default="geometric",
    )
    damping: Annotated[Literal["full", "linearised"], one_of("full", "linearised")] = Key(
        '"full" Kelvin-Voigt damping or "linearised" (Artola, Wynn and Palacios), which lets rods '
        "turn about their own axis only; the latter with the intrinsic formulation",
        default="full",
    )
    modes: Annotated[int, whole_number(1, 1000)] = Key(
        "number of small motions about the rotation to report, 1 to 1000", default=6
    )
    start: OptionalStart = Key(
        "state of an earlier result, a motion that turns, as first guess", default=None
    )

    @property
    def measure(self) -> Literal["spin", "energy", "momentum"]:
        """The one that is given."""
        return "spin" if self.spin is not None else "energy" if self.energy is not None else "momentum"

    @property
    def driven(self) -> bool:
        """Whether the angular velocity is given as a vector."""
        return isinstance(self.spin, tuple)

    @model_validator(mode="after")
    def _one_measure(self) -> Self:
        given = [name for name in ("spin", "energy", "momentum") if getattr(self, name) is not None]
        if len(given) != 1:
            raise RefusedError(
                "a steady rotation is picked by exactly one of spin, energy and momentum",
                "give one of them, such as spin = [0, 0, 4.0]",
                found=" and ".join(given),
                at=(given[1],) if given else ("spin",),
            )
        if self.driven and self.axis is not None:
            raise RefusedError(
                "the angular velocity has an axis already",
                "leave axis out, or give spin as one number",
                found=show(self.axis),
                at=("axis",),
            )
        if self.centre is not None and not self.driven:
            raise RefusedError(
                "a rod that turns freely turns about its ball joint or its mass centre",
                "leave centre out, or give spin as an angular velocity, three numbers",
                found=show(self.centre),
                at=("centre",),
            )
        if (self.formulation, self.damping) not in FORMULATIONS:
            raise RefusedError(
                f"the {self.formulation} formulation has {' or '.join(dampings(self.formulation))} damping only",
                "add formulation = 'intrinsic', or leave out damping",
                found=show(self.damping),
                at=("damping",),
            )
        return self
