"""Centre lines that need a quadrature for their arc length: through points, or by any function."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.actions.record_file import LENGTHS, read_points
from viscorod.model.centrelines.centreline import Centreline
from viscorod.model.centrelines.smooth_curve import SmoothCurve, chebyshev_curve
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import TEXT, listed
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import (
    TRIPLE,
    OptionalText,
    Triple,
    each,
    function,
    one_of,
    sequence,
    vector,
)
from viscorod.typing import Floats

__all__ = ["ParametricCurve", "ThroughPoints"]


class _Parametric(Centreline):
    """A centre line that needs a quadrature for its arc length."""

    @cached_property
    @abstractmethod
    def _smooth(self) -> SmoothCurve:
        """Arc length as a function of the parameter, with frames."""

    @property
    def length(self) -> float:
        """Arc length by Gauss quadrature, m."""
        return self._smooth.length

    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """See `Centreline`."""
        return self._smooth.bishop(s)

    def curvature(self, s: Floats) -> Floats:
        """See `Centreline`."""
        return self._smooth.curvature(s)

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        if not 0.0 < self._smooth.length < math.inf:
            raise RefusedError(
                f"the rod would have the length {self._smooth.length:g}", "give a longer curve"
            )
        return self


@accepts(listed(TRIPLE, 2), "list of 2 points or more, 3 numbers each")
def _points(value: Any) -> tuple[Triple, ...]:
    items = sequence(value)
    if len(items) < 2:
        raise RefusedError(
            "a curve needs at least two points", "give a list of points, [[x, y, z], [x, y, z], ...]"
        )
    points = each(items, vector)
    for index, (before, point) in enumerate(pairwise(points), start=1):
        if math.dist(before, point) == 0.0:
            raise RefusedError(
                "the same point twice in a row", "leave one out", found=show(items[index]), at=(index,)
            )
    return points


@accepts(
    {
        "type": "array",
        "items": {"anyOf": [{"type": "integer", "minimum": 1}, TEXT]},
        "minItems": 3,
        "maxItems": 3,
    },
    "3 names or numbers from 1",
)
def _columns(value: Any) -> tuple[str | int, ...]:
    found = tuple(sequence(value))
    if len(found) != 3 or not all(isinstance(one, str | int) and not isinstance(one, bool) for one in found):
        raise RefusedError(
            "three columns are needed here", 'give their names or numbers, such as ["x", "y", "z"]'
        )
    return found


class ThroughPoints(_Parametric):
    """A smooth curve through points: a cubic spline over the chord lengths (continuous curvature).

    The points are listed, or the columns of a file.
    """

    shape: Literal["points"] = Field(default="points", kw_only=True, repr=False)
    points: Annotated[Sequence[Sequence[float]] | None, optional(_points)] = Key(
        "at least two", "m", default=None
    )
    file: OptionalText = Key(
        "in place of the points, a text file with columns, such as line.csv; its path from the case file on",
        default=None,
        kw_only=True,
    )
    columns: Annotated[Sequence[str | int], _columns] = Key(
        "of the file: names or numbers of x, y and z", default=(1, 2, 3), kw_only=True
    )
    unit: Annotated[str | None, optional(one_of(*LENGTHS))] = Key(
        'such as "mm", where the head of the file does not say; m unless given', default=None, kw_only=True
    )

    @cached_property
    def given_points(self) -> tuple[tuple[float, ...], ...]:
        """The points, given or read (n, 3), m."""
        if (self.points is None) == (self.file is None):
            raise RefusedError(
                "a curve goes through points that are listed, or read from a file",
                "give points, or file",
                found="neither" if self.file is None else "both",
                at=("points",) if self.file is None else ("file",),
            )
        if self.file is None:
            return tuple(map(tuple, self.points or ()))
        found: tuple[tuple[float, ...], ...] = read_points(self.file, self.columns, self.unit)
        try:
            return _points(list(found))
        except RefusedError as error:
            row = f" (row {error.at[0] + 1})" if error.at and isinstance(error.at[0], int) else ""
            raise RefusedError(
                f"{error.why}{row}", error.instead, found=show(self.file), at=("file",)
            ) from None

    @cached_property
    def _smooth(self) -> SmoothCurve:
        from scipy.interpolate import CubicSpline

        points = np.array(self.given_points)
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if chords.min() < 1e-6 * chords.max():
            index = int(chords.argmin()) + 1
            raise RefusedError(
                "this point is closer to the one before than a millionth of the longest distance",
                "leave one of the two out",
                found=show(self.given_points[index]),
                at=("points", index) if self.file is None else ("file",),
            )
        knots = np.concatenate([[0.0], np.cumsum(chords / chords.mean())])
        spline = CubicSpline(knots, points)
        first, second = spline.derivative(), spline.derivative(2)
        return SmoothCurve(lambda u: (spline(u), first(u), second(u)), knots)


CurveFunction = Annotated[Callable[[float], Sequence[float] | Floats], function]


class ParametricCurve(_Parametric):
    """A curve given by a Python function (not in case files)."""

    shape: Literal["curve"] = Field(default="curve", kw_only=True, repr=False)
    function: CurveFunction = Key(
        "u in [0, 1] -> position (3 numbers, m); any parametrisation whose speed is never zero. It "
        "must be smooth; it is resolved to 12 digits by piecewise Chebyshev series"
    )

    @cached_property
    def _smooth(self) -> SmoothCurve:
        return SmoothCurve(*chebyshev_curve(self._point))

    def _point(self, u: float) -> Floats:
        point = returned(
            self.function,
            u,
            check=vector,
            name="the function of the curve",
            where=f"at u = {u:.6g}",
            instead="make it return a point, three numbers in m, for every u from 0 to 1",
            at=("function",),
        )
        return np.array(point)
