"""Damping from the measured damping ratio of a mode of the rod."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from viscorod.model.fields.definition import RefusedError, did_you_mean, show
from viscorod.model.fields.forms import POSITIVE, TEXT, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import NonNegative, OptionalName, number, whole_number
from viscorod.model.materials.damping_model import Behaviour, Damping, Elastic

__all__ = ["MOST_MODES", "MeasuredDamping"]

MOST_MODES = 50


@accepts(quantity(bounds={"exclusiveMinimum": 0, "exclusiveMaximum": 1}), "number above 0 and below 1")
def _ratio(value: Any) -> float:
    ratio = number(value)
    if not 1e-12 <= ratio < 1.0:
        raise RefusedError(
            "outside what is allowed", "give a damping ratio above 0 and below 1, such as 0.02"
        )
    return ratio


@accepts(quantity(bounds=POSITIVE), "number > 0")
def _decrement(value: Any) -> float:
    decrement = number(value)
    if not 1e-12 <= decrement <= 1e3:
        raise RefusedError("outside what is allowed", "give ln(x_k/x_k+1) of successive maxima, such as 0.1")
    return decrement


@accepts(
    {"anyOf": [{"type": "integer", "minimum": 1, "maximum": MOST_MODES}, TEXT]},
    f'whole number, 1 to {MOST_MODES}, or a text such as `"bend_1 2"`',
)
def _mode(value: Any) -> int | str:
    if not isinstance(value, str):
        return whole_number(1, MOST_MODES)(value)
    from viscorod.model.sections.stiffness_section import STRAINS  # which imports the materials

    word, _, count = value.partition(" ")
    if word not in STRAINS:
        hint = did_you_mean(word, STRAINS, lambda close: f"'{close} 1'")
        raise RefusedError(
            "no mode is called so",
            f"{hint}give a number, or one of {', '.join(STRAINS)} with one: 'bend_1 2'",
        )
    if not (count.isascii() and count.isdigit() and 1 <= int(count[:9]) <= MOST_MODES):
        raise RefusedError(
            "the number of the mode is missing", f"give 1 to {MOST_MODES} behind the word: '{word} 1'"
        )
    return f"{word} {int(count)}"


class MeasuredDamping(Damping):
    """Kelvin-Voigt damping that gives one mode of the unloaded model a measured damping ratio.

    The times are found when the model is built: the ratio of a mode, phi.D phi/(2 omega phi.M phi), is linear in them.
    They are exact for a model of one material with equal times, and of first order in the ratio otherwise.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["modal"] = Field(default="modal", kw_only=True, repr=False)
    ratio: Annotated[float | None, optional(_ratio)] = Key(
        "damping ratio of the mode, above 0 and below 1", default=None
    )
    logarithmic_decrement: Annotated[float | None, optional(_decrement)] = Key(
        "in place of ratio, ln(x_k/x_k+1) of successive maxima", default=None
    )
    mode: Annotated[int | str, _mode] = Key(
        "number of the mode in order of frequency, rigid motions left out; or a strain word and a "
        'number, "bend_1 2" for the second mode whose elastic energy is mostly that of the strain',
        default=1,
    )
    rod: OptionalName = Key(
        "count only modes with most of their elastic energy in this rod; left out, all modes", default=None
    )
    bulk_to_shear: NonNegative = Key("retardation time in volume change over that in shear", default=1.0)

    @model_validator(mode="after")
    def _one_number(self) -> Self:
        if (self.ratio is None) == (self.logarithmic_decrement is None):
            given = (
                "neither"
                if self.ratio is None
                else f"{show(self.ratio)} and {show(self.logarithmic_decrement)}"
            )
            raise RefusedError(
                "the damping of the mode is one number",
                "give ratio or logarithmic_decrement",
                found=f"given: {given}",
            )
        return self

    @property
    def target(self) -> float:
        """The damping ratio that the mode should have."""
        if self.ratio is not None:
            return self.ratio
        decrement = self.logarithmic_decrement or 0.0
        return decrement / math.hypot(2.0 * math.pi, decrement)

    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return the elastic constants alone: the times follow from the modes."""
        return Behaviour(*elastic, math.nan, math.nan, pending=True)
