"""Oblique sections: how they are turned from the frame whose d3 is the tangent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from viscorod.model.fields.metadata import accepts
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import TRIPLE, vector
from viscorod.typing import Floats

__all__ = ["Tilt", "tilt", "tilts"]

Tilt: TypeAlias = Sequence[float] | Callable[[float], Sequence[float]]
"""Rotation vector of sections, or a function of the arc length that returns one; rad."""


@accepts(TRIPLE, "3 numbers", "or a function of the arc length")
def tilt(value: Any) -> Tilt:
    """Return `value` as three finite floats, or as the function that it is."""
    return value if callable(value) else vector(value)


def tilts(given: Tilt, s: Floats) -> Floats:
    """Return the rotation matrices (n, 3, 3) of the sections at `s` (n,), by Rodrigues' formula."""
    vectors = np.array([_at(given, float(at)) for at in s] if callable(given) else [given])
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    none = np.zeros_like(x)
    tilde = np.moveaxis(np.array([[none, -z, y], [z, none, -x], [-y, x, none]]), -1, 0)
    # sin(a)/a and (1 - cos a)/a^2 without division by zero; numpy's sinc has pi in it
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    return np.asarray(np.eye(3) + first * tilde + second * tilde @ tilde)


def _at(given: Callable[[float], Sequence[float]], s: float) -> tuple[float, ...]:
    return returned(
        given,
        s,
        check=vector,
        name="the function of the tilt",
        where=f"at s = {s:.6g} m",
        instead="make it return a rotation vector in rad everywhere",
        at=("tilt",),
    )
