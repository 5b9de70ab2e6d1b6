"""Stiffness and damping of joints and springs: numbers, or functions of a coordinate or its rate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeAlias

from viscorod.model.connections.motion_words import MOTIONS, motion_word
from viscorod.model.fields.definition import RefusedError
from viscorod.model.fields.forms import NOT_NEGATIVE, Form, quantity, word_table
from viscorod.model.fields.metadata import Check, accepts
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import amount, entries, number

__all__ = [
    "Damping",
    "DampingTable",
    "Law",
    "Laws",
    "Rest",
    "RestTable",
    "Stiffness",
    "StiffnessTable",
    "law_value",
    "named_law",
    "named_laws",
    "require_law_words",
]

Law: TypeAlias = float | Callable[[float], float]
"""Force (moment) per coordinate or rate, or the force (moment) as a function of it (in Python only)."""
Laws: TypeAlias = Mapping[str, Law]
Rest: TypeAlias = Mapping[str, float]


@accepts(quantity(), "number", "or the force as a function of the elongation")
def stiffness(value: Any) -> Law:
    """Return `value` as a finite number (a negative one is bistable), or as a function of the coordinate."""
    return _checked(value) if callable(value) else amount(value)


@accepts(quantity(bounds=NOT_NEGATIVE), "number >= 0", "or the force as a function of the rate of the length")
def damping(value: Any) -> Law:
    """Return `value` as a number >= 0, or as a function of the rate."""
    if callable(value):
        return _checked(value)
    converted = amount(value)
    if converted < 0.0:
        raise RefusedError("negative damping would feed energy in", "give a number >= 0")
    return converted


def law_value(law: Law, at: float) -> float:
    """Evaluate the force (moment) of a law at a coordinate or rate; N or N m.

    Raises:
        RefusedError: the function did not return a finite number.
    """
    if not callable(law):
        return law * at
    return returned(
        law,
        at,
        check=number,
        name="the function",
        where=f"at {at:.6g}",
        instead="return a finite number everywhere",
    )


def named_laws(laws: Laws, key: str, owner: str) -> dict[str, Law]:
    """Return laws whose functions tell to whom they belong when they fail, such as ``the stiffness uy of ...``."""
    return {word: named_law(law, f"the {key} {word} of {owner}") for word, law in laws.items()}


def named_law(law: Law, name: str) -> Law:
    """Return a law whose function tells its `name` when it fails."""
    if not callable(law):
        return law

    def force(at: float) -> float:
        instead = "return a finite number everywhere"
        return returned(law, at, check=number, name=name, where=f"at {at:.6g}", instead=instead)

    return force


def _checked(law: Callable[[float], float]) -> Law:
    law_value(law, 0.0)
    return law


def _table(
    check: Check[Any], noun: str, python: str = "", bounds: Form | None = None
) -> Check[dict[str, Any]]:
    words = f"table from motion words to {check.words.replace('number', 'numbers')}"

    @accepts(word_table(MOTIONS, bounds=bounds), words, python)
    def parse(value: Any) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise RefusedError(
                f"a table from motions to {noun} is needed here",
                f"give a table such as {{ rz = 0.5 }}, with some of {', '.join(MOTIONS)}",
            )
        parsed = entries(value, motion_word, check)
        return {word: parsed[word] for word in MOTIONS if word in parsed}

    return parse


stiffness_table = _table(stiffness, "stiffnesses", "or functions of the coordinate")
damping_table = _table(damping, "dampings", "or functions of the rate", NOT_NEGATIVE)
rest_table = _table(number, "rest positions")

Stiffness = Annotated[Law, stiffness]
Damping = Annotated[Law, damping]
StiffnessTable = Annotated[Laws, stiffness_table]
DampingTable = Annotated[Laws, damping_table]
RestTable = Annotated[Rest, rest_table]


def require_law_words(
    stiffness: Laws, damping: Laws, rest: Rest, free: tuple[str, ...], what: str, instead: str
) -> None:
    """Refuse laws of motions that are not free, and rests of motions without stiffness.

    Args:
        stiffness, damping, rest: by motion words.
        free: motion words that may have them.
        what: "this joint", and how it treats the others.
        instead: advice for the message.
    """
    for key, table in (("stiffness", stiffness), ("damping", damping), ("rest", rest)):
        for word in table:
            if word not in free:
                raise RefusedError(f"{what} {word}", instead, found=f"a {key} for {word}", at=(key, word))
    for word in rest:
        if word not in stiffness:
            raise RefusedError(
                "a rest position goes with a stiffness",
                f"give stiffness for {word} too, or leave it out of rest",
                found=f"a rest for {word}",
                at=("rest", word),
            )
