"""Inputs and outputs of small motions, in words: ``"beam.end fz"``, ``"base uz"``, ``"beam@0.1 strain bend_1"``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from viscorod.given_as import GivenAs
from viscorod.model.actions.load import Force, Moment, load
from viscorod.model.actions.load_base import AnyLoad
from viscorod.model.connections.place import place_text
from viscorod.model.fields.definition import RefusedError, did_you_mean
from viscorod.model.fields.forms import TEXT, listed, of_kind
from viscorod.model.fields.metadata import accepts, optional
from viscorod.model.fields.values import each, sequence, word

__all__ = [
    "BASE",
    "InputsField",
    "LoadInput",
    "MotionInput",
    "OptionalInputsField",
    "Output",
    "OutputsField",
    "SignalInput",
]

BASE = "base"
"""The place of an input that moves all supports together."""

AXES = "xyz"
STRAINS = ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")
WRENCHES = ("fx", "fy", "fz", "mx", "my", "mz")
MOTIONS: dict[str, tuple[str, str, int, bool]] = {
    "u": ("displacement", "m", 0, False),
    "r": ("rotation", "rad", 0, True),
    "v": ("velocity", "m/s", 1, False),
    "w": ("angular velocity", "rad/s", 1, True),
    "a": ("acceleration", "m/s^2", 2, False),
    "dw": ("angular acceleration", "rad/s^2", 2, True),
}
"""First letters of a motion word: what it is, its unit, its derivative by time, and whether it turns."""
MOTION_WORDS = tuple(f"{start}{axis}" for start in MOTIONS for axis in AXES)
MOST = 200
"""Inputs or outputs at most."""


@dataclass(frozen=True)
class LoadInput:
    """A load of unit size.

    Attributes:
        label: what it is called; unit: of its factor.
        load: with the wrench of unit factor; given: it was given as a load, not as a text.
    """

    label: str
    unit: str
    load: AnyLoad
    given: bool = False


@dataclass(frozen=True)
class MotionInput:
    """A motion that is prescribed.

    Attributes:
        label: what it is called; unit: its own.
        place: "base", a supported place or the name of a joint with a motor.
        component: of translation and rotation along and about x, y, z, 0 to 5.
        derivative: 0 for displacements, 1 for velocities, 2 for accelerations.
    """

    label: str
    unit: str
    place: str
    component: int
    derivative: int


SignalInput = LoadInput | MotionInput


@dataclass(frozen=True)
class Output:
    """What is read off.

    Attributes:
        label: what it is called; unit: its own.
        place: on a rod or body, or a supported place for reactions.
        quantity: "motion", "strain", "section_force" or "reaction".
        component: 0 to 5: along and about x, y, z; or of a strain.
        derivative: of a motion.
    """

    label: str
    unit: str
    place: str
    quantity: str
    component: int
    derivative: int = 0


def motion_of(text: str) -> tuple[str, int, int] | None:
    """Return unit, component and derivative of a motion word; None if it is none."""
    if text not in MOTION_WORDS:
        return None
    _, unit, derivative, turns = MOTIONS[text[:-1]]
    return unit, AXES.index(text[-1]) + 3 * turns, derivative


def as_input(value: Any) -> SignalInput:
    """Return an input given as a text, a load or the table of one."""
    if isinstance(value, LoadInput | MotionInput):
        return value
    if isinstance(value, AnyLoad | Mapping):
        given = load(value)
        assert isinstance(given, AnyLoad)
        if given.sees_motion:
            raise RefusedError("a load that sees motion is part of the model", "give a force or a moment")
        where = ", ".join(given.places().values()) or getattr(given, "rod", "")
        return LoadInput(" ".join([given.name or given.word, *([where] if where else [])]), "1", given, True)
    place, _, last = word(value).strip().rpartition(" ")
    place = place.strip()
    if place and last in WRENCHES:
        k = WRENCHES.index(last)
        x, y, z = (float(axis == k % 3) for axis in range(3))
        kind = Force if k < 3 else Moment
        return LoadInput(f"{place} {last}", "N" if k < 3 else "N m", kind(place_text(place), (x, y, z)))
    motion = motion_of(last)
    if place and motion is not None:
        return MotionInput(f"{place} {last}", motion[0], place, motion[1], motion[2])
    known = (*WRENCHES, *MOTION_WORDS)
    raise RefusedError(
        "this is no input",
        f"{did_you_mean(last, known)}give a place and a word, such as 'beam.end fz' (force, N), 'beam.end my' (moment, "
        "N m), 'base uz', 'base vz' or 'base az' (motion of all supports)",
    )


def as_output(value: Any) -> Output:
    """Return an output given as a text."""
    if isinstance(value, Output):
        return value
    words = word(value).split()
    motion = motion_of(words[-1]) if words else None
    if len(words) == 2 and motion is not None:
        return Output(" ".join(words), motion[0], place_text(words[0]), "motion", motion[1], motion[2])
    if len(words) == 3 and words[1] in ("strain", "section_force") and words[2] in STRAINS:
        k = STRAINS.index(words[2])
        units = ("1", "1/m") if words[1] == "strain" else ("N", "N m")
        return Output(" ".join(words), units[k > 2], place_text(words[0]), words[1], k)
    if len(words) == 3 and words[1] == "reaction" and words[2] in WRENCHES:
        k = WRENCHES.index(words[2])
        return Output(" ".join(words), ("N", "N m")[k > 2], place_text(words[0]), "reaction", k)
    raise RefusedError(
        "this is no output",
        "give a place and a word, such as 'beam.end uz' (displacement), 'beam.end az' (acceleration), "
        "'beam@0.1 strain bend_1', 'beam@0.1 section_force bend_1' or 'beam.start reaction fz'",
    )


def _several(value: Any, read: Any) -> tuple[Any, ...]:
    single = isinstance(value, str | Mapping | AnyLoad | LoadInput | MotionInput | Output)
    found = each([value] if single else sequence(value), read)
    if not 1 <= len(found) <= MOST:
        raise RefusedError(f"1 to {MOST} are needed here", "give a list", found=f"{len(found)}")
    labels = [one.label for one in found]
    for index, label in enumerate(labels):
        if label in labels[:index]:
            raise RefusedError("the same twice", "give it once, or names to loads", found=label, at=(index,))
    return found


@accepts(listed({"anyOf": [TEXT, of_kind("load")]}, 1), "list of texts or loads, see below")
def _inputs(value: Any) -> tuple[SignalInput, ...]:
    return _several(value, as_input)


@accepts(listed(TEXT, 1), "list of texts, see below")
def _outputs(value: Any) -> tuple[Output, ...]:
    return _several(value, as_output)


Signal: TypeAlias = str | Mapping[str, Any] | AnyLoad | LoadInput | MotionInput | Output
"""As it is given: text, a table, an object."""
InputsField = Annotated[GivenAs[tuple[SignalInput, ...], Signal | Sequence[Signal]], _inputs]
OptionalInputsField = Annotated[
    GivenAs[tuple[SignalInput, ...] | None, Signal | Sequence[Signal] | None], optional(_inputs)
]
OutputsField = Annotated[GivenAs[tuple[Output, ...], Signal | Sequence[Signal]], _outputs]
