"""Units of measured responses: what is over what, so that a receptance is not compared with an accelerance."""

from __future__ import annotations

from functools import cache
from typing import Any

from viscorod.errors import Fault, InputError
from viscorod.unit_text import Dimension, factor_of
from viscorod.units import without_angle
from viscorod.wording import RefusedError

__all__ = ["is_load_over_motion", "require_same_unit", "si_unit_of_kind", "unit_of_response"]

MOTIONS, LOADS = ("1", "m", "m/s", "m/s^2"), ("N", "N m")


@cache
def _kinds() -> dict[Dimension, str]:
    """Return the SI units of responses by their kinds, without angles; motions over loads are first."""
    pairs = [(over, under) for over in MOTIONS for under in (*LOADS, *MOTIONS)]
    pairs += [(over, under) for over in LOADS for under in (*MOTIONS, *LOADS)]
    found: dict[Dimension, str] = {}
    for over, under in pairs:
        text = f"{over}/({under})" if " " in under or "/" in under else f"{over}/{under}"
        text = over if under == "1" else "1" if over == under else text
        found.setdefault(_kind(text), text)
    return found


def _kind(unit: str) -> Dimension:
    return () if unit == "1" else without_angle(factor_of(unit)[1])


def si_unit_of_kind(kind: Dimension) -> str | None:
    """Return the SI unit of responses of a kind, "m/s^2/N"; None of plain numbers, volts and what is no response."""
    found = _kinds().get(without_angle(kind))
    return None if found == "1" else found


def unit_of_response(where: str, unit: Any) -> str | None:
    """Return the unit of values in SI.

    Raises:
        InputError: it is no unit, or none of SI.
    """
    if unit is None:
        return None
    why, instead = "values are in SI", "give the unit in SI, such as 'm/s^2/N'"
    try:
        size, kind = (
            factor_of(unit) if isinstance(unit, str) and unit != "1" else (1 if unit == "1" else 0, ())
        )
    except RefusedError as error:
        size, kind, why, instead = 0, (), error.why, error.instead
    if size != 1:
        raise InputError(Fault(f"{where}: unit", repr(unit), why, instead))
    return si_unit_of_kind(kind)


def require_same_unit(where: str, unit: str | None, model: str, *, gain: bool) -> None:
    """Raise `InputError` where a record has values of another kind than the response of a model.

    Args:
        where: of the record, for messages; unit: of the record, None where it is not known.
        model: unit of the response of the model.
        gain: whether a factor between them is unknown, which may have a unit, but holds at all frequencies.
    """
    if unit is None:
        return
    own, other = _kind(unit), _kind(model)
    if dict(own).get("second") == dict(other).get("second") if gain else own == other:
        return
    raise InputError(
        Fault(
            f"{where}: unit", unit, f"the response of the model is in {model}",
            "name the output of the case that was measured (ux is a displacement, vx a velocity, ax an acceleration), "
            "and the input that it is over, or correct the unit",
        )
    )  # fmt: skip


def is_load_over_motion(unit: str | None) -> bool:
    """Return whether a unit is that of a dynamic stiffness, an impedance or an apparent mass."""
    return unit is not None and unit.startswith("N") and _kind(unit) != ()
