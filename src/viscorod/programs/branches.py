"""Refuse rods that other programs cannot represent."""

from __future__ import annotations

from collections.abc import Sequence

from viscorod.errors import Fault, InputError
from viscorod.model.rod import Rod
from viscorod.typing import Floats

__all__ = ["refuse_branches"]


def refuse_branches(rod: Rod, stations: Floats | Sequence[float]) -> None:
    """Refuse a rod with Maxwell branches at one of the arc lengths `stations`, m.

    Raises:
        InputError: the section there has them.
    """
    for s in stations:
        if rod.branches_at(float(s))[0].size:
            raise InputError(
                Fault(
                    "rod",
                    "",
                    f"its section at {s:.4g} m has Maxwell branches, and the other programs have Kelvin-Voigt "
                    "damping only",
                    'a Prony series with law = "kelvin_voigt" has the viscosity of slow motion instead',
                )
            )
