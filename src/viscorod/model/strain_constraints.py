"""The words for constrained strains of a rod."""

from __future__ import annotations

from typing import Any

from viscorod.model.fields.definition import RefusedError, did_you_mean
from viscorod.model.fields.forms import TEXT, listed
from viscorod.model.fields.metadata import accepts
from viscorod.model.fields.values import different
from viscorod.model.sections.stiffness_section import STRAINS

__all__ = ["CONSTRAINTS", "constrained_strains", "constraint_words"]

CONSTRAINTS: dict[str, tuple[str, ...]] = {
    "unshearable": ("shear_1", "shear_2"),
    "inextensible": ("stretch",),
    "kirchhoff": ("shear_1", "shear_2", "stretch"),
}
"""Words for sets of strains; a new one is one line here."""


@accepts({"anyOf": [TEXT, listed(TEXT)]}, "text, or list of texts")
def constraint_words(value: Any) -> tuple[str, ...]:
    """Return `value`, one word or a list of words, as a tuple of words."""
    if isinstance(value, str):
        return (_known(value),)
    if not isinstance(value, list | tuple):
        raise RefusedError("a word or a list of words is needed here", f"give {_choice()}")
    return different(value, _known, "constraint")


def constrained_strains(words: tuple[str, ...]) -> tuple[bool, ...]:
    """Return for each of the six strains whether one of the words constrains it."""
    held = {strain for word in words for strain in CONSTRAINTS.get(word, (word,))}
    return tuple(strain in held for strain in STRAINS)


def _known(value: Any) -> str:
    known = (*CONSTRAINTS, *STRAINS)
    if not isinstance(value, str) or value not in known:
        raise RefusedError("no such constraint", f"{did_you_mean(value, known)}give {_choice()}")
    return value


def _choice() -> str:
    return f"{', '.join(map(repr, CONSTRAINTS))} or a list of some of {', '.join(STRAINS)}"
