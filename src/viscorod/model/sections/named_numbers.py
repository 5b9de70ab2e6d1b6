"""Numbers of sections by the names that engineers give them, in place of lists whose order programs do not share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from viscorod.errors import Fault, InputError
from viscorod.model.fields.forms import NOT_NEGATIVE, Form, quantity
from viscorod.model.fields.values import amount
from viscorod.wording import RefusedError, did_you_mean, show

__all__ = ["INERTIA_NAMES", "STIFFNESS_NAMES", "diagonal_by_name", "inertia_by_name", "named_form"]

STIFFNESS_NAMES = ("GA1", "GA2", "EA", "EI1", "EI2", "GJ")
"""Stiffness against shear along d1 and d2, stretch, bending about d1 and d2, twist: in the order of the strains."""
INERTIA_NAMES = ("mass", "J1", "J2", "J3")
"""Mass per length, and moments of inertia per length about d1, d2 and d3; J3 is J1 + J2 if it is left out."""


def named_form(names: Sequence[str], units: Sequence[int], bounds: Form | None = None) -> Form:
    """Return the form of a table of named numbers, each with the place of its unit among those of the field."""
    numbers = {name: quantity(bounds=bounds, unit=unit) for name, unit in zip(names, units, strict=True)}
    return {"type": "object", "properties": numbers, "additionalProperties": False}


STIFFNESS_FORM = named_form(STIFFNESS_NAMES, (0, 0, 0, 2, 2, 2))
INERTIA_FORM = named_form(INERTIA_NAMES, (0, 2, 2, 2))
TIMES_FORM = named_form(STIFFNESS_NAMES, (0,) * 6, NOT_NEGATIVE)


def diagonal_by_name(value: Mapping[Any, Any], *, all_needed: bool) -> tuple[float, ...]:
    """Return the six numbers of a table by the names of the stiffnesses; those left out are 0, if that is allowed."""
    found = _numbers(value, STIFFNESS_NAMES)
    missing = [name for name in STIFFNESS_NAMES if name not in found]
    if missing and all_needed:
        raise RefusedError(
            f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing",
            "give all of GA1, GA2, EA, EI1, EI2 and GJ: 0 for EI1, EI2 and GJ of a cable; where shear is not known, "
            "GA1 and GA2 are EA/5 to EA/3 in a solid section, of any size with constraints = 'unshearable' of the rod",
            found="",
        )
    return tuple(found.get(name, 0.0) for name in STIFFNESS_NAMES)


def inertia_by_name(value: Mapping[Any, Any]) -> tuple[float, ...]:
    """Return the six numbers of the inertia from the table of mass and moments of inertia per length."""
    found = _numbers(value, INERTIA_NAMES)
    missing = [name for name in INERTIA_NAMES[:3] if name not in found]
    if missing:
        raise RefusedError(
            f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing",
            "give mass, J1 and J2, and J3 where it is not their sum; of a section of one material J1 = mass EI1/EA and "
            "J2 = mass EI2/EA",
            found="",
        )
    mass, j1, j2 = (found[name] for name in INERTIA_NAMES[:3])
    return mass, mass, mass, j1, j2, found.get("J3", j1 + j2)


def _numbers(value: Mapping[Any, Any], names: Sequence[str]) -> dict[str, float]:
    return {str(name): _checked(name, item, names, amount) for name, item in value.items()}


def _checked(name: Any, item: Any, names: Sequence[str], check: Callable[[Any], float]) -> float:
    from viscorod.model.fields.definition import at_key

    if name not in names:
        raise InputError(
            Fault(
                str(name), show(item), "no such name", f"{did_you_mean(name, names)}give {', '.join(names)}"
            )
        )
    with at_key(str(name), item):
        return check(item)
