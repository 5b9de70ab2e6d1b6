"""Units as text, such as "N/m^2": read by a grammar of names, powers, products and quotients, then by Pint."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

from viscorod.wording import RefusedError, nearest, show

if TYPE_CHECKING:
    from pint import UnitRegistry

__all__ = ["Dimension", "factor_of"]

Dimension: TypeAlias = tuple[tuple[str, Fraction], ...]
"""Powers of m, kg, s, rad and so on, by their names."""

_LONGEST_UNIT = 60
# names, exponents of one digit, and marks: what Pint is given cannot ask it to compute powers of powers
_TOKEN = re.compile(
    r"\s*(?:([^\W\d]+[²³]?|°|%)(?:\s*(?:\^|\*\*)\s*(-?\d)(?!\d|\s*[\^*.])|(-?\d)(?!\d))?|([*/()·])|(1)(?=\s*/))"
)

_TOGETHER = re.compile(r"([kMGmunµμ]?N|kg)(?=(?:mm|cm|m|s|ms)(?![^\W\d²³]))")
"""Units of force and mass written in one piece with what they are multiplied by, as engineers do; Pint reads Nm as the
count of a yarn."""
_JOINED = re.compile(r"(?<=[^\W\d])[-.](?=[^\W\d])")
"""A hyphen or a point between two names, for a product: N-m, kN.m."""

_MORE_UNITS = (
    "rev = turn",
    "mil = turn / 6400",
    "U = turn",
    "cpm = 1 / minute",
    "Msi = 1e6 * psi",
    "psf = pound_force / foot ** 2",
    "pcf = pound / foot ** 3",
    "plf = pound_force / foot",
    "pli = pound_force / inch",
    "kp = kilogram_force",
)
"""What engineers write and Pint has no word, or another meaning, for."""
COMMON = (
    *(
        "m",
        "mm",
        "cm",
        "um",
        "km",
        "in",
        "ft",
        "s",
        "ms",
        "us",
        "min",
        "h",
        "kg",
        "g",
        "t",
        "lb",
        "N",
        "mN",
        "kN",
    ),
    *("MN", "lbf", "Pa", "kPa", "MPa", "GPa", "bar", "psi", "ksi", "rad", "deg", "turn", "Hz", "kHz", "rpm"),
    *("J", "kJ", "mJ", "W"),
)
"""What a misspelt unit is compared with."""


@cache
def factor_of(unit: str) -> tuple[Fraction, Dimension]:
    """Return a unit in SI: its factor, and the powers of m, kg, s, rad and so on.

    Raises:
        RefusedError: it is no unit, or one that is counted from an offset, such as degC.
    """
    import pint

    text, registry = _plain(unit), _registry()
    try:
        parsed = registry.parse_units(text)
        zero = registry.Quantity(Fraction(0), parsed).to_base_units()
        one = registry.Quantity(Fraction(1), parsed).to_base_units()
    except pint.UndefinedUnitError as error:
        names: Any = error.unit_names  # one or several
        name = names if isinstance(names, str) else str(next(iter(names)))
        close = next((word for word in COMMON if word.lower() == name.lower()), None) or nearest(name, COMMON)
        hint = f"did you mean {close}? " if close else ""
        raise RefusedError(
            f"there is no unit {show(name)}", f"{hint}Units are written as in 10 mm, 2 N/m^2"
        ) from None
    except pint.OffsetUnitCalculusError:
        raise RefusedError(f"{unit} is counted from an offset", "give the value in SI") from None
    except Exception:  # Pint reads what the user wrote, and fails in many ways
        raise RefusedError(
            f"{show(unit)} cannot be read as a unit", "write units as in 10 mm, 2 N/m^2"
        ) from None
    if zero.magnitude != 0:
        kelvin = one.is_compatible_with("kelvin")
        raise RefusedError(
            f"{unit} is counted from an offset",
            f"give {'a difference, in K' if kelvin else 'the value in SI'}",
        )
    items: Any = one.unit_items()
    powers = tuple(sorted((str(name), Fraction(power)) for name, power in items if power))
    magnitude: Any = one.magnitude  # a Fraction, as the registry was asked for
    return magnitude, powers


def _plain(unit: str) -> str:
    """Write a unit in the words of Pint, if it is one of names, powers, products and quotients."""
    words: list[str] = []
    at = 0
    unit = _JOINED.sub(" ", re.sub(r"°\s*([CF])\b", r"deg\1", unit)).removesuffix(".")
    if unit.startswith("/"):
        unit = f"1{unit}"
    if len(unit) > _LONGEST_UNIT:
        raise RefusedError("longer than any unit", "write units as in 10 mm, 2 N/m^2")
    divided = False
    while at < len(unit):
        match = _TOKEN.match(unit, at)
        if match is None:
            comma = "write decimals with a point (1.5 MPa); " if re.match(r",\s*\d", unit) else ""
            raise RefusedError(
                f"{show(unit)} cannot be read as a unit",
                f"{comma}write units as in 10 mm, 2 N/m^2, 5 N/(m s)",
            )
        name, power, digit, mark, one = match.groups()
        previous = words[-1] if words else "("
        if (name or mark == "(" or one) and previous not in "*/(":
            if divided and name:
                raise RefusedError(
                    f"{show(unit)} can be read in two ways", "put brackets around what is divided by: N/(m s)"
                )
            words.append("*")
        if mark == "/":
            divided = True
        elif mark in ("(", ")", "*", "·"):
            divided = False
        if name:
            name = {"°": "degree", "%": "percent"}.get(name, name)
            whole = f"{name}**{power or digit}" if power or digit else name
            if together := _TOGETHER.match(whole):
                whole = f"({together[1]}*{whole[together.end(1) :]})"
            words.append(whole)
        else:
            words.append("1" if one else "*" if mark == "·" else mark)
        at = match.end()
        if not unit[at:].strip():
            break
    return "".join(words)


@cache
def _registry() -> UnitRegistry[Any]:
    """Return the units, with exact factors; made when the first quantity is read."""
    import pint

    registry: UnitRegistry[Any] = pint.UnitRegistry(non_int_type=Fraction, on_redefinition="ignore")
    for definition in _MORE_UNITS:
        registry.define(definition)
    return registry
