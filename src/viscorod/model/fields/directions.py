"""Axes from one direction or two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import listed
from viscorod.model.fields.metadata import accepts, optional
from viscorod.model.fields.values import TRIPLE, Triple, direction, sequence
from viscorod.typing import Floats

__all__ = ["OptionalAxes", "TwoDirections", "axes_from", "axes_of", "columns", "two_directions"]

Pair: TypeAlias = tuple[Triple, Triple]


@accepts(listed(TRIPLE, 2, 2), "2 perpendicular directions, 3 numbers each")
def two_directions(value: Any) -> Pair:
    """Return `value` as two perpendicular unit vectors, global components."""
    items = sequence(value)
    if len(items) != 2:
        raise RefusedError("two directions are needed here", "give [[x, y, z], [x, y, z]], perpendicular")
    first, second = direction(items[0]), direction(items[1])
    cosine = sum(a * b for a, b in zip(first, second, strict=True))
    if abs(cosine) > 1e-6:
        raise RefusedError("the two directions are not perpendicular", "give two that are")
    x = np.array(first)
    y = np.array(second) - cosine * x
    a, b, c = (y / np.linalg.norm(y)).tolist()
    return first, (a, b, c)


@accepts(listed(TRIPLE, 2, 3), "2 perpendicular directions, 3 numbers each")
def axes_of(value: Any) -> Pair:
    """Return `value`, two or three perpendicular directions, as the first two; the third must be x cross y."""
    items = sequence(value)
    if len(items) != 3:
        return two_directions(items)
    pair = two_directions(items[:2])
    if np.abs(np.cross(*pair) - direction(items[2])).max() > 1e-6:
        raise RefusedError(
            "the third direction is not the first cross the second",
            "give right-handed axes, or the first two only",
            found=show(items[2]),
            at=(2,),
        )
    return pair


def columns(pair: Pair | None) -> Floats:
    """Return right-handed axes (3, 3), columns, with the two directions as x and y; the global ones for None."""
    return np.eye(3) if pair is None else np.column_stack([*pair, np.cross(*pair)])


ABOUT = 0.05
"""Cosine by which directions are about as far as others."""


def axes_from(first: Triple) -> Floats:
    """Return right-handed axes (3, 3), columns, with the unit vector `first` as x.

    y is next to the first of the global axes that are about as far from it as the farthest: so the axes of a direction
    along a global axis do not jump where it is changed a little.
    """
    x = np.array(first)
    across = np.abs(x)
    y = np.eye(3)[int(np.argmax(across <= across.min() + ABOUT))]
    y = y - (y @ x) * x
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


TwoDirections = Annotated[GivenAs[Pair, Sequence[Amounts]], two_directions]
OptionalAxes = Annotated[GivenAs[Pair | None, Sequence[Amounts] | None], optional(axes_of)]
