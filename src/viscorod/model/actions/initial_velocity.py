"""Initial velocities of rods and rigid bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.metadata import Key, optional
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import Name, Vector, function, sequence, vector
from viscorod.typing import Floats

__all__ = ["InitialVelocity"]

Field6: TypeAlias = Callable[[float], tuple[Sequence[float], Sequence[float]]]


class InitialVelocity(Definition):
    """The velocity of a rod or rigid body at t = 0: that of a rigid motion, or any (of a rod, in Python only)."""

    renamed: ClassVar[dict[str, str]] = {"about": "point"}

    rod: Name = Key("name of the rod or body")
    linear: Vector = Key("velocity of the `point`, {}, global axes", "m/s", default=(0.0, 0.0, 0.0))
    angular: Vector = Key("angular velocity, {}, global axes", "rad/s", default=(0.0, 0.0, 0.0))
    point: Vector = Key("of the body, where it is at t = 0", "m", default=(0.0, 0.0, 0.0))
    field: Annotated[Field6 | None, optional(function)] = Key(
        "s -> (velocity, angular velocity) in global axes, instead of the three above", default=None
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        extra = sorted(self.model_fields_set & {"linear", "angular", "point"})
        if self.field is not None and extra:
            raise RefusedError(
                "the velocity is given both as a function and as that of a rigid body",
                f"leave out {', '.join(extra)} or field",
                found="",
            )
        return self

    def at(self, s: float, position: Floats) -> tuple[Floats, Floats]:
        """Return velocity and angular velocity (3,) at the arc length `s` and the position (3,), global axes."""
        if self.field is None:
            angular = np.array(self.angular)
            return np.array(self.linear) + np.cross(angular, position - np.array(self.point)), angular
        return returned(
            self.field,
            s,
            check=_two_vectors,
            name=f"the function of the initial velocity of {self.rod!r}",
            where=f"at s = {s:.6g} m",
            instead="return two vectors of three numbers, velocity and angular velocity",
            at=("field",),
        )


def _two_vectors(value: Any) -> tuple[Floats, Floats]:
    both = sequence(value)
    if len(both) != 2:
        raise RefusedError("two vectors are needed here")
    return np.array(vector(both[0])), np.array(vector(both[1]))
