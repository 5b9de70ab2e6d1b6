"""Quantities such as "10 mm" in SI: the number exactly, the unit through Pint, the dimension checked.

Angles count as a dimension of their own where it matters: 1 Hz is a turn per second, not 1 rad/s. Where nothing can be
mistaken, rad may be added or left out: N m for N m/rad, deg/m for 1/m.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from viscorod.unit_text import Dimension, factor_of
from viscorod.wording import RefusedError

__all__ = [
    "Conversion",
    "Measured",
    "is_quantity",
    "looks_like_quantity",
    "si_of",
    "si_quantity",
    "si_value",
    "waiting",
    "without_angle",
]

# at most three digits of exponent: longer ones would become numbers that fill the memory
_QUANTITY = re.compile(r"\s*([+-]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40})(?:[eE][+-]?\d{1,3})?)\s*(\S.*?)?\s*")
_ONLY_HERE = {
    **dict.fromkeys((("m/s^2", word) for word in ("g", "g0", "g_0", "gn", "g_n")), "standard_gravity"),
    ("m", "mil"): "thou",
    ("m", "mils"): "thou",
}
"""Words that mean something else where a quantity of this kind is needed: grams and angles elsewhere."""
_WEIGHED = {"lb": "lbf", "lbs": "lbf", "kg": "kgf", "oz": "ozf"}
"""Masses that are written for the forces that weigh them."""

NAMES = {
    "m": "length",
    "m^2": "area",
    "s": "time",
    "kg": "mass",
    "N": "force",
    "N m": "moment",
    "Pa": "pressure",
    "Pa s": "viscosity",
    "kg/m^3": "density",
    "rad": "angle",
    "rad/s": "angular velocity",
    "Hz": "frequency",
    "m/s": "velocity",
    "m/s^2": "acceleration",
    "N/m": "force per length",
    "J": "energy",
    "K": "temperature",
    "1": "plain number",
}
"""What quantities of these units are called; the first that fits counts. Others are named by their units."""


@dataclass(frozen=True)
class Conversion:
    """A quantity of a case file and what it became: key path, text as given, value and its SI unit."""

    where: str
    given: str
    value: float
    unit: str


_TEMPERATURES = {"K", "°C", "degC", "C", "celsius", "kelvin", "°F", "degF"}
"""Units of temperatures, which keys have in degrees C, as a plain number."""


def looks_like_quantity(text: str) -> bool:
    """Say whether a text starts with a number."""
    return re.match(r"\s*[+-]?\.?\d", text) is not None


def si_value(text: str, unit: str, key: str) -> float:
    """Return the number in the SI unit that a key needs.

    Args:
        text: such as "10 mm".
        unit: in SI as documented, such as "N/m"; "1" for a plain number.
        key: the word of the key, for messages.

    Raises:
        RefusedError: no number with a unit, an unknown or an offset unit, or another dimension.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise RefusedError("no number with a unit", _advice(unit))
    number, given = match[1], match[2]
    if given is None:
        raise RefusedError(
            "a number in quotes has no unit", f"give {number} without quotes, in SI, or add the unit"
        )
    if unit == "1":
        warm = "degrees C as " if given.strip() in _TEMPERATURES else ""
        raise RefusedError(f"{key} has no unit", f"give {warm}a plain number, without quotes")
    factor, dimension = factor_of(_ONLY_HERE.get((unit, given), given))
    wanted = factor_of(unit)[1]
    turns = _turns(dimension, wanted)
    if turns is None:
        instead = _weighed(number, given, wanted) or _advice(unit)
        if without_angle(dimension) == without_angle(wanted):
            instead = "give rad/s, deg/s, turn/s or rpm"
        raise RefusedError(f"this is {_noun(dimension)}, {key} needs {_noun(wanted)}", instead)
    exact = Fraction(number) * factor
    try:
        value = float(exact) / (TURN if turns else 1.0)
    except OverflowError:
        raise RefusedError("larger than any quantity", _advice(unit)) from None
    if value == 0.0 and exact != 0:
        raise RefusedError("smaller than any quantity", _advice(unit))
    return value


def _weighed(number: str, given: str, wanted: Dimension) -> str:
    """Return what to write if a unit of mass was given for one of force, else nothing."""
    for mass, force in _WEIGHED.items():
        other = re.sub(rf"(?<![^\W\d_]){mass}(?![^\W\d_])", force, given)
        if other != given and _turns(factor_of(other)[1], wanted) is not None:
            return f"{mass} is a mass; for its weight, a force, give {number} {other}"
    return ""


def is_quantity(value: Any) -> bool:
    """Say whether a value is a number, or an array, with a unit, as Pint and Astropy have them."""
    known = [vars(kind) for kind in type(value).__mro__] + [getattr(value, "__dict__", {})]

    def has(name: str) -> bool:  # hasattr would let objects of the model look for the nearest of their names
        return any(name in names for names in known)

    return has("unit" if has("to_value") else "units") and (has("magnitude") or has("to_value"))


