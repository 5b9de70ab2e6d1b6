"""The strain that a rod has when a motion begins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np

from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import quantity, row
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import Name, number, sequence
from viscorod.typing import Floats

__all__ = ["InitialStrain", "StrainField", "six_strains", "strain_field"]

StrainField: TypeAlias = tuple[float, ...] | Callable[[float], Sequence[float]]


def six_strains(value: Any) -> tuple[float, ...]:
    """Return `value` as six finite floats."""
    items = sequence(value)
    if len(items) != 6:
        raise RefusedError(
            "six strains are needed here",
            "give shear 1, shear 2, stretch (1), bend 1, bend 2, twist (1/m)",
            found=show(value),
        )
    return tuple(number(item) for item in items)


@accepts(row([quantity(unit=k // 3) for k in range(6)]), "6 numbers", "or a function of the arc length")
def strain_field(value: Any) -> StrainField:
    """Return `value` as six finite floats, or as the function that it is."""
    return value if callable(value) else six_strains(value)


class InitialStrain(Definition):
    """The strain of a rod at t = 0, instead of the equilibrium; the start of the rod has its reference pose.

    In statics, where nothing but the rod itself can keep a strain, it is imposed as a `RestStrain`, and the result says
    so.
    """

    rod: Name = Key("name of the rod")
    value: Annotated[StrainField, strain_field] = Key(
        "shear 1, shear 2, stretch ({}), bend 1, bend 2, twist ({})", "1", "1/m"
    )

    def at(self, s: float) -> Floats:
        """Return the strains (6,) at the arc length `s`."""
        if not callable(self.value):
            return np.array(self.value)
        strains = returned(
            self.value,
            s,
            check=six_strains,
            name=f"the function of the initial strain of {self.rod!r}",
            where=f"at s = {s:.6g} m",
            instead="return six numbers",
            at=("value",),
        )
        return np.array(strains)
