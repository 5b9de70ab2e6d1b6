"""Strains given to rods: the initial one of a motion, and the one at rest, without stress."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np

from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import quantity, row
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import Name, number, sequence
from viscorod.typing import Floats

__all__ = ["InitialStrain", "RestStrain"]

StrainField: TypeAlias = tuple[float, ...] | Callable[[float], Sequence[float]]


def _six(value: Any) -> tuple[float, ...]:
    items = sequence(value)
    if len(items) != 6:
        raise RefusedError(
            "six strains are needed here",
            "give shear 1, shear 2, stretch (1), bend 1, bend 2, twist (1/m)",
            found=show(value),
        )
    return tuple(number(item) for item in items)


@accepts(row([quantity(unit=k // 3) for k in range(6)]), "6 numbers", "or a function of the arc length")
def _strain(value: Any) -> StrainField:
    return value if callable(value) else _six(value)


class _Strain(Definition):
    """A strain of a whole rod."""

    rod: Name = Key("name of the rod")
    value: Annotated[StrainField, _strain] = Key(
        "shear 1, shear 2, stretch ({}), bend 1, bend 2, twist ({})", "1", "1/m"
    )

    def at(self, s: float) -> Floats:
        """Return the strains (6,) at the arc length `s`."""
        if not callable(self.value):
            return np.array(self.value)
        result = self.value(s)
        try:
            return np.array(_six(result))
        except ValueError as error:
            raise RefusedError(
                f"the function of the {self._noun} strain gave this at s = {s:.6g}: {error}",
                "return six numbers",
                found=show(result),
                at=("value",),
            ) from None

    _noun: ClassVar[str]


class InitialStrain(_Strain):
    """The strain of a rod at t = 0, instead of the equilibrium; the start of the rod has its reference pose.

    In statics, where nothing but the rod itself can keep a strain, it is imposed as a `RestStrain`, and the result says
    so.
    """

    _noun: ClassVar[str] = "initial"


class RestStrain(_Strain):
    """The strain at which a rod is free of stress: a heated side, a muscle, a rest curvature, a prestress.

    Section forces follow from the strain less this one. Without supports that resist it the rod takes it without any
    force. It is constant in time; a load factor multiplies it like a load.
    """

    _noun: ClassVar[str] = "rest"
