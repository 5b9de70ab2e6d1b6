"""Checks the words of a quantity as far as there is no result."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.results.data_schema import AXES
from viscorod.results.quantity_values import FIELDS, HISTORY, OTHERS, REDUCTIONS, SIZE, Word

__all__ = ["checked_words"]

_DECAY = ("damping_ratio", "period", "log_decrement", "amplitude")
_FOLLOWED = ("campbell", "stability")
_WITH_MODES = ("modes", "response", "steady", *_FOLLOWED)
_NUMBERED = {
    "frequency": _WITH_MODES,
    "damping_ratio": _WITH_MODES,
    "load_factor": ("buckling",),
    "critical_speed": ("campbell",),
    "limit": _FOLLOWED,
}
_STATES = ("simulate", "equilibrium", "path", "steady", "modes", "buckling")
_OVER_TIME = ("mean", "rms", HISTORY)


def checked_words(spec: Any, kind: str) -> tuple[Word, ...]:
    """Return the words of a quantity of an analysis (its table in a case file), with what may be left out.

    Raises:
        InputError: they name no number of its results.
    """
    words = _words(spec)
    head, *rest = words
    _one_of(head, (*FIELDS, *OTHERS), "quantity")
    kinds = ("simulate",) if head in ("decrement", "energy") else _NUMBERED.get(str(head), _STATES)
    if head in ("peak", "peak_frequency"):
        kinds = ("response", "periodic")
    if kind not in kinds:
        raise InputError(
            Fault("", str(head), f"a result of [{kind}] has none", f"it goes with {', '.join(kinds)}")
        )
    if head in FIELDS:
        return _checked_field(str(head), rest, kind)
    if head == "decrement":
        return _checked_decay(rest)
    if head == "energy":
        terms = ("kinetic", "elastic", "viscous", "external", "outside", "actuator", "numerical", "total")
        _count(rest, 2, 2, '("energy", "viscous", "last")')
        _one_of(rest[0], terms, "term of the energy account")
        _one_of(rest[1], tuple(REDUCTIONS), "way to make a number of a history")
    elif head in _NUMBERED:
        _checked_number(str(head), rest, kind)
        if isinstance(rest[0], float) and (rest[0] < 1.0 or rest[0] % 1.0):
            raise InputError(Fault("", f"{rest[0]:g}", "numbers count from 1", "give 1 for the first"))
    else:
        _count(rest, 0, 2, f'("{head}", "beam.end uz", "beam.end fz"), output and input')
    return words


def _checked_number(head: str, rest: list[Word], kind: str) -> None:
    """Refuse what is no number or name of a mode, with a speed or load factor where modes are followed along it."""
    named = head in ("frequency", "damping_ratio")
    if named and kind in _FOLLOWED:
        _count(
            rest,
            2,
            2,
            f'("{head}", 1, 10.0): the mode, and a speed in rad/s or a load factor that is computed',
        )
        if not isinstance(rest[1], float):
            raise InputError(Fault("", rest[1], "a speed or load factor is needed here", "give a number"))
        return
    or_name = f', or ("{head}", "bend_1 1"), whose name stands in quotes on a command line'
    _count(rest, 1, 1, f'("{head}", 1)' + (or_name if named else ""))
    if not named and not isinstance(rest[0], float):
        raise InputError(Fault("", rest[0], "they have numbers only", "give 1 for the first"))


def _words(spec: Any) -> tuple[Word, ...]:
    if isinstance(spec, str):
        spec = shlex.split(spec)
    if not isinstance(spec, Sequence) or not spec:
        raise InputError(Fault("", repr(spec)[:60], "no quantity", 'give words such as ("frequency", 1)'))
    return tuple(_word(word) for word in spec)


def _word(word: Any) -> Word:
    if isinstance(word, str):
        try:
            value = float(word)
        except ValueError:
            return word
        return value if math.isfinite(value) else word
    numeric = isinstance(word, int | float | np.integer | np.floating) and not isinstance(word, bool)
    if numeric and math.isfinite(float(word)):
        return float(word)
    raise InputError(Fault("", repr(word)[:60], "neither a word nor a number", "give words in quotes"))


def _one_of(word: Word, known: Sequence[str], what: str) -> None:
    if word not in known:
        raise InputError(Fault("", str(word), f"no {what}", f"give one of {', '.join(known)}"))


def _count(rest: Sequence[Word], least: int, most: int, example: str) -> None:
    if not least <= len(rest) <= most:
        found = " ".join(f"{word:g}" if isinstance(word, float) else word for word in rest) or "nothing"
        several = f"{least} more words are" if least > 1 else "one more word is"
        needed = several if least == most else f"{least} to {most} more words are"
        raise InputError(Fault("", found, f"{needed} needed", f"write {example}"))


def _checked_field(head: str, rest: list[Word], kind: str) -> tuple[Word, ...]:
    components = FIELDS[head]
    example = f'("{head}", "beam.end", {f"{components[1]!r}, " if components else ""}"max")'.replace("'", '"')
    least = 2 if components else 1
    _count(rest, least + (kind == "simulate"), least + 1, example)
    if not isinstance(rest[0], str):
        raise InputError(Fault("", f"{rest[0]:g}", "this is no place", 'name one such as "beam.end"'))
    if components:
        _one_of(rest[1], (*components, SIZE) if len(components) == 3 else components, "component")
    if len(rest) == least:
        rest = [*rest, "last"]
    how = rest[-1]
    if isinstance(how, float) and kind == "simulate" and head != "reaction":
        return (head, *rest)  # a time
    ways = tuple(REDUCTIONS) if kind == "simulate" else tuple(set(REDUCTIONS) - set(_OVER_TIME))
    if kind == "simulate" and head != "reaction":
        ways = (*ways, HISTORY)
    _one_of(how, ways, "way to make a number of a history")
    return (head, *rest)


def _checked_decay(rest: list[Word]) -> tuple[Word, ...]:
    _count(rest, 2, 4, '("decrement", "beam.end", "y", "period", 1)')
    _one_of(rest[1], AXES, "global axis")
    rest = rest if len(rest) > 2 else [*rest, "damping_ratio"]
    _one_of(rest[2], _DECAY, "number of a decay")
    if len(rest) > 3 and not (isinstance(rest[3], float) and rest[3] >= 1.0 and not rest[3] % 1.0):
        raise InputError(Fault("", str(rest[3]), "cycles are numbered from 1", "give 1 for the first"))
    return ("decrement", *rest)
