"""Settings of stability along a load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import NOT_NEGATIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import numbers, whole_number
from viscorod.solve.settings.buckling import ConstantNames
from viscorod.solve.settings.campbell import MOST, increasing
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import Meshed

__all__ = ["StabilitySettings"]


@accepts(listed(quantity(bounds=NOT_NEGATIVE), 2), "list of numbers >= 0, increasing")
def _factors(value: Any) -> tuple[float, ...]:
    return increasing(value)


@accepts(listed(quantity(bounds=NOT_NEGATIVE), 2, 2), "two numbers >= 0, the second is larger")
def _band(value: Any) -> tuple[float, float]:
    low, high = increasing(numbers(value, count=2))
    return low, high


class StabilitySettings(Meshed):
    """Over which loads modes are followed.

    Exactly one of `load_factors` and `band` is given.
    """

    needs: ClassVar[str] = "a band"

    load_factors: Annotated[GivenAs[Sequence[float] | None, Amounts | None], optional(_factors)] = Key(
        "multiples of the loads that grow, increasing", default=None
    )
    band: Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(_band)] = Key(
        "lowest and highest load factor, between which there are `count` load factors", default=None
    )
    count: Annotated[int, whole_number(2, MOST)] = Key("number of load factors in the `band`", default=41)
    modes: Annotated[int, whole_number(1, 200)] = Key(
        "number of modes that are followed, 1 to 200", default=4
    )
    constant: ConstantNames = Key(
        "what acts in full throughout, the prestress, by the names of stages: loads by their `name` or kind, "
        "prescribed motions by their places. All else grows with the load factor",
        default=(),
    )

    @property
    def values(self) -> tuple[float, ...]:
        """The load factors."""
        if self.load_factors is not None:
            return tuple(self.load_factors)
        assert self.band is not None
        return tuple(float(value) for value in np.linspace(*self.band, self.count))

    @property
    def course(self) -> Course:
        """See :class:`Meshed`."""
        return Course("load", "", self.values[0], self.values[-1])

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.load_factors is None) == (self.band is None):
            raise RefusedError(
                "load factors are given, or are between two",
                "give load_factors = [..] or band = [low, high]",
                found="none" if self.band is None else "both",
                at=("band",),
            )
        if self.band is None and "count" in self.model_fields_set:
            raise RefusedError(
                "load factors that are given are as many as they are",
                "leave it out, or give a band",
                found=show(self.count),
                at=("count",),
            )
        return self
