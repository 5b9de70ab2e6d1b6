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

from viscorod.model.centrelines.centreline import Centreline
from viscorod.model.centrelines.smooth_curve import SmoothCurve, chebyshev_curve
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import listed
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import TRIPLE, Triple, each, function, sequence, vector
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


class ThroughPoints(_Parametric):
    """A smooth curve through points: a cubic spline over the chord lengths (continuous curvature)."""

    shape: Literal["points"] = Field(default="points", kw_only=True, repr=False)
    points: Annotated[Sequence[Sequence[float]], _points] = Key("at least two", "m")

    @cached_property
    def _smooth(self) -> SmoothCurve:
        from scipy.interpolate import CubicSpline

        points = np.array(self.points)
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if chords.min() < 1e-6 * chords.max():
            index = int(chords.argmin()) + 1
            raise RefusedError(
                "this point is closer to the one before than a millionth of the longest distance",
                "leave one of the two out",
                found=show(self.points[index]),
                at=("points", index),
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
        try:
            return np.array(vector(self.function(u)))
        except RefusedError as error:
            raise RefusedError(
                f"it does not return a point: {error.why}", error.instead, at=("function",)
            ) from None
