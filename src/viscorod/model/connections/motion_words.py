"""The words for motions and velocities of a place, and tables of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_function_kinds import time_function
from viscorod.model.fields.definition import RefusedError, did_you_mean, show
from viscorod.model.fields.forms import listed, of_kind, word_table
from viscorod.model.fields.metadata import accepts
from viscorod.model.fields.values import different, entries

__all__ = [
    "MOTIONS",
    "VELOCITIES",
    "Motion",
    "fixed_motions",
    "fixed_velocities",
    "motion_functions",
    "named_motions",
    "velocity_functions",
]

MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
"""Displacements (m) and components of the rotation vector from the reference orientation (rad)."""

VELOCITIES = ("v1", "v2", "v3", "w1", "w2", "w3")
"""Velocities (m/s) and angular velocities (rad/s) along the axes d1, d2, d3 of the moving section."""

Motion = Mapping[str, TimeFunction]


def _some_of(words: tuple[str, ...]) -> str:
    return "list of some of " + ", ".join(f'`"{word}"`' for word in words)


def named_motions(motions: Motion, owner: str) -> dict[str, TimeFunction]:
    """Return functions of time that tell to which motion of what they belong when they fail."""
    return {word: function.of(f"the motion {word} of {owner}") for word, function in motions.items()}


def motion_word(value: Any) -> str:
    """Return `value` if it is one of the six motion words."""
    if value not in MOTIONS if isinstance(value, str) else True:
        advice = f"{did_you_mean(value, MOTIONS)}give one of {', '.join(MOTIONS)}"
        raise RefusedError("not a motion", advice, found=show(value))
    return str(value)


def velocity_word(value: Any) -> str:
    """Return `value` if it is one of the six velocity words."""
    if value not in VELOCITIES if isinstance(value, str) else True:
        raise RefusedError("not a velocity", f"give one of {', '.join(VELOCITIES)}", found=show(value))
    return str(value)


@accepts(listed({"enum": list(MOTIONS)}), _some_of(MOTIONS))
def fixed_motions(value: Any) -> tuple[str, ...]:
    """Return `value` if it is a list of motion words, each once; in their order."""
    return tuple(sorted(different(value, motion_word, "motion"), key=MOTIONS.index))


@accepts(listed({"enum": list(VELOCITIES)}), _some_of(VELOCITIES))
def fixed_velocities(value: Any) -> tuple[str, ...]:
    """Return `value` if it is a list of velocity words, each once; in their order."""
    return tuple(sorted(different(value, velocity_word, "velocity"), key=VELOCITIES.index))


@accepts(word_table(MOTIONS, of_kind("time")), "table from motion words to numbers or functions of time")
def motion_functions(value: Any) -> dict[str, TimeFunction]:
    """Check a table from motion words to continuous functions of time; return it in the order of the words."""
    return _functions(value, motion_word, MOTIONS, "motion", "rz")


@accepts(word_table(VELOCITIES, of_kind("time")), "table from velocity words to numbers or functions of time")
def velocity_functions(value: Any) -> dict[str, TimeFunction]:
    """Check a table from velocity words to continuous functions of time; return it in the order of the words."""
    return _functions(value, velocity_word, VELOCITIES, "velocity", "v1")


def _functions(
    value: Any, check: Callable[[Any], str], known: tuple[str, ...], noun: str, example: str
) -> dict[str, TimeFunction]:
    """Check a table of functions of time by their words: they must not jump, and must have derivatives."""
    if not isinstance(value, Mapping):
        plural = noun.replace("y", "ie") + "s"
        raise RefusedError(
            f"a table of {plural} is needed here",
            f"give a table such as {{ {example} = {{ kind = 'ramp', ... }} }}",
        )

    def prescribed(item: Any) -> TimeFunction:
        given = time_function(item)
        if given.jumps:
            raise RefusedError(
                f"a prescribed {noun} must not jump; this one does at t = {given.jumps[0]:.6g} s",
                "give a ramp, or another continuous function of time",
                found=type(given).__name__,
            )
        given.require_derivatives()
        return given

    parsed = entries(value, check, prescribed)
    return {word: parsed[word] for word in known if word in parsed}
