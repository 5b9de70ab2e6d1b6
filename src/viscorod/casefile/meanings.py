"""What the docstrings of the described classes say of the keys: their meaning and their units.

The documented unit is the only place where the unit of a key stands: tables of the documentation, the JSON Schema
and the conversion of quantities such as "10 mm" are all made from it.
"""

from __future__ import annotations

import inspect
import re
from functools import cache

from viscorod.model.fields.definition import Definition

__all__ = ["meanings", "units_in"]

FILE_WORDS = {
    "; by name only": "",
    ", three numbers or a function of s": "",
    ", or a function of the arc length (in Python only)": "",
    ", six numbers": "",
    ", or functions of the coordinate (in Python only)": "",
    ", or functions of the rate (in Python only)": "",
    ", or the force as a function of the elongation (in Python only)": "",
    ", or the force as a function of the rate of the length (in Python only)": "",
    ": that of a rigid motion, or any (of a rod, in Python only)": "",
    " (see `Centreline.frames`)": "",
    "None lets the program choose": "left out, the program chooses",
    "None stores every step": "left out, every step",
    "None for ": "left out, ",
    "; its path, from the case file on": "; its path from the case file on",
}
"""Turns of the docstrings that concern Python only, and what they become in a case file."""

_SYMBOL = r"(?:kg|m|s|N|Pa|J|Hz|rad)(?:\^\d)?"
_UNIT = re.compile(rf"1|(?:1/)?{_SYMBOL}(?:[ /]{_SYMBOL})*")


@cache
def meanings(kind: type[Definition]) -> dict[str, str]:
    """The arguments in the docstring of a class, in the words of the case file: name -> text."""
    _, _, text = (inspect.getdoc(kind) or "").partition("Args:\n")
    lines = re.sub(r"\n {8,}", " ", text.split("\n\n")[0])
    for python, file in FILE_WORDS.items():
        lines = lines.replace(python, file)
    return dict(re.findall(r"^ {4}(\w+): (.+)$", lines, flags=re.MULTILINE))


def units_in(meaning: str) -> tuple[str, ...]:
    """The units that stand by themselves in a line of a docstring, between marks or around "or".

    "retardation time, s" has one, "N, N m, N m^2" three; a number without a unit has none.
    """
    clauses = re.split(r"[.,;:()]+(?:\s+|$)|\s*\(|\s+or\s+", meaning)
    return tuple(clause for clause in clauses if _UNIT.fullmatch(clause.strip()))
