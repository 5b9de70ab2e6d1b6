"""Settings of a comparison of beam theories."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from viscorod.model.fields.definition import Definition
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import OptionalPositive, Proportion, different, items, one_of, whole_number
from viscorod.solve.planar.planar_theory import THEORIES

__all__ = ["TheorySettings"]


@accepts(None, "list of names of theories")
def _theories(value: Any) -> tuple[str, ...]:
    words = (value,) if isinstance(value, str) else items(value)
    return different(words, one_of(*THEORIES), "theory")


class TheorySettings(Definition):
    """Which theories are compared with the exact one, and over what."""

    duration: OptionalPositive = Key(
        "of the motion from the equilibrium at t = 0- that is compared, {}; left out, that equilibrium alone",
        "s",
        default=None,
    )
    theory: Annotated[str | Sequence[str], _theories] = Key(
        'one of "euler_bernoulli", "timoshenko" and "von_karman", or several of them',
        default=tuple(THEORIES),
    )
    within: Proportion = Key(
        "part of the largest exact displacement and bending moment that a theory may err by to be enough",
        default=0.05,
    )
    frequencies: Annotated[int, whole_number(1, 20)] = Key("number of frequencies in the plane", default=3)
    output_interval: OptionalPositive = Key(
        "of the motion, {}; left out, a two hundredth of the duration", "s", default=None
    )
