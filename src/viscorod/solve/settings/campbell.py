"""Settings of Campbell diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import NOT_NEGATIVE, POSITIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import Direction, Triple, numbers, one_of, vector, whole_number
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.settings.steady import SteadySettings

__all__ = ["CampbellSettings", "increasing"]

MOST = 10_000
"""Values of the parameter at most."""


def increasing(value: Any) -> tuple[float, ...]:
    """Return at least two increasing numbers >= 0.

    Raises:
        RefusedError: they are not.
    """
    found = numbers(value, at_least=2)
    if len(found) > MOST:
        raise RefusedError("too many values", f"give {MOST} at most", found=f"{len(found)}")
    for index, (low, high) in enumerate(zip((-1.0, *found), found, strict=False)):
        if high < 0.0 or high <= low:
            raise RefusedError(
                "values are >= 0 and increase", "sort them, each once", found=show(high), at=(index,)
            )
    return found


@accepts(listed(quantity(bounds=NOT_NEGATIVE), 2), "list of numbers >= 0, increasing")
def _speeds(value: Any) -> tuple[float, ...]:
    return increasing(value)


@accepts(listed(quantity(bounds=NOT_NEGATIVE), 2, 2), "two numbers >= 0, the second is larger")
def _band(value: Any) -> tuple[float, float]:
    low, high = increasing(numbers(value, count=2))
    return low, high


@accepts(listed(quantity(bounds=POSITIVE)), "list of numbers > 0")
def _orders(value: Any) -> tuple[float, ...]:
    found = numbers(value, at_least=0)
    for index, order in enumerate(found):
        if not order > 0.0:
            raise RefusedError(
                "an engine order is > 0", "give whole numbers such as 1, 2", found=show(order), at=(index,)
            )
    return found


class CampbellSettings(Meshed):
    """Over which speeds modes are followed.

    Exactly one of `speeds` and `band` is given.
    """

    needs: ClassVar[str] = "an axis and a band"

    axis: Direction = Key("about which the supports turn with the model, global axes, by the right-hand rule")
    speeds: Annotated[GivenAs[Sequence[float] | None, Amounts | None], optional(_speeds)] = Key(
        "angular speeds, increasing, {}", "rad/s", default=None
    )
    band: Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(_band)] = Key(
        "lowest and highest angular speed, {}, between which there are `count` speeds", "rad/s", default=None
    )
    count: Annotated[int, whole_number(2, MOST)] = Key("number of speeds in the `band`", default=41)
    modes: Annotated[int, whole_number(1, 200)] = Key(
        "number of modes that are followed, 1 to 200", default=8
    )
    engine_orders: Annotated[GivenAs[tuple[float, ...], Amounts], _orders] = Key(
        "multiples of the speed at which something excites: critical speeds are where a frequency is one of them",
        default=(1.0,),
    )
    frame: Annotated[str, one_of("turning", "space")] = Key(
        '"turning": frequencies as they are seen on the model, as blades see what stands still; "space": as they '
        "are seen from outside, as the unbalance of a shaft excites; the latter for models that are alike all around "
        "the axis",
        default="turning",
    )
    centre: Annotated[GivenAs[Triple | None, Amounts | None], optional(vector)] = Key(
        "a point on the axis, {}; the origin unless given", "m", default=None
    )

    @property
    def values(self) -> tuple[float, ...]:
        """The speeds [rad/s]."""
        if self.speeds is not None:
            return tuple(self.speeds)
        assert self.band is not None
        return tuple(float(value) for value in np.linspace(*self.band, self.count))

    @property
    def course(self) -> Course:
        """See :class:`Meshed`."""
        return Course("speed", " rad/s", self.values[0], self.values[-1])

    def steady(self) -> SteadySettings:
        """Return the settings of the rotation at the highest speed."""
        x, y, z = (self.values[-1] * part for part in self.axis)
        return SteadySettings(spin=(x, y, z), centre=self.centre)

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.speeds is None) == (self.band is None):
            raise RefusedError(
                "speeds are given, or are between two",
                "give speeds = [..] or band = [low, high], rad/s",
                found="none" if self.band is None else "both",
                at=("band",),
            )
        if self.band is None and "count" in self.model_fields_set:
            raise RefusedError(
                "speeds that are given are as many as they are",
                "leave it out, or give a band",
                found=show(self.count),
                at=("count",),
            )
        return self
