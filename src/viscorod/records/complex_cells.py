"""Complex numbers in cells of a text: "1.2+3.4j", "(1.2 - 3.4i)", "(1.2, 3.4)", "1.2@45deg", "1.2∠45°"."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

__all__ = ["complex_of", "complex_parts", "is_phase_without_unit", "with_complex_in_one"]

_DIGITS = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
_NUMBER = rf"[-+]?{_DIGITS}"
_RECTANGULAR = re.compile(
    rf"\(?\s*({_NUMBER})\s*([-+])\s*(?:({_DIGITS})\s*\*?\s*[ij]|[ij]\s*\*?\s*({_DIGITS}))\s*\)?"
)
_POLAR = re.compile(rf"\(?\s*({_NUMBER})\s*(?:@|∠|/_)\s*({_NUMBER})\s*(°|deg|degrees|rad)?\s*\)?")
_APART = re.compile(rf"(?<![\w.,)])({_NUMBER})\s+([-+])\s+({_DIGITS})\s*([ij])\b")
_PAIR = re.compile(rf"(^|[\s,;|\"])\(\s*({_NUMBER})\s*[,;]\s*({_NUMBER})\s*\)(?=$|[\s,;|\"])")


def with_complex_in_one(line: str) -> str:
    """Return a line whose complex numbers hold no blanks or commas at which it would be divided."""
    joined = _APART.sub(r"\1\2\3\4", line)
    return _PAIR.sub(lambda one: f"{one[1]}{one[2]}{'' if one[3][0] in '-+' else '+'}{one[3]}j", joined)


def complex_parts(cell: str) -> tuple[str, str, str] | None:
    """Return the texts of two numbers, and "" of real and imaginary part or the unit of a phase; None of others."""
    text = cell.strip().replace("\N{MINUS SIGN}", "-")
    found = _RECTANGULAR.fullmatch(text)
    if found is not None:
        return found[1], found[2] + (found[3] or found[4]), ""
    found = _POLAR.fullmatch(text)
    return None if found is None or not found[3] else (found[1], found[2], found[3])


def is_phase_without_unit(cell: str) -> bool:
    """Return whether a cell is a magnitude with a phase of which nobody says if it is in degrees."""
    found = _POLAR.fullmatch(cell.strip().replace("\N{MINUS SIGN}", "-"))
    return found is not None and not found[3]


def complex_of(parts: tuple[str, str, str], number: Callable[[str], float | None]) -> complex | None:
    """Return the number of what :func:`complex_parts` found, with `number` that reads one; None where it does not."""
    first, second = number(parts[0]), number(parts[1])
    if first is None or second is None:
        return None
    if not parts[2]:
        return complex(first, second)
    return complex(first * np.exp(1j * (second if parts[2] == "rad" else np.radians(second))))