def si_quantity(value: Any, unit: str, key: str) -> Any:
    """Return a quantity of Pint or Astropy as a float, or a list, in the SI unit that a key needs.

    Raises:
        RefusedError: it has a unit that is not known here, or another dimension.
    """
    if hasattr(value, "to_value"):
        magnitude, given = value.value, value.unit.to_string() or "1"
    else:
        magnitude, given = value.magnitude, format(value.units, "D")
    plain = magnitude.tolist() if hasattr(magnitude, "tolist") else magnitude
    if given in ("", "1", "dimensionless"):
        if unit != "1":
            raise RefusedError(f"this has no unit, {key} needs {_noun(factor_of(unit)[1])}", _advice(unit))
        return plain
    if unit == "1":
        raise RefusedError(f"{key} has no unit", "give a plain number")
    return _scaled(plain, given, unit, key)


def _scaled(plain: Any, given: str, unit: str, key: str) -> Any:
    if isinstance(plain, list):
        return [_scaled(item, given, unit, key) for item in plain]
    return si_value(f"{float(plain)!r} {given}", unit, key)


def si_of(unit: str) -> float:
    """Return the value of a unit in SI, whatever it measures.

    Raises:
        RefusedError: it is no unit.
    """
    return float(factor_of(unit)[0])


def si_and_kind(text: str) -> tuple[float, Dimension] | None:
    """Return a number with a unit as a number in SI, and its powers of m, kg, s, rad and so on; None if it is none.

    None too of what is a frequency in one place and an angular velocity in another, such as 60 rpm.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None or match[2] is None:
        return None
    try:
        factor, kind = factor_of(match[2])
        found = float(Fraction(match[1]) * factor)
    except (RefusedError, OverflowError):
        return None
    return None if dict(without_angle(kind)) == {"second": -1} else (found, kind)


class Measured(float):
    """A number in SI that was given with a unit where it is not known yet what it measures.

    Attributes:
        given: the text, such as "5 mm".
    """

    given: str

    def __new__(cls, value: float, given: str) -> Measured:
        """Make one."""
        found = super().__new__(cls, value)
        found.given = given
        return found

    def __reduce__(self) -> tuple[type[float], tuple[float]]:
        return float, (float(self),)


def waiting(value: Any) -> Any:
    """Return a quantity, as text or as Pint and Astropy have them, as a number that waits for what it measures.

    Raises:
        RefusedError: it has no unit, or one that is not known here.
    """
    if not isinstance(value, str):
        if hasattr(value, "to_value"):
            plain, unit = value.value, value.unit.to_string() or "1"
        else:
            plain, unit = value.magnitude, format(value.units, "D")
        plain = plain.tolist() if hasattr(plain, "tolist") else plain
        if unit in ("", "1", "dimensionless"):
            return plain
        if isinstance(plain, list | tuple):
            return [waiting(f"{float(item)!r} {unit}") for item in plain]
        return waiting(f"{float(plain)!r} {unit}")
    match = _QUANTITY.fullmatch(value)
    if match is None or match[2] is None:
        raise RefusedError("no number with a unit", "give a plain number, in SI, or one with its unit")
    try:
        return Measured(float(Fraction(match[1]) * factor_of(match[2])[0]), value)
    except OverflowError:
        raise RefusedError("larger than any quantity", "give a smaller number") from None


TURN = 6.283185307179586
"""A full turn, rad."""


def _turns(given: Dimension, wanted: Dimension) -> bool | None:
    """Say whether rad/s stands where Hz is needed; None if the dimensions do not fit."""
    if given == wanted:
        return False
    core = dict(without_angle(given))
    if core != dict(without_angle(wanted)):
        return None
    if core == {"second": -1}:  # a frequency, or an angular velocity
        return True if dict(given).get("radian") == 1 and "radian" not in dict(wanted) else None
    return False if core else None


def without_angle(dimension: Dimension) -> Dimension:
    """Return a dimension without the angle, which some write and others do not."""
    return tuple((name, power) for name, power in dimension if name != "radian")


def _noun(dimension: Dimension) -> str:
    """Return what a quantity of the dimension is called."""
    for unit, name in NAMES.items():
        if unit != "1" and factor_of(unit)[1] == dimension:
            return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
    if not dimension:
        return "a plain number"
    symbols = {"meter": "m", "kilogram": "kg", "second": "s", "radian": "rad", "kelvin": "K", "ampere": "A"}
    powers = " ".join(
        symbols.get(name, name) + (f"^{power}" if power != 1 else "") for name, power in dimension
    )
    return f"a quantity in {powers}"


def _advice(unit: str) -> str:
    return f"give a number in {unit}, or one with a unit of this kind"
