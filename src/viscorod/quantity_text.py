"""Quantities as text: significant digits, and units with engineering prefixes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

__all__ = ["ROUND_OFF", "number", "per_cent", "prefixed", "quantity", "scaled"]

_POWERS = {24: "Y", 21: "Z", 18: "E", 15: "P", 12: "T", 9: "G", 6: "M", 3: "k", 0: ""}
_POWERS |= {-3: "m", -6: "µ", -9: "n", -12: "p", -15: "f", -18: "a", -21: "z", -24: "y"}
_PLAIN = (0.01, 1e4)
"""Between these the unit needs no prefix."""
ROUND_OFF = 1e-10
"""Numbers below this part of the largest beside them read 0."""


def scaled(unit: str, values: Any) -> tuple[float, str]:
    """Return a factor and the unit with its prefix in which the largest value is between about 1 and 1000.

    From 0.01 to 10000 the plain unit stays. The prefix goes with the first word of the unit, "N m" becomes "mN m"; that
    of "1/m" goes below the line, "1/mm"; kilograms become grams. Powers of units, such as "m^2", have none.
    """
    largest = float(np.max(np.abs(values), initial=0.0))
    first = (
        unit.split("/", maxsplit=1)[0].split(maxsplit=1)[0] if unit.split("/", maxsplit=1)[0].split() else ""
    )
    if largest == 0.0 or not math.isfinite(largest) or _PLAIN[0] <= largest < _PLAIN[1]:
        return 1.0, unit
    if first == "1" and unit.count("/") == 1 and unit.split("/")[1].isalpha():
        power = -_power(largest)
        return 10.0**power, f"1/{_POWERS[power]}{unit.split('/')[1]}"
    if not first.isalpha():
        return 1.0, unit
    if first == "kg":
        power = _power(1e3 * largest)
        return 10.0 ** (3 - power), _POWERS[power] + unit[1:]
    power = _power(largest)
    return 10.0**-power, _POWERS[power] + unit


def prefixed(name: str, values: Any) -> tuple[str, float]:
    """Return a name that may end with a unit, "length [m]", with the prefix of its values, and the factor of these."""
    words, bracket, unit = name.rpartition(" [")
    if not bracket or not unit.endswith("]"):
        return name, 1.0
    factor, unit = scaled(unit[:-1], values)
    return f"{words} [{unit}]", factor


def _power(largest: float) -> int:
    """Return the power of ten of the prefix that a number above 0 takes."""
    power = 3 * math.floor(math.log10(largest * (1.0 + 1e-12)) / 3.0)
    return int(np.clip(power, min(_POWERS), max(_POWERS)))


def quantity(value: float, unit: str, digits: int = 6) -> str:
    """Return a number with its unit: ``quantity(2.5e-6, "m")`` is "2.5 µm"."""
    factor, name = scaled(unit, value)
    return f"{number(factor * value, digits)} {name}".rstrip()


def number(value: float, digits: int = 6, *, size: float = 0.0) -> str:
    """Return a number with significant digits; round-off against ``size`` reads 0, and there is no minus zero."""
    text = f"{0.0 if abs(value) < ROUND_OFF * size else value + 0.0:.{digits}g}"
    return f"{float(text):g}" if "e" in text and 1.0 <= abs(value) < _PLAIN[1] else text  # 30, not 3e+01


def per_cent(value: float, digits: int = 2) -> str:
    """Return a number of per cent, "330 %"."""
    return f"{number(value, digits)} %"
