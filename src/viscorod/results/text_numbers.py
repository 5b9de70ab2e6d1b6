"""Numbers as text: engineering prefixes, significant digits, percentages.

Reports, tables and pictures all take them from here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from viscorod.quantity_text import ROUND_OFF, number, per_cent, prefixed, quantity, scaled

__all__ = [
    "ROUND_OFF",
    "above_rounding",
    "even",
    "number",
    "per_cent",
    "percent",
    "prefixed",
    "quantity",
    "scaled",
]

_NO_PART = 1e-9
"""Damping ratios below it are none: eigenvalues of rotors are that wrong, and no structure damps so little."""
_MOST_DECIMALS = 9
_FEWEST = 3
"""Digits of the smallest number of a column with even decimals."""
_NOTHING = 5e-7
"""Of what is there: a part below it is not told."""


def above_rounding(parts: Any) -> Any:
    """Return parts of one, such as damping ratios, with 0 in place of what rounding leaves of it."""
    return np.where(np.abs(parts) < _NO_PART, 0.0, parts)


def even(values: Iterable[float], digits: int = 6) -> list[str]:
    """Return the numbers of a column with as many decimals each: ``digits`` of the largest, three of the smallest.

    Where that needs more than nine decimals each has ``digits`` significant ones.
    """
    found = [float(value) for value in values]
    largest = max(map(abs, found), default=0.0)
    shown = [0.0 if abs(value) < ROUND_OFF * largest else value + 0.0 for value in found]
    sizes = [abs(value) for value in shown if value]
    if not sizes:
        return ["0" for _ in shown]
    if not all(map(math.isfinite, sizes)):
        return [number(value, digits) for value in shown]
    decimals = max(_decimals(max(sizes), digits), _decimals(min(sizes), _FEWEST), 0)
    if decimals > _MOST_DECIMALS:
        return [number(value, digits) for value in shown]
    return [f"{value:.{decimals}f}" for value in shown]


def _decimals(size: float, digits: int) -> int:
    """Return the decimals with which a number above 0 has so many digits."""
    return digits - 1 - math.floor(math.log10(size * (1.0 + 1e-12)))


def percent(part: float, digits: int = 4) -> str:
    """Return a part in percent, "92.11 %"; nothing where it is next to nothing."""
    return "" if abs(part) < _NOTHING else f"{100.0 * part:.{digits}g} %"
